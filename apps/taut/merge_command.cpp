/// taut merge: shards of frames -> the images of these frames, as one process would have rendered them.

#include "commands.h"
#include "denoised_image.h"
#include "image_arguments.h"
#include "image_output.h"

#include "taut/base/frame_set.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <map>

namespace taut::app {

namespace {

struct MergeArguments {
    std::vector<std::string> shards;
    std::vector<std::string> outputs;
    ImageArguments image;
    std::string frames;
    bool skipExisting = false;
    bool removeShards = false;
    bool quiet = false;
};

namespace fs = std::filesystem;

/// Shards that lie beside the image of a frame and bear its name.
std::vector<std::string> shardsBeside(const std::string &image) {
    const fs::path path(image);
    const std::string begin = path.filename().string() + ".";
    std::vector<std::string> found;
    std::error_code error;
    for (fs::directory_iterator it(path.has_parent_path() ? path.parent_path() : fs::path("."), error), end; !error && it != end;
         it.increment(error)) {
        const std::string name = it->path().filename().string();
        if (name.starts_with(begin) && name.ends_with(".shard")) found.push_back((path.parent_path() / name).string());
    }
    std::sort(found.begin(), found.end());
    return found;
}

/// The shards to merge by their frames: those given, else those beside the images of the frames.
std::map<int, std::vector<std::string>> shardsOf(const MergeArguments &arguments) {
    std::map<int, std::vector<std::string>> given;
    for (const std::string &path : arguments.shards) given[readSavedHead(path).frame].push_back(path);
    if (arguments.frames.empty()) return given;
    std::map<int, std::vector<std::string>> shards;
    for (const int frame : parseFrameSet(arguments.frames, {"--frames"}))
        shards[frame] = arguments.shards.empty() ? shardsBeside(pathOfFrame(arguments.outputs.front(), frame)) : given[frame];
    return shards;
}

int merge(const MergeArguments &arguments) {
    if (arguments.shards.empty() && arguments.frames.empty())
        throw InputError("merge: found neither shards nor --frames, expected SHARD... or the frames whose shards lie beside -o");
    const std::map<int, std::vector<std::string>> shards = shardsOf(arguments);
    checkOutputs(arguments.outputs, shards.size());
    const auto isSkipped = [&](int frame) { return arguments.skipExisting && areThere(pathsOf(arguments.outputs, frame)); };
    for (const auto &[frame, paths] : shards) { // before anything is written
        if (isSkipped(frame)) continue;
        if (paths.empty())
            failInput({pathOfFrame(arguments.outputs.front(), frame)}, fmt::format("no shard of frame {}", frame), "all of them");
        checkShards(paths);
        imageSettingsOf(arguments.image, readSavedHead(paths.front()).image, arguments.outputs); // or says why not
    }
    std::optional<FrameDenoiser> denoiser;
    for (const auto &[frame, paths] : shards) {
        if (isSkipped(frame)) continue;
        MergedFrame merged = mergeShards(paths);
        merged.head.image = imageSettingsOf(arguments.image, merged.head.image, arguments.outputs);
        if (!denoiser) denoiser = denoiserOf(merged.head);
        writeImages(merged.head, merged.film, pathsOf(arguments.outputs, frame), denoiser ? &*denoiser : nullptr);
        if (!arguments.quiet)
            fmt::print(stderr, "frame {}: {} shards, {} samples a pixel, {:.2f} s -> {}\n", frame, paths.size(), merged.film.samples(),
                       merged.head.seconds, pathOfFrame(arguments.outputs.front(), frame));
        if (arguments.removeShards)
            for (const std::string &path : paths) fs::remove(path);
    }
    return 0;
}

} // namespace

void addMerge(CLI::App &parent, Run &run) {
    auto arguments = std::make_shared<MergeArguments>();
    CLI::App *command = parent.add_subcommand("merge", "Put the shards of frames together (taut render --shard)");
    command->add_option("shards", arguments->shards,
                        "All shards of one frame or of several (default: those beside the images of --frames)");
    command->add_option("-o,--output", arguments->outputs, "Images: out/####.exr or .png; may be given more than once")
        ->required()
        ->allow_extra_args(false);
    addImageArguments(*command, arguments->image);
    command->add_option("--frames", arguments->frames, "The frames: 1-48, 1-5,9; each must be there");
    command->add_flag("--skip-existing", arguments->skipExisting, "Leave out frames whose images are there");
    command->add_flag("--remove-shards", arguments->removeShards, "Remove the shards of a frame when its images are written");
    command->add_flag("-q,--quiet", arguments->quiet, "Print errors only");
    command->callback([&run, arguments] { run = [arguments] { return merge(*arguments); }; });
}

} // namespace taut::app
