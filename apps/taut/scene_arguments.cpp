#include "scene_arguments.h"

#include "commands.h"

#include "taut/base/frame_set.h"
#include "taut/scene/load_scene.h"

namespace taut::app {

void addSceneArguments(CLI::App &command, SceneArguments &arguments) {
    command.add_option("scene", arguments.scene, "Scene TOML, .glb / .gltf, or a mesh (.obj .ply .off .stl)")->required();
    command.add_option("-D,--define", arguments.overrides, "Override a scene key: render.width=320, mesh.0.follow=false")
        ->allow_extra_args(false);
    command.add_option("--frames", arguments.frames, "Frames: 1-48, 1-5,9, 1-100x5 (default: the scene's)");
    command.add_option("-t,--threads", arguments.threads, "Threads (default: all)")->check(CLI::Range(1, 1024));
}

Scene loadScene(const SceneArguments &arguments, bool quiet) {
    Warnings warnings;
    Scene scene = taut::loadScene(arguments.scene, arguments.overrides, warnings);
    if (!arguments.frames.empty()) scene.render.frames = parseFrameSet(arguments.frames, {"--frames"});
    if (!quiet) printWarnings(warnings);
    return scene;
}

std::shared_ptr<tbb::global_control> limitThreads(int threads) {
    if (threads <= 0) return nullptr;
    return std::make_shared<tbb::global_control>(tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(threads));
}

} // namespace taut::app
