#pragma once
/// What `taut render` is asked for.

#include "frame_job.h"
#include "image_arguments.h"
#include "progress.h"
#include "scene_arguments.h"

#include <optional>
#include <string>
#include <vector>

namespace taut::app {

/// Which share of the work this process does.
enum class ShardBy { Frames, Samples, Rows };
struct Shard {
    ShardBy by = ShardBy::Frames;
    int index = 1, count = 1; ///< from 1
};

struct RenderArguments {
    SceneArguments scene;
    ModelArguments model;
    ImageArguments image;
    std::vector<std::string> outputs;
    std::string only;
    bool noGround = false;
    int spp = 0;
    std::string time;
    std::optional<std::string> noise;
    std::optional<std::uint32_t> seed;
    bool fixedSeed = false;
    bool independent = false;
    std::string crop;
    std::vector<std::string> aovs;
    int cryptoRanks = 0; ///< 0: as many as usual
    std::string checkpoint, timeLimit;
    bool resume = false;
    bool skipExisting = false;
    std::string shard, shardBy;
    bool check = false;
    bool quiet = false;
    bool verbose = false; ///< prints the plan first
    std::string progress;
    bool denoise = false, denoiseFrames = false; ///< the second over frames as well
    std::string display; ///< HOST:PORT of a viewer
    std::string stats;
};

/// --spp, --time, --noise, --seed, --fixed-seed, --crop and --aov: what a frame holds.
void addSampleArguments(CLI::App &command, RenderArguments &arguments);
void addRenderArguments(CLI::App &command, RenderArguments &arguments);

// What the texts among them mean. All throw InputError.
ProgressStyle progressStyleOf(const RenderArguments &arguments);
/// The scene with what the command line says about it.
Scene sceneOf(const RenderArguments &arguments);
/// Options of every whole frame, but for its seed.
FrameOptions optionsOf(const RenderArguments &arguments, const RenderSettings &render);
/// Where how many samples there will be is not known, light is not weighed against noise: the default tolerance holds as if it were given.
void fixTolerance(RenderArguments &arguments, const FrameOptions &options);
CheckpointOptions checkpointsOf(const RenderArguments &arguments);
/// Throws InputError where frames are to be denoised by the ones before them, and not all of them are rendered, or not with numbers of
/// their own.
void checkDenoiseFrames(const RenderArguments &arguments, const std::optional<Shard> &shard, bool fixedSeed);
/// None: the whole work.
std::optional<Shard> shardOf(const RenderArguments &arguments, const FrameOptions &options, std::size_t frames);
/// Those of the scene's frames that this process renders.
std::vector<int> framesOf(const RenderArguments &arguments, const std::optional<Shard> &shard, const std::vector<int> &frames);

} // namespace taut::app
