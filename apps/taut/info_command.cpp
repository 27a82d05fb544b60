/// taut info: what is in a scene, the plan and why, the ranges of stretch and roughness over the frames, and false-colour pictures.

#include "commands.h"
#include "false_colour.h"
#include "info_report.h"
#include "json_text.h"
#include "plan_table.h"
#include "resources.h"
#include "scene_arguments.h"

#include "taut/base/frame_set.h"
#include "taut/mesh/topology.h"
#include "taut/render/frame_render.h"
#include "taut/render/image_file.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <chrono>
#include <iostream>

namespace taut::app {

namespace {

using Clock = std::chrono::steady_clock;

struct InfoArguments {
    SceneArguments scene;
    ModelArguments model;
    bool json = false;
    bool resources = false;
    std::string falseColour; ///< a channel
    std::string output;
};

/// One line a question: what was taken, what it loses and costs, and the same of the next cheaper choice; or of the dearest, where that
/// was left for its noise.
void print(const Question &q) {
    const auto describe = [&](const Choice &c) {
        return fmt::format("{} (predicted error {:.2g}, {}{:.3g} {})", nameOf(c), c.error,
                           c.noise > 0 ? fmt::format("added noise {:.2g}, ", c.noise) : "", c.cost, unitOf(q));
    };
    std::string line = fmt::format("    {}: {}", nameOf(q), describe(q.choices[q.taken]));
    if (q.taken > 0) line += "; next cheaper: " + describe(q.choices[q.taken - 1]);
    if (q.taken == 0 && q.choices.back().noise > q.choices[0].error) line += "; noisier than what it mends: " + describe(q.choices.back());
    fmt::print("{}\n", line);
}

void print(const RenderObject &object, const GradientField &field) {
    const Object &source = *object.object;
    const MeshPlan &plan = object.plan;
    fmt::print("  {}: {} triangles, {} render vertices{}{}{}{}\n", source.name, object.surface.triangles.size(),
               object.surface.vertexCount(), source.mesh->skin.empty() ? "" : ", skinned", source.mesh->morphs.empty() ? "" : ", morphed",
               object.rigid ? ", rigid" : "", source.follow ? "" : ", roughness held fixed");
    const Topology topology = topologyOf(*source.mesh, source.rig.has_value());
    fmt::print("    {} components, {} boundary loops, {} edges of more than two faces\n", topology.components, topology.boundaryLoops,
               topology.complexEdges);
    fmt::print("    stretch {:.4g} to {:.4g}, shear up to {:.4g}, at most {} collapsed vertices and {} folded triangles\n",
               field.leastStretch, field.greatestStretch, field.greatestShear, field.collapsed, field.folded);
    if (plan.greatestAlpha > 0) fmt::print("    alpha {:.4g} to {:.4g}\n", plan.leastAlpha, plan.greatestAlpha);
    fmt::print("    plan: M {}, gradient {}, interpolation {}\n", nameOf(plan.stretch), nameOf(plan.estimator), nameOf(plan.interpolation));
    for (const Question &question : plan.questions) print(question);
    for (const auto &[name, count] : policiesOf(object.surface))
        if (count > 0) fmt::print("    {}: {}\n", name, count);
}

void print(const SceneFile &file) {
    fmt::print("{}:\n", file.path);
    for (const auto &[name, seconds] : file.clips) fmt::print("  clip {}: {:.4g} s\n", quoted(name), seconds);
    const auto list = [](std::string_view what, const std::vector<std::string> &names) {
        for (const std::string &name : names) fmt::print("  {} {}\n", what, quoted(name));
    };
    list("camera", file.cameras);
    list("light", file.lights);
    list("variant", file.variants);
    if (!file.leftOut.empty()) fmt::print("  used, but not shown: {}\n", file.leftOut);
}

void print(const Report &report) {
    const Scene &scene = report.scene;
    const RenderSettings &render = scene.render;
    const ScenePlan &plan = report.ready.plan();
    fmt::print("{}: {} x {}, {} spp, {} frames ({} to {})\n", report.scene.path, render.width, render.height, render.spp,
               render.frames.size(), render.frames.front(), render.frames.back());
    for (const SceneFile &file : scene.files) print(file);
    if (const std::string stage = stageOf(scene); !stage.empty()) fmt::print("{}\n", stage);
    fmt::print("{} materials, {} textures, {} lights{}\n", scene.materials.size(), scene.textures.size(), scene.lights.size(),
               scene.environment ? ", an environment" : "");
    for (std::size_t i = 0; i < scene.materials.size(); ++i) {
        fmt::print("  {}: multiscatter {}\n", scene.materials[i].name, nameOf(multiscatterOf(scene.materials[i], plan.materials[i].model)));
        if (plan.materials[i].question) print(*plan.materials[i].question);
        if (plan.details[i].question) print(*plan.details[i].question);
    }
    for (std::size_t i = 0; i < report.fields.size(); ++i) print(report.ready.objects()[i], report.fields[i]);
    fmt::print("plan: tolerance {:.3g}, predicted error {:.3g}{}, BVH {}\n", plan.tolerance, plan.predictedError,
               plan.errorInNoise > 0 ? fmt::format(" and {:.2g} that is less than its noise at {} spp", plan.errorInNoise, render.spp) : "",
               bvhOf(report.ready));
    fmt::print("{}{}", planTable(scene, plan), pilotLines(plan));
}

/// Renders one channel at every frame and writes it in false colours, the range over all frames.
nlohmann::json writeFalseColours(const InfoArguments &arguments, RenderScene &ready) {
    const Scene &scene = ready.scene();
    const std::vector<int> &frames = scene.render.frames;
    if (!isImagePath(arguments.output)) failInput({"-o"}, quoted(arguments.output), "a file name that ends in .exr or .png");
    if (frames.size() > 1 && !hasFramePattern(arguments.output))
        failInput({"-o"}, quoted(arguments.output), "a frame number such as #### in the name, for more than one frame");
    FrameOptions options;
    options.aovs = {aovOfChannel(arguments.falseColour)};
    options.spp = 4;
    std::vector<Image> images;
    for (const int frame : frames) {
        StageTimes times;
        ready.setFrame(frame, times);
        const FrameResult result = renderFrame(ready, options);
        images.push_back(imageOf(result.film, scene.render));
    }
    const Vec2 range = channelRange(images, arguments.falseColour);
    for (std::size_t i = 0; i < frames.size(); ++i)
        writeImage(pathOfFrame(arguments.output, frames[i]), falseColours(images[i], arguments.falseColour, range),
                   {{"taut:channel", arguments.falseColour}, {"taut:range", fmt::format("{} {}", range.x, range.y)}});
    return {{"channel", arguments.falseColour}, {"min", range.x}, {"max", range.y}};
}

/// Leaves the surfaces alone in the picture.
void hideLights(Scene &scene) {
    if (scene.environment) scene.environment->cameraVisible = false;
    for (Light &light : scene.lights) light.cameraVisible = false;
}

Resources resourcesOf(RenderScene &ready, Clock::time_point began) {
    FrameOptions options;
    options.spp = ready.scene().render.spp;
    return measureResources(ready, options, began);
}

void print(const Resources &r) {
    fmt::print("resources: {:.0f} MB, {:.3g} s of one thread a frame, {:.2g} s before it and {:.2g} s once\n", r.megabytes, r.frameSeconds,
               r.updateSeconds, r.serialSeconds);
}

int info(const InfoArguments &arguments) {
    const auto began = Clock::now();
    const auto threads = limitThreads(arguments.scene.threads);
    const bool pictures = !arguments.falseColour.empty();
    Scene scene = loadScene(arguments.scene, false);
    if (pictures) hideLights(scene);
    PlannedScene planned = planFor(scene, arguments.model, true);
    const bool animated = scene.render.frames.size() > 1;
    RenderScene ready(std::move(scene), std::move(planned.plan), animated, std::move(planned.surfaces));
    const Report report{ready.scene(), ready, planned.fields};
    if (!arguments.json) {
        if (pictures) writeFalseColours(arguments, ready);
        print(report);
        if (arguments.resources) print(resourcesOf(ready, began));
        return 0;
    }
    nlohmann::json result = toJson(report);
    if (pictures) result["false_colour"] = writeFalseColours(arguments, ready);
    if (arguments.resources) {
        const Resources r = resourcesOf(ready, began);
        result["resources"] = {
            {"megabytes", r.megabytes}, {"frame_thread_s", r.frameSeconds}, {"update_s", r.updateSeconds}, {"start_s", r.serialSeconds}};
    }
    std::cout << jsonText(result, 2) << std::endl;
    return 0;
}

} // namespace

void addInfo(CLI::App &parent, Run &run) {
    auto arguments = std::make_shared<InfoArguments>();
    CLI::App *command = parent.add_subcommand("info", "What is in a scene, what the plan makes of it, ranges over the frames");
    addSceneArguments(*command, arguments->scene);
    addModelArguments(*command, arguments->model);
    command->add_flag("--json", arguments->json, "One JSON object on standard output");
    command->add_flag("--resources", arguments->resources, "Also measure what a frame takes: memory, seconds");
    CLI::Option *channel = command->add_option("--false-colour", arguments->falseColour,
                                               "Also render this channel in false colours: Stretch.X, Alpha.Y, M.Y, ...");
    CLI::Option *output = command->add_option("-o,--output", arguments->output, "Where to: out/####.png or .exr");
    channel->needs(output);
    output->needs(channel);
    command->callback([&run, arguments] { run = [arguments] { return info(*arguments); }; });
}

} // namespace taut::app
