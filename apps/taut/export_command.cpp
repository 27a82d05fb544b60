/// taut export: the command line of exporter.h.

#include "commands.h"
#include "exporter.h"
#include "json_text.h"
#include "progress.h"
#include "scene_arguments.h"

#include "taut/scene/memory_estimate.h"

#include <unistd.h>

#include <iostream>
#include <memory>

namespace taut::app {

namespace {

struct ExportArguments {
    SceneArguments scene;
    ExportRequest request;
    std::optional<int> level;
    bool quiet = false;
    bool json = false;
};

int exportScene(ExportArguments &arguments) {
    const auto threads = limitThreads(arguments.scene.threads);
    Scene scene = loadScene(arguments.scene, arguments.quiet);
    if (arguments.level)
        for (Object &object : scene.objects) {
            object.subdivision.level = *arguments.level;
            object.planLevel = false;
            chargeObject(*scene.budget, object, scene.render);
        }
    const ProgressStyle style = arguments.quiet || arguments.json ? ProgressStyle::None
                                : isatty(STDERR_FILENO) != 0      ? ProgressStyle::Bar
                                                                  : ProgressStyle::Plain;
    Progress progress(style, static_cast<int>(scene.render.frames.size()));
    arguments.request.startFrame = [&](int frame) { progress.startFrame(frame); };
    arguments.request.finishFrame = [&](int frame, const std::string &path, double seconds) { progress.finishFrame(frame, path, seconds); };
    Warnings warnings;
    const nlohmann::json report = exportFiles(scene, arguments.request, warnings);
    if (!arguments.quiet) printWarnings(warnings);
    if (arguments.json) std::cout << jsonText(report, 2) << std::endl;
    return 0;
}

} // namespace

void addExport(CLI::App &parent, Run &run) {
    auto arguments = std::make_shared<ExportArguments>();
    CLI::App *command = parent.add_subcommand("export", "Write deformed meshes with M at every vertex for other tools");
    addSceneArguments(*command, arguments->scene);
    command
        ->add_option(
            "-o,--output", arguments->request.outputs,
            "Files: out/####.ply, .csv, .npz, .glb, .gltf or .usda; out.usda, .pc2 or .mdd for all frames; may be given more than once")
        ->required()
        ->allow_extra_args(false);
    command->add_option("--object", arguments->request.objects, "Only this object; may be given more than once")->allow_extra_args(false);
    command->add_option("--convention", arguments->request.convention,
                        "Also write the parameters of: alpha (Mitsuba, pbrt), blender, blender_anisotropic, openpbr, materialx, khr "
                        "(default: matrix, none of them)");
    command->add_option("--positions", arguments->request.positions, "deformed (default) or rest: the undeformed mesh with the frame's M");
    command->add_option("--space", arguments->request.space, "Of point caches: world (default) or object, without the object's placement");
    command->add_option("--level", arguments->level, "Subdivision level of every mesh (default: the scene's)")->check(CLI::Range(0, 5));
    command->add_flag("--ascii", arguments->request.ascii, "PLY as text");
    command->add_flag("-q,--quiet", arguments->quiet, "Print errors only");
    command->add_flag("--json", arguments->json, "One JSON object about what was written on standard output");
    command->callback([&run, arguments] { run = [arguments] { return exportScene(*arguments); }; });
}

} // namespace taut::app
