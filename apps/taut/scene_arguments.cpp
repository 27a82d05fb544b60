#include "scene_arguments.h"

#include "commands.h"

#include "taut/base/budget.h"
#include "taut/base/frame_set.h"
#include "taut/formats/gltf.h"
#include "taut/pilot/plan_by_pilots.h"
#include "taut/scene/load_scene.h"

#include <algorithm>
#include <cmath>
#include <iostream>

namespace taut::app {

void addSceneArguments(CLI::App &command, SceneArguments &arguments) {
    command.add_option("scene", arguments.scene, "Scene TOML, .glb / .gltf, or a mesh (.obj .ply .off .stl)")->required();
    command.add_option("-D,--define", arguments.overrides, "Override a scene key: render.width=320, mesh.0.follow=false")
        ->allow_extra_args(false);
    command.add_option("--frames", arguments.frames,
                       "Frames: 1-48, 1-5,9, 1-100x5, or clip: the length of the clip (default: the scene's)");
    command.add_option("-t,--threads", arguments.threads, "Threads (default: all)")->check(CLI::Range(1, 1024));
    command.add_option("--max-memory", arguments.maxMemory,
                       "Memory that the scene may ask for: 8g, 512m (default: 768m, or 128 times the bytes of its files if that is more)");
}

namespace {

/// Of a bare animated file one frame is the default: says that there are more.
void tellOfClip(const SceneArguments &arguments, const Scene &scene, Warnings &warnings) {
    const bool asked = !arguments.frames.empty() || std::any_of(arguments.overrides.begin(), arguments.overrides.end(),
                                                                [](const std::string &o) { return o.rfind("render.frames", 0) == 0; });
    if (asked || !isGltfPath(arguments.scene)) return;
    double seconds = 0;
    for (const Object &object : scene.objects)
        if (const Clip *clip = object.rig ? clipOf(*object.rig) : nullptr) seconds = std::max(seconds, static_cast<double>(clip->duration));
    if (seconds > 0)
        warnings.add(arguments.scene + ": is animated for " + formatNumber(seconds) + " s; this is frame 1 alone (--frames clip: all)");
}

} // namespace

void printWarnings(const Warnings &warnings) {
    for (const std::string &line : warnings.lines) std::cerr << "taut: warning: " << line << std::endl;
}

std::shared_ptr<Budget> budgetOf(const SceneArguments &arguments) {
    if (arguments.maxMemory.empty()) return std::make_shared<Budget>();
    return std::make_shared<Budget>(memorySize(arguments.maxMemory, "--max-memory"));
}

Scene loadScene(const SceneArguments &arguments, bool quiet) {
    Warnings warnings;
    std::vector<std::string> overrides = arguments.overrides;
    if (!arguments.frames.empty()) {
        if (arguments.frames != "clip") parseFrameSet(arguments.frames, {"--frames"}); // its own error, before the scene's
        overrides.push_back("render.frames=\"" + arguments.frames + "\"");
    }
    Scene scene = taut::loadScene(arguments.scene, overrides, warnings, budgetOf(arguments));
    tellOfClip(arguments, scene, warnings);
    if (!quiet) printWarnings(warnings);
    return scene;
}

void addModelArguments(CLI::App &command, ModelArguments &arguments) {
    command
        .add_option(
            "--tolerance", arguments.tolerance,
            "Relative RMS error that the plan's savings may have together, whatever the noise (default: 0.01, and multiple scattering "
            "only where it is more than its noise at the scene's samples a pixel)")
        ->check(CLI::Range(1e-6, 1.0));
    command
        .add_option(
            "--error", arguments.error,
            "Relative RMS error of the picture, bias and noise together: 0.02. The plan splits it, and samples go where they are needed; "
            "--spp is the upper bound (default: 65536)")
        ->check(CLI::Range(1e-4, 0.5));
    command.add_option("--model", arguments.model, "auto: the cheapest model within the tolerance; full: every saving off");
}

PlannedScene planFor(const Scene &scene, const ModelArguments &arguments, bool report, bool shares) {
    static constexpr std::string_view kModels[] = {"auto", "full"};
    PlanOptions options;
    options.tolerance = arguments.tolerance;
    options.error = arguments.error;
    for (const auto &[option, value] : {std::pair("--error", arguments.error), std::pair("--tolerance", arguments.tolerance)})
        if (value && !std::isfinite(*value))
            failInput({option}, formatNumber(static_cast<double>(*value)), "a relative error such as 0.02");
    if (arguments.error && arguments.tolerance) failInput({"--error"}, "--tolerance beside it, which is a part of it", "one of both");
    options.full = arguments.model == "full";
    options.report = report;
    options.shares = shares;
    if (!options.full && !arguments.model.empty() && arguments.model != "auto") failUnknownName({"--model"}, arguments.model, kModels);
    return planByPilots(scene, options);
}

std::shared_ptr<tbb::global_control> limitThreads(int threads) {
    if (threads <= 0) return nullptr;
    return std::make_shared<tbb::global_control>(tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(threads));
}

} // namespace taut::app
