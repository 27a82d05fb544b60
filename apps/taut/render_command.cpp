/// taut render: scene -> deformed surfaces -> Embree -> paths -> film -> image files, frame by frame.

#include "commands.h"
#include "json_text.h"
#include "progress.h"
#include "scene_arguments.h"

#include "study/measures/memory.h"
#include "taut/base/frame_set.h"
#include "taut/base/peak_memory.h"
#include "taut/images/image_codec.h"
#include "taut/render/frame_render.h"
#include "taut/render/image_file.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <unistd.h>

#include <fstream>
#include <iostream>
#include <map>
#include <memory>

namespace taut::app {

namespace {

/// Where a noise level is asked for and no number of samples.
constexpr int kMostByNoise = 1024;

struct RenderArguments {
    SceneArguments scene;
    ModelArguments model;
    std::vector<std::string> outputs;
    int spp = 0;
    std::string time;
    std::optional<std::string> noise;
    std::optional<std::uint32_t> seed;
    bool fixedSeed = false;
    std::string crop;
    std::vector<std::string> aovs;
    bool check = false;
    bool quiet = false;
    std::string progress;
    std::string stats;
};

/// The number that a text begins with, and how many of its characters that is: 0 where there is none.
double leadingNumber(const std::string &text, std::size_t &used) {
    try {
        return std::stod(text, &used);
    } catch (const std::exception &) {
        used = 0;
        return 0;
    }
}

/// "90s", "5m", "1h" or plain seconds.
double parseDuration(const std::string &text) {
    std::size_t used = 0;
    const double value = leadingNumber(text, used);
    const std::string unit = text.substr(used);
    static const std::map<std::string, double> kUnits{{"", 1}, {"s", 1}, {"m", 60}, {"h", 3600}};
    const auto found = kUnits.find(unit);
    if (used == 0 || found == kUnits.end() || !(value > 0) || !std::isfinite(value))
        failInput({"--time"}, quoted(text), "a duration such as 90s, 5m or 1h");
    return value * found->second;
}

/// A relative noise level above 0 and below 1.
double parseNoise(const std::string &text) {
    std::size_t used = 0;
    const double value = leadingNumber(text, used);
    if (used == 0 || used != text.size() || !(value > 0 && value < 1))
        failInput({"--noise"}, quoted(text), "a relative noise level above 0 and below 1 such as 0.01");
    return value;
}

Window parseCrop(const std::string &text, const RenderSettings &render) {
    Window window;
    int used = 0;
    const bool read = std::sscanf(text.c_str(), "%d,%d,%d,%d%n", &window.x0, &window.y0, &window.x1, &window.y1, &used) == 4;
    const bool inside = window.x0 >= 0 && window.y0 >= 0 && window.x1 <= render.width && window.y1 <= render.height;
    if (!read || static_cast<std::size_t>(used) != text.size() || !inside || window.width() <= 0 || window.height() <= 0)
        failInput({"--crop"}, quoted(text),
                  fmt::format("x0,y0,x1,y1 with 0 <= x0 < x1 <= {} and 0 <= y0 < y1 <= {}", render.width, render.height));
    return window;
}

ProgressStyle parseProgress(const RenderArguments &arguments) {
    if (arguments.quiet) return ProgressStyle::None;
    if (arguments.progress.empty()) return isatty(STDERR_FILENO) != 0 ? ProgressStyle::Bar : ProgressStyle::Plain;
    if (arguments.progress == "bar") return ProgressStyle::Bar;
    if (arguments.progress == "plain") return ProgressStyle::Plain;
    if (arguments.progress == "json") return ProgressStyle::Json;
    static constexpr std::string_view kStyles[] = {"bar", "plain", "json"};
    failUnknownName({"--progress"}, arguments.progress, kStyles);
}

void checkOutputs(const std::vector<std::string> &outputs, std::size_t frames) {
    for (const std::string &output : outputs) {
        if (!isImagePath(output)) failInput({"-o"}, quoted(output), "a file name that ends in .exr or .png");
        if (frames > 1 && !hasFramePattern(output))
            failInput({"-o"}, quoted(output), "a frame number such as #### in the name, for more than one frame");
    }
}

/// FNV-1a over the scene file and the overrides: two images with the same hash come from the same description.
std::string sceneHash(const SceneArguments &arguments) {
    std::uint64_t h = 14695981039346656037ULL;
    const auto add = [&](char c) { h = (h ^ static_cast<unsigned char>(c)) * 1099511628211ULL; };
    std::ifstream file(arguments.scene, std::ios::binary);
    for (std::istreambuf_iterator<char> it(file), end; it != end; ++it) add(*it);
    for (const std::string &text : arguments.overrides)
        for (const char c : text + '\n') add(c);
    return fmt::format("{:016x}", h);
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

/// The scene with what the command line says about it.
Scene sceneOf(const RenderArguments &arguments) {
    Scene scene = loadScene(arguments.scene, arguments.quiet);
    if (arguments.spp > 0) scene.render.spp = arguments.spp;
    if (arguments.seed) scene.render.seed = *arguments.seed;
    if (arguments.fixedSeed) scene.render.fixedSeed = true;
    return scene;
}

FrameOptions optionsOf(const RenderArguments &arguments, const RenderSettings &render) {
    FrameOptions options;
    options.spp = render.spp;
    if (!arguments.time.empty()) {
        options.seconds = parseDuration(arguments.time);
        if (arguments.spp == 0) options.spp = 1 << 16;
    }
    if (arguments.noise) {
        options.noise = parseNoise(*arguments.noise);
        if (arguments.spp == 0) options.spp = std::max(options.spp, kMostByNoise);
    }
    if (!arguments.crop.empty()) options.window = parseCrop(arguments.crop, render);
    return options;
}

/// One frame as it was rendered.
struct RenderedFrame {
    int frame = 1;
    FrameResult result;
    StageTimes times; ///< with those of the scene

    [[nodiscard]] double seconds() const { return times.deformation + times.gradient + times.bvh + result.seconds; }
};

void write(const RenderedFrame &rendered, const RenderSettings &render, const std::vector<std::string> &outputs, const std::string &hash) {
    const Film &film = rendered.result.film;
    const Image image = imageOf(film, render);
    const Metadata metadata{{"taut:version", TAUT_VERSION},
                            {"taut:spp", std::to_string(film.samples())},
                            {"taut:meanSpp", fmt::format("{:.3f}", film.meanSamples())},
                            {"taut:sampleRange", fmt::format("0-{}", film.samples() - 1)},
                            {"taut:seed", std::to_string(render.seed)},
                            {"taut:frame", std::to_string(rendered.frame)},
                            {"taut:renderSeconds", fmt::format("{:.3f}", rendered.seconds())},
                            {"taut:sceneHash", hash}};
    for (const std::string &output : outputs) writeImage(pathOfFrame(output, rendered.frame), image, metadata);
}

nlohmann::json toJson(const RenderedFrame &rendered) {
    return {{"frame", rendered.frame},       {"spp", rendered.result.film.samples()}, {"mean_spp", rendered.result.film.meanSamples()},
            {"seconds", rendered.seconds()}, {"times", toJson(rendered.times)},       {"counts", toJson(rendered.result.counts)}};
}

int render(RenderArguments &arguments) {
    const auto threads = limitThreads(arguments.scene.threads);
    const ProgressStyle style = parseProgress(arguments);
    const std::vector<std::string_view> aovNames(arguments.aovs.begin(), arguments.aovs.end());
    const std::vector<Aov> aovs = aovsNamed(aovNames, "--aov");
    Scene loaded = sceneOf(arguments);
    if (!arguments.check) preloadImageCodec();
    const RenderSettings render = loaded.render;
    const std::vector<int> &frames = render.frames;
    if (arguments.outputs.empty()) arguments.outputs = {"out/####.exr"};
    checkOutputs(arguments.outputs, frames.size());
    FrameOptions options = optionsOf(arguments, render);
    options.aovs = aovs;
    // How many samples there will be is not known: light is not weighed against noise.
    if ((options.seconds || options.noise) && !arguments.model.tolerance) arguments.model.tolerance = kDefaultTolerance;

    PlannedScene planned = planFor(loaded, arguments.model);
    RenderScene ready(std::move(loaded), std::move(planned.plan), frames.size() > 1, std::move(planned.surfaces));
    Progress progress(style, static_cast<int>(frames.size()));
    options.progress = [&](double share) {
        progress.update(share);
        return true;
    };
    const std::string hash = sceneHash(arguments.scene);
    nlohmann::json statistics{{"scene", arguments.scene.scene}, {"version", TAUT_VERSION}, {"frames", nlohmann::json::array()}};
    for (const int frame : frames) {
        progress.startFrame(frame);
        StageTimes times;
        ready.setFrame(frame, times);
        if (arguments.check) continue;
        options.seed = frameSeed(render.seed, frame, render.fixedSeed);
        RenderedFrame rendered{frame, renderFrame(ready, options), times};
        rendered.times += rendered.result.times;
        write(rendered, render, arguments.outputs, hash);
        progress.finishFrame(frame, pathOfFrame(arguments.outputs.front(), frame), rendered.seconds());
        statistics["frames"].push_back(toJson(rendered));
        if (rendered.result.counts.notFinite > 0 && !arguments.quiet)
            std::cerr << "taut: warning: frame " << frame << ": " << rendered.result.counts.notFinite
                      << " samples were not finite and were left out" << std::endl;
    }
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
    addSceneArguments(*command, arguments->scene);
    addModelArguments(*command, arguments->model);
    command->add_option("-o,--output", arguments->outputs, "Images: out/####.exr or .png; may be given more than once")
        ->allow_extra_args(false);
    command->add_option("--spp", arguments->spp, "Samples per pixel (default: the scene's)")->check(CLI::Range(1, 1 << 24));
    command->add_option("--time", arguments->time, "Stop each frame after this long: 90s, 5m, 1h");
    command->add_option("--noise", arguments->noise,
                        "Adaptive sampling: stop where the standard error of a pixel is this share of its luminance (0.01); "
                        "--spp is the upper bound (default: 1024, or the scene's if that is more)");
    command->add_option("--seed", arguments->seed, "Seed of all random numbers");
    command->add_flag("--fixed-seed", arguments->fixedSeed, "The same random numbers in every frame");
    command->add_option("--crop", arguments->crop, "Render only the pixels x0,y0,x1,y1 (x1, y1 excluded)");
    command
        ->add_option("--aov", arguments->aovs,
                     "Extra channels: depth, albedo, normal, shading_normal, facet_normal, position, rest_position, uv, m, lean, stretch, alpha, all")
        ->delimiter(',')
        ->allow_extra_args(false);
    command->add_flag("--check", arguments->check, "Read and check everything, evaluate every frame, render nothing");
    command->add_flag("-q,--quiet", arguments->quiet, "Print errors only");
    command->add_option("--progress", arguments->progress, "bar, plain or json (default: bar on a terminal, else plain)");
    command->add_option("--stats", arguments->stats, "Write times, rays and memory to this JSON file");
    command->callback([&run, arguments] { run = [arguments] { return render(*arguments); }; });
}

} // namespace taut::app
