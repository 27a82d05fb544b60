/// taut render: scene -> deformed surfaces -> Embree -> paths -> film -> image files, frame by frame.

#include "commands.h"
#include "denoised_image.h"
#include "image_output.h"
#include "interruption.h"
#include "json_text.h"
#include "movie.h"
#include "plan_table.h"
#include "reached_error.h"
#include "render_arguments.h"

#include "study/measures/memory.h"
#include "taut/base/content_hash.h"
#include "taut/base/file_bytes.h"
#include "taut/base/frame_set.h"
#include "taut/images/image_codec.h"
#include "taut/render/image_file.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <filesystem>
#include <iostream>
#include <memory>

namespace taut::app {

namespace {

namespace fs = std::filesystem;

/// Of the scene file and the overrides: two images with the same hash come from the same description.
std::string sceneHash(const SceneArguments &arguments) {
    std::string text = readFileBytes(arguments.scene);
    for (const std::string &define : arguments.overrides) text += '\n' + define;
    return contentHash(text);
}

nlohmann::json toJson(const StageTimes &times) {
    return {{"deformation_s", times.deformation},
            {"gradient_s", times.gradient},
            {"bvh_s", times.bvh},
            {"camera_rays_s", times.cameraRays},
            {"scattered_rays_s", times.scatteredRays},
            {"shadow_rays_s", times.shadowRays},
            {"shading_s", times.shading},
            {"film_s", times.film}};
}

nlohmann::json toJson(const RayCounts &counts) {
    return {{"paths", counts.paths},
            {"camera_rays", counts.camera},
            {"scattered_rays", counts.scattered},
            {"shadow_rays", counts.shadow},
            {"not_finite", counts.notFinite}};
}

/// The files that are asked for: patterns of images, and movies.
struct Outputs {
    std::vector<std::string> images, movies;
    [[nodiscard]] std::vector<std::string> all() const {
        std::vector<std::string> paths = images;
        paths.insert(paths.end(), movies.begin(), movies.end());
        return paths;
    }
};

/// Movies that are there are left out where that is asked for. Throws InputError where a name is of neither kind, or a movie can't be made.
Outputs outputsOf(const RenderArguments &arguments, const std::optional<Shard> &shard, std::size_t frames) {
    Outputs outputs;
    for (const std::string &path : arguments.outputs) (isMoviePath(path) ? outputs.movies : outputs.images).push_back(path);
    if (arguments.outputs.empty()) outputs.images = {"out/####.exr"};
    checkOutputs(outputs.images, frames);
    for (const std::string &movie : outputs.movies) {
        if (shard || !arguments.only.empty())
            failInput({"-o"}, quoted(movie) + " for a part of the frames", "images, of which a movie can be made when they are all there");
        checkMovie(movie);
    }
    if (arguments.skipExisting) std::erase_if(outputs.movies, [](const std::string &movie) { return areThere({movie}); });
    return outputs;
}

/// What the frames of one call have in common, and how each is named and told from others.
class FrameNames {
  public:
    FrameNames(const RenderArguments &arguments, const Outputs &outputs, const Scene &scene, const FrameOptions &options,
               const std::optional<Shard> &shard)
        : arguments_(arguments), outputs_(outputs), scene_(scene), options_(options), sceneHash_(sceneHash(arguments.scene)) {
        if (!shard || shard->by == ShardBy::Frames) return;
        part_ = {shard->by == ShardBy::Samples ? SplitBy::Samples : SplitBy::Rows, shard->index, shard->count};
        isShard_ = true;
    }

    [[nodiscard]] bool isShard() const { return isShard_; }
    [[nodiscard]] const FramePart &part() const { return part_; }

    /// The files that a frame ends in: its images, or its shard.
    [[nodiscard]] std::vector<std::string> results(int frame) const {
        std::vector<std::string> paths = pathsOf(outputs_.images, frame);
        const std::vector<int> &frames = scene_.render.frames;
        const auto number = static_cast<std::size_t>(std::find(frames.begin(), frames.end(), frame) - frames.begin());
        for (const std::string &movie : outputs_.movies) paths.push_back(pictureOfMovie(movie, number));
        if (isShard_) paths = {fmt::format("{}.{}-of-{}.shard", paths.front(), part_.index, part_.count)};
        return paths;
    }
    [[nodiscard]] std::string checkpoint(int frame) const { return results(frame).front() + ".checkpoint"; }

    /// Reads all the files that the scene is made of, once.
    [[nodiscard]] SavedHead head(int frame, std::uint32_t seed) {
        if (files_.empty()) files_ = inputFacts(scene_);
        SavedHead head = label(frame);
        FrameOptions whole = options_;
        whole.seed = seed;
        head.facts = settingFacts(scene_, whole, frame);
        std::string overrides;
        for (const std::string &define : arguments_.scene.overrides) overrides += (overrides.empty() ? "" : " ") + define;
        head.facts.emplace_back("-D", overrides.empty() ? "none" : overrides);
        head.facts.emplace_back("ground", scene_.render.ground ? "under it" : "none");
        head.facts.emplace_back("model", arguments_.model.model.empty() ? "auto" : arguments_.model.model);
        head.facts.emplace_back("error", arguments_.model.error ? formatNumber(*arguments_.model.error) : "any");
        head.facts.emplace_back("tolerance", arguments_.model.tolerance ? formatNumber(*arguments_.model.tolerance) : "by default");
        if (arguments_.denoiseFrames) head.facts.emplace_back("denoising over", "frames");
        head.facts.insert(head.facts.end(), files_.begin(), files_.end());
        return head;
    }

    /// The head without its facts.
    [[nodiscard]] SavedHead label(int frame) const {
        SavedHead head;
        head.part = part_;
        head.frame = frame;
        head.width = scene_.render.width;
        head.height = scene_.render.height;
        head.window = options_.window.empty() ? Window{0, 0, head.width, head.height} : options_.window;
        head.image = scene_.image;
        head.metadata = frameMetadata(scene_, frame, options_.layers);
        head.metadata.emplace_back("taut:sceneHash", sceneHash_);
        if (options_.denoiseBlock > 0) markDenoised(head.metadata, arguments_.denoiseFrames);
        return head;
    }

  private:
    const RenderArguments &arguments_;
    const Outputs &outputs_;
    const Scene &scene_;
    const FrameOptions &options_;
    std::string sceneHash_;
    FramePart part_;
    bool isShard_ = false;
    FrameFacts files_;
};

/// `times`: those of the scene at this frame.
nlohmann::json toJson(int frame, const RunningFrame &finished, StageTimes times) {
    const double seconds = times.deformation + times.gradient + times.bvh + finished.seconds();
    times += finished.times();
    return {{"frame", frame},     {"spp", finished.film().samples()}, {"mean_spp", finished.film().meanSamples()},
            {"seconds", seconds}, {"times", toJson(times)},           {"counts", toJson(finished.counts())}};
}

void warn(const RenderArguments &arguments, const std::string &line) {
    if (!arguments.quiet) std::cerr << "taut: warning: " << line << std::endl;
}

int render(RenderArguments &arguments) {
    setExitCodeOfStop(kResumable);
    const auto threads = limitThreads(arguments.scene.threads);
    const ProgressStyle style = progressStyleOf(arguments);
    const CheckpointOptions checkpoints = checkpointsOf(arguments);
    const FilmContents contents = filmContentsNamed(arguments.aovs, "--aov");
    Scene loaded = sceneOf(arguments);
    if (!arguments.check && arguments.shard.empty()) preloadImageCodec(); // a shard may end in no image
    const RenderSettings render = loaded.render;
    FrameOptions options = optionsOf(arguments, render);
    options.aovs = contents.aovs;
    options.layers = contents.layers;
    if (arguments.cryptoRanks > 0) options.layers.ranks = arguments.cryptoRanks;
    const std::optional<Shard> shard = shardOf(arguments, options, render.frames.size());
    const std::vector<int> frames = framesOf(arguments, shard, render.frames);
    checkDenoiseFrames(arguments, shard, render.fixedSeed);
    const Outputs outputs = outputsOf(arguments, shard, render.frames.size());
    if (outputs.images.empty() && outputs.movies.empty()) return 0; // every movie is there
    loaded.image = imageSettingsOf(arguments.image, loaded.image, outputs.all());
    checkCompressionOf(loaded.image.exrCompression, options.layers.channelNames());
    fixTolerance(arguments, options);

    const bool shares = options.picture && !shard && mayShare(options, render);
    PlannedScene planned = planFor(loaded, arguments.model, false, shares);
    if (arguments.verbose) std::cerr << planTable(loaded, planned.plan) << pilotLines(planned.plan) << std::flush;
    if (planned.plan.budget) {
        options.picture = PictureGoal{static_cast<double>(planned.plan.budget->noise), planned.plan.budget->firstSamples};
        options.shares = shares;
    }
    RenderScene ready(std::move(loaded), std::move(planned.plan), render.frames.size() > 1, std::move(planned.surfaces));
    std::optional<TevDisplay> display;
    if (!arguments.display.empty() && !arguments.check) display.emplace(arguments.display);
    FrameNames names(arguments, outputs, ready.scene(), options, shard);
    Progress progress(style, static_cast<int>(frames.size()));
    nlohmann::json statistics{{"scene", arguments.scene.scene}, {"version", TAUT_VERSION}, {"frames", nlohmann::json::array()}};
    std::optional<FrameDenoiser> denoiser;
    if (options.denoiseBlock > 0) denoiser.emplace(arguments.denoiseFrames);
    std::optional<FrameBefore> before; // of the frames that are denoised by the ones before them
    bool begun = false;
    for (const int frame : frames) {
        progress.startFrame(frame);
        const std::vector<std::string> results = names.results(frame);
        if (arguments.skipExisting && !arguments.check && areThere(results)) {
            progress.tell("skipped", 1, results.front());
            continue;
        }
        StageTimes times;
        if (arguments.denoiseFrames && frame != frames.front()) before.emplace(ready);
        ready.setFrame(frame, times);
        if (arguments.check) continue;
        FrameJob job{optionsOfPart(options, names.part(), render), names.checkpoint(frame), {}, display ? &*display : nullptr};
        job.options.before = before ? &*before : nullptr;
        job.options.seed = frameSeed(render.seed, frame, render.fixedSeed);
        job.head = [&] { return names.head(frame, job.options.seed); };
        if (!begun && (checkpoints.interval || checkpoints.resume)) removeAbandonedFiles(fs::path(results.front()).parent_path().string());
        if (!begun) checkWritable(results.front());
        const bool isFirst = !begun;
        begun = true;
        if (!checkpoints.resume && checkpoints.interval && fs::exists(job.checkpoint))
            warn(arguments, job.checkpoint + ": is there, but without --resume the frame begins anew and replaces it");
        const FrameEnd end = runFrame(ready, job, checkpoints, progress, [&](RunningFrame &finished) {
            if (names.isShard())
                finished.save(results.front());
            else
                writeImages(names.label(frame), finished.film(), results, denoiser ? &*denoiser : nullptr);
            statistics["frames"].push_back(toJson(frame, finished, times));
            const std::optional<ReachedError> reached = reachedError(ready.plan(), finished.reached());
            if (reached) statistics["frames"].back()["error"] = toJson(*reached);
            progress.finishFrame(frame, results.front(), statistics["frames"].back()["seconds"], reached ? textOf(*reached) : "");
            if (const std::uint64_t count = finished.counts().notFinite; count > 0)
                warn(arguments, fmt::format("frame {}: {} samples were not finite and were left out", frame, count));
        });
        if (!end.done && isFirst && end.secondsLate > 0)
            warn(arguments, fmt::format("--time-limit {} was over {:.2g} s before the first sample, expected a longer one; the frame got "
                                        "further by a sample a pixel at most",
                                        arguments.timeLimit, end.secondsLate));
        if (end.done && end.cause != nullptr && frame != frames.back()) progress.stopped(end.cause, 1, "");
        if (end.cause != nullptr && (!end.done || frame != frames.back())) return kResumable;
    }
    for (const std::string &movie : outputs.movies)
        if (!arguments.check) writeMovie(movie, render.fps);
    statistics["peak_mb"] = chart::peakMegabytes();
    if (arguments.check) {
        if (!arguments.quiet) std::cout << arguments.scene.scene << ": ok, " << frames.size() << " frames" << std::endl;
    } else if (!arguments.stats.empty()) {
        writeTextFile(arguments.stats, jsonText(statistics, 2) + "\n");
    }
    return 0;
}

} // namespace

void addRender(CLI::App &parent, Run &run) {
    auto arguments = std::make_shared<RenderArguments>();
    CLI::App *command = parent.add_subcommand("render", "Render frames of a scene");
    addRenderArguments(*command, *arguments);
    command->callback([&run, arguments] { run = [arguments] { return render(*arguments); }; });
}

} // namespace taut::app
