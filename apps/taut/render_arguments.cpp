#include "render_arguments.h"

#include "commands.h"

#include "taut/base/frame_set.h"
#include "taut/render/denoise.h"
#include "taut/scene/ground.h"

#include <fmt/format.h>

#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <map>

namespace taut::app {

namespace {

/// Where a noise level is asked for and no number of samples.
constexpr int kMostByNoise = 1024;
constexpr int kMostShards = 1000000;

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
double parseDuration(const char *option, const std::string &text) {
    std::size_t used = 0;
    const double value = leadingNumber(text, used);
    const std::string unit = text.substr(used);
    static const std::map<std::string, double> kUnits{{"", 1}, {"s", 1}, {"m", 60}, {"h", 3600}};
    const auto found = kUnits.find(unit);
    if (used == 0 || found == kUnits.end() || !(value > 0) || !std::isfinite(value))
        failInput({option}, quoted(text), "a duration such as 90s, 5m or 1h");
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

} // namespace

ProgressStyle progressStyleOf(const RenderArguments &arguments) {
    if (arguments.quiet) return ProgressStyle::None;
    if (arguments.progress.empty()) return isatty(STDERR_FILENO) != 0 ? ProgressStyle::Bar : ProgressStyle::Plain;
    if (arguments.progress == "bar") return ProgressStyle::Bar;
    if (arguments.progress == "plain") return ProgressStyle::Plain;
    if (arguments.progress == "json") return ProgressStyle::Json;
    if (arguments.progress == "openjd") return ProgressStyle::OpenJobDescription;
    static constexpr std::string_view kStyles[] = {"bar", "plain", "json", "openjd"};
    failUnknownName({"--progress"}, arguments.progress, kStyles);
}

Scene sceneOf(const RenderArguments &arguments) {
    Scene scene = loadScene(arguments.scene, arguments.quiet);
    if (arguments.spp > 0) scene.render.spp = arguments.spp;
    if (arguments.seed) scene.render.seed = *arguments.seed;
    if (arguments.fixedSeed) scene.render.fixedSeed = true;
    if (arguments.noGround) scene.render.ground = false;
    Warnings turned;
    standOnGround(scene, turned);
    if (!arguments.quiet) printWarnings(turned);
    return scene;
}

void fixTolerance(RenderArguments &arguments, const FrameOptions &options) {
    if ((options.seconds || options.noise) && !arguments.model.tolerance) arguments.model.tolerance = kDefaultTolerance;
}

FrameOptions optionsOf(const RenderArguments &arguments, const RenderSettings &render) {
    FrameOptions options;
    options.spp = render.spp;
    options.independent = arguments.independent;
    if (!arguments.time.empty()) {
        options.seconds = parseDuration("--time", arguments.time);
        if (arguments.spp == 0) options.spp = 1 << 16;
    }
    if (arguments.noise) {
        options.noise = parseNoise(*arguments.noise);
        if (arguments.spp == 0) options.spp = std::max(options.spp, kMostByNoise);
    }
    if (arguments.model.error) {
        if (arguments.noise || !arguments.time.empty())
            failInput({"--error"}, std::string(arguments.noise ? "--noise" : "--time") + " beside it", "one goal for the samples");
        options.picture = PictureGoal{static_cast<double>(*arguments.model.error), 4}; // until the plan has split it
        if (arguments.spp == 0) options.spp = 1 << 16;
        if (options.spp < 2) failInput({"--spp"}, "1 beside --error", "at least 2 samples, or none: one tells nothing of noise");
    }
    if (!arguments.crop.empty()) options.window = parseCrop(arguments.crop, render);
    if (arguments.denoise || arguments.denoiseFrames)
        options.denoiseBlock = denoiseBlockOf(options.spp, !options.seconds && !options.noise && !options.picture);
    return options;
}

void checkDenoiseFrames(const RenderArguments &arguments, const std::optional<Shard> &shard, bool fixedSeed) {
    if (!arguments.denoiseFrames) return;
    const auto refuse = [](const char *what) {
        failInput({"--denoise-frames"}, std::string(what) + " beside it",
                  "all frames in their order, or --denoise, which takes each for itself");
    };
    if (arguments.skipExisting) refuse("--skip-existing");
    if (!arguments.only.empty()) refuse("--only");
    if (shard && shard->by == ShardBy::Frames) refuse("shards of frames");
    if (fixedSeed) refuse("a fixed seed");
}

CheckpointOptions checkpointsOf(const RenderArguments &arguments) {
    CheckpointOptions options;
    options.resume = arguments.resume;
    if (!arguments.checkpoint.empty()) options.interval = parseDuration("--checkpoint", arguments.checkpoint);
    if (!arguments.timeLimit.empty())
        options.deadline = Clock::now() + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(
                                              std::min(parseDuration("--time-limit", arguments.timeLimit), 1e9)));
    return options;
}

std::optional<Shard> shardOf(const RenderArguments &arguments, const FrameOptions &options, std::size_t frames) {
    if (arguments.shard.empty()) {
        if (!arguments.shardBy.empty()) failInput({"--shard-by"}, "no --shard beside it", "--shard i/n");
        return std::nullopt;
    }
    Shard shard;
    int used = 0;
    const bool read = std::sscanf(arguments.shard.c_str(), "%d/%d%n", &shard.index, &shard.count, &used) == 2;
    if (!read || static_cast<std::size_t>(used) != arguments.shard.size() || shard.index < 1 || shard.index > shard.count ||
        shard.count > kMostShards)
        failInput({"--shard"}, quoted(arguments.shard), fmt::format("i/n with 1 <= i <= n <= {}, such as 3/8", kMostShards));
    const bool decidesForItself = options.noise || options.picture || options.seconds; // how many samples a frame gets
    if (arguments.shardBy == "frames") return shard;
    if (arguments.shardBy == "samples" || arguments.shardBy == "rows") {
        shard.by = arguments.shardBy == "samples" ? ShardBy::Samples : ShardBy::Rows;
    } else if (arguments.shardBy.empty() || arguments.shardBy == "auto") {
        const bool enoughFrames = frames >= static_cast<std::size_t>(shard.count) || (decidesForItself && frames > 1);
        shard.by = enoughFrames ? ShardBy::Frames : options.spp >= shard.count ? ShardBy::Samples : ShardBy::Rows;
    } else {
        static constexpr std::string_view kWays[] = {"auto", "frames", "samples", "rows"};
        failUnknownName({"--shard-by"}, arguments.shardBy, kWays);
    }
    if (shard.by != ShardBy::Frames && shard.count > 1 && decidesForItself)
        failInput({"--shard"}, "--error, --noise or --time, which decide about all samples of a frame together",
                  "--spp, or --shard-by frames");
    return shard;
}

std::vector<int> framesOf(const RenderArguments &arguments, const std::optional<Shard> &shard, const std::vector<int> &frames) {
    std::vector<int> chosen = frames;
    if (!arguments.only.empty()) {
        chosen = parseFrameSet(arguments.only, {"--only"});
        for (const int frame : chosen)
            if (std::find(frames.begin(), frames.end(), frame) == frames.end())
                failInput({"--only"}, fmt::format("frame {}", frame),
                          fmt::format("some of the {} frames from {} to {}", frames.size(), frames.front(), frames.back()));
    }
    if (!shard || shard->by != ShardBy::Frames) return chosen;
    std::vector<int> own;
    for (std::size_t i = static_cast<std::size_t>(shard->index) - 1; i < chosen.size(); i += static_cast<std::size_t>(shard->count))
        own.push_back(chosen[i]);
    return own;
}

void addSampleArguments(CLI::App &command, RenderArguments &arguments) {
    command.add_option("--spp", arguments.spp, "Samples per pixel (default: the scene's)")->check(CLI::Range(1, 1 << 24));
    command.add_option("--time", arguments.time, "Stop each frame after this long: 90s, 5m, 1h");
    command.add_option("--noise", arguments.noise,
                       "Adaptive sampling: stop where the standard error of a pixel is this share of its luminance (0.01); "
                       "--spp is the upper bound (default: 1024, or the scene's if that is more)");
    command.add_option("--seed", arguments.seed, "Seed of all random numbers");
    command.add_flag("--no-ground", arguments.noGround, "A file without a scene stands on no ground: the mesh alone in the dim studio");
    command.add_flag("--fixed-seed", arguments.fixedSeed, "The same random numbers in every frame");
    command.add_flag("--independent", arguments.independent,
                     "Samples of a pixel know nothing of one another: noisier, but variance is without bias and t-tests hold");
    command.add_option("--crop", arguments.crop, "Render only the pixels x0,y0,x1,y1 (x1, y1 excluded)");
    command
        .add_option("--aov", arguments.aovs,
                    "Extra channels: depth, albedo, normal, shading_normal, facet_normal, position, rest_position, uv, m, lean, stretch, "
                    "alpha, all (of these); crypto_object, crypto_material, lights, samples, variance")
        ->delimiter(',')
        ->allow_extra_args(false);
    command
        .add_option("--crypto-ranks", arguments.cryptoRanks,
                    "Objects, or materials, that Cryptomatte tells apart in a pixel: 2, 4, ... 32 (default: 6)")
        ->check(CLI::IsMember({2, 4, 6, 8, 10, 12, 14, 16, 18, 20, 22, 24, 26, 28, 30, 32}));
}

void addRenderArguments(CLI::App &command, RenderArguments &arguments) {
    addSceneArguments(command, arguments.scene);
    addModelArguments(command, arguments.model);
    command
        .add_option("-o,--output", arguments.outputs,
                    "Images: out/####.exr or .png; movies: out/shot.mp4, .webm or .gif; may be given more than once")
        ->allow_extra_args(false);
    addImageArguments(command, arguments.image);
    command.add_option("--only", arguments.only, "Render only these of the frames; the plan looks at all of them");
    addSampleArguments(command, arguments);
    command.add_flag("--denoise", arguments.denoise,
                     "Take the noise out of the picture; the unfiltered one stays in the EXR (Noisy.R, G, B)");
    command.add_flag("--denoise-frames", arguments.denoiseFrames, "As --denoise, with what the frames before show of each point as well");
    command.add_option("--checkpoint", arguments.checkpoint, "Keep what there is in FRAME.checkpoint this often: 90s, 5m, 1h");
    command.add_flag("--resume", arguments.resume, "Go on from the checkpoint of a frame, where there is one");
    command.add_flag("--skip-existing", arguments.skipExisting, "Leave out frames whose images are there");
    command.add_option("--time-limit", arguments.timeLimit, "Stop after this long, with a checkpoint and exit code 75: 90s, 5m, 1h");
    command.add_option("--shard", arguments.shard, "Render part i of n: 3/8; taut merge puts the parts of frames together");
    command.add_option("--shard-by", arguments.shardBy, "frames, samples, rows or auto (default: auto)");
    command.add_flag("--check", arguments.check, "Read and check everything, evaluate every frame, render nothing");
    command.add_flag("-q,--quiet", arguments.quiet, "Print errors only");
    command.add_flag("-v,--verbose", arguments.verbose, "Print the plan first, as a table of time");
    command.add_option("--progress", arguments.progress, "bar, plain, json or openjd (default: bar on a terminal, else plain)");
    command.add_option("--display", arguments.display,
                       "Show the picture on its way in a tev viewer at HOST:PORT (tev's own: 127.0.0.1:14158)");
    command.add_option("--stats", arguments.stats, "Write times, rays and memory to this JSON file");
}

} // namespace taut::app
