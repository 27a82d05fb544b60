/// taut info: what is in a scene, the plan and why, the ranges of stretch and roughness over the frames, and false-colour pictures.

#include "commands.h"
#include "false_colour.h"
#include "scene_arguments.h"

#include "taut/base/frame_set.h"
#include "taut/mesh/topology.h"
#include "taut/plan/gradient_field.h"
#include "taut/render/image_file.h"
#include "taut/render/frame_render.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <iostream>

namespace taut::app {

namespace {

struct InfoArguments {
    SceneArguments scene;
    ModelArguments model;
    bool json = false;
    std::string falseColour; ///< a channel
    std::string output;
};

std::string_view nameOf(StretchModel model) {
    switch (model) {
    case StretchModel::Constant: return "constant";
    case StretchModel::Uniform: return "uniform";
    case StretchModel::PerVertex: return "per vertex";
    case StretchModel::Leaning: return "leaning";
    }
    return "";
}
std::string_view nameOf(Multiscatter model) {
    static constexpr std::array<std::string_view, 4> kNames{"off", "compensation", "walk", "by each hit's M"};
    return kNames[static_cast<std::size_t>(model)];
}

nlohmann::json toJson(const Question &q) {
    nlohmann::json choices = nlohmann::json::array();
    for (const Choice &c : q.choices)
        choices.push_back({{"name", c.name}, {"predicted_error", c.error}, {"cost", c.cost}, {"noise", c.noise}});
    return {{"name", q.name}, {"unit", q.unit}, {"taken", q.choices[q.taken].name}, {"choices", choices}};
}

/// The BVH's choice changes no pixel. `refits`: the scene's meshes are refitted, but in frames where a build costs less; named is what
/// most frames get.
Question bvhQuestion(const BvhForecast &forecast, bool refits) {
    const auto milliseconds = [](double seconds) { return static_cast<float>(1e3 * seconds); };
    Choice refit{"refit", 0, milliseconds(forecast.refitSeconds)};
    Choice rebuild{"rebuild", 0, milliseconds(forecast.rebuildSeconds)};
    const bool rebuilds = !refits || 2 * forecast.rebuilds > forecast.frames;
    if (forecast.rebuilds > 0 && refits)
        (rebuilds ? rebuild : refit).name += fmt::format(", {} of {} frames rebuilt", forecast.rebuilds, forecast.frames);
    return {"bvh", "ms a frame, slower rays included", {refit, rebuild}, rebuilds ? 1U : 0U};
}

nlohmann::json toJson(const MeshPlan &plan) {
    nlohmann::json questions = nlohmann::json::array();
    for (const Question &q : plan.questions) questions.push_back(toJson(q));
    return {{"stretch", nameOf(plan.stretch)},
            {"gradient", nameOf(plan.estimator)},
            {"interpolation", nameOf(plan.interpolation)},
            {"questions", questions}};
}

/// Least and greatest alpha of the object's materials after deformation, as the plan reckons with them; null without a microsurface.
nlohmann::json alphaRange(const MeshPlan &plan) {
    if (!(plan.greatestAlpha > 0)) return nullptr;
    return {{"min", plan.leastAlpha}, {"max", plan.greatestAlpha}};
}

nlohmann::json describe(const RenderObject &object, bool refits, const RenderSettings &render) {
    const int level = object.plan.subdivisionLevel;
    const GradientField field = measureGradientField(*object.object, level, render.frames, render.fps);
    nlohmann::json planned = toJson(object.plan);
    if (!object.rigid && render.frames.size() > 1)
        planned["questions"].push_back(toJson(bvhQuestion(forecastBvh(*object.object, level, render), refits)));
    const Surface &surface = object.surface;
    const Mesh &mesh = object.mesh();
    const Topology topology = topologyOf(*object.object->mesh, object.object->rig.has_value());
    return {{"name", object.object->name},
            {"positions", mesh.positions.size()},
            {"faces", mesh.faceCount()},
            {"components", topology.components},
            {"boundary_loops", topology.boundaryLoops},
            {"complex_edges", topology.complexEdges},
            {"triangles", surface.triangles.size()},
            {"render_vertices", surface.vertexCount()},
            {"subdivision", object.plan.subdivisionLevel},
            {"follow", object.object->follow},
            {"rigid", object.rigid},
            {"skinned", !object.object->mesh->skin.empty()},
            {"morphs", object.object->mesh->morphs.size()},
            {"deformers", object.object->deformers.size()},
            {"has_uvs", !surface.uvs.empty()},
            {"stretch_max", field.greatestStretch},
            {"stretch_min", field.leastStretch},
            {"shear_max", field.greatestShear},
            {"lean_max", field.lean},
            {"alpha", alphaRange(object.plan)},
            {"collapsed_vertices", field.collapsed},
            {"folded_triangles", field.folded},
            {"plan", planned},
            {"policies",
             {{"SkipDegenerateFace", surface.degenerateFaces},
              {"RestAtLoneVertex", surface.loneVertices},
              {"TangentFromUv_mirrored", surface.mirroredVertices},
              {"SmoothFieldNoUv", surface.fallbackTangents}}}};
}

/// One line a question: what was taken, what it loses and costs, and the same of the next cheaper choice; or of the dearest, where that
/// was left for its noise.
void printQuestion(const nlohmann::json &question) {
    const auto &choices = question["choices"];
    std::size_t taken = 0;
    while (choices[taken]["name"] != question["taken"]) ++taken;
    const auto describeChoice = [&](std::size_t i) {
        const float noise = choices[i]["noise"].get<float>();
        return fmt::format("{} (predicted error {:.2g}, {}{:.3g} {})", choices[i]["name"].get<std::string>(),
                           choices[i]["predicted_error"].get<float>(), noise > 0 ? fmt::format("added noise {:.2g}, ", noise) : "",
                           choices[i]["cost"].get<float>(), question["unit"].get<std::string>());
    };
    std::string line = fmt::format("    {}: {}", question["name"].get<std::string>(), describeChoice(taken));
    if (taken > 0) line += "; next cheaper: " + describeChoice(taken - 1);
    if (taken == 0 && choices.back()["noise"].get<float>() > choices[0]["predicted_error"].get<float>())
        line += "; noisier than what it mends: " + describeChoice(choices.size() - 1);
    fmt::print("{}\n", line);
}

void printObject(const nlohmann::json &o) {
    fmt::print("  {}: {} triangles, {} render vertices{}{}{}{}\n", o["name"].get<std::string>(), o["triangles"].get<std::size_t>(),
               o["render_vertices"].get<std::size_t>(), o["skinned"].get<bool>() ? ", skinned" : "",
               o["morphs"].get<std::size_t>() > 0 ? ", morphed" : "", o["rigid"].get<bool>() ? ", rigid" : "",
               o["follow"].get<bool>() ? "" : ", roughness held fixed");
    fmt::print("    {} components, {} boundary loops, {} edges of more than two faces\n", o["components"].get<std::size_t>(),
               o["boundary_loops"].get<std::size_t>(), o["complex_edges"].get<std::size_t>());
    fmt::print("    stretch {:.4g} to {:.4g}, shear up to {:.4g}, at most {} collapsed vertices and {} folded triangles\n",
               o["stretch_min"].get<float>(), o["stretch_max"].get<float>(), o["shear_max"].get<float>(),
               o["collapsed_vertices"].get<std::size_t>(), o["folded_triangles"].get<std::size_t>());
    if (!o["alpha"].is_null()) fmt::print("    alpha {:.4g} to {:.4g}\n", o["alpha"]["min"].get<float>(), o["alpha"]["max"].get<float>());
    const auto &plan = o["plan"];
    fmt::print("    plan: M {}, gradient {}, interpolation {}\n", plan["stretch"].get<std::string>(), plan["gradient"].get<std::string>(),
               plan["interpolation"].get<std::string>());
    for (const auto &question : plan["questions"]) printQuestion(question);
    for (const auto &[policy, count] : o["policies"].items())
        if (count.get<std::size_t>() > 0) fmt::print("    {}: {}\n", policy, count.get<std::size_t>());
}

void print(const nlohmann::json &info) {
    fmt::print("{}: {} x {}, {} spp, {} frames ({} to {})\n", info["scene"].get<std::string>(), info["width"].get<int>(),
               info["height"].get<int>(), info["spp"].get<int>(), info["frames"].get<int>(), info["first_frame"].get<int>(),
               info["last_frame"].get<int>());
    fmt::print("{} materials, {} textures, {} lights{}\n", info["materials"].size(), info["textures"].get<int>(), info["lights"].get<int>(),
               info["environment"].get<bool>() ? ", an environment" : "");
    for (const auto &m : info["materials"]) {
        fmt::print("  {}: multiscatter {}\n", m["name"].get<std::string>(), m["multiscatter"].get<std::string>());
        if (!m["question"].is_null()) printQuestion(m["question"]);
    }
    for (const auto &o : info["objects"]) printObject(o);
    const float inNoise = info["error_in_noise"].get<float>();
    fmt::print("plan: tolerance {:.3g}, predicted error {:.3g}{}, BVH {}\n", info["tolerance"].get<float>(),
               info["predicted_error"].get<float>(),
               inNoise > 0 ? fmt::format(" and {:.2g} that is less than its noise at {} spp", inNoise, info["spp"].get<int>()) : "",
               info["bvh"].get<std::string>());
}

nlohmann::json describe(const InfoArguments &arguments, const Scene &scene, const RenderScene &ready) {
    const std::vector<int> &frames = scene.render.frames;
    const ScenePlan &plan = ready.plan();
    nlohmann::json result{{"scene", arguments.scene.scene},
                          {"width", scene.render.width},
                          {"height", scene.render.height},
                          {"spp", scene.render.spp},
                          {"frames", frames.size()},
                          {"first_frame", frames.front()},
                          {"last_frame", frames.back()},
                          {"textures", scene.textures.size()},
                          {"lights", scene.lights.size()},
                          {"environment", scene.environment.has_value()},
                          {"tolerance", plan.tolerance},
                          {"predicted_error", plan.predictedError},
                          {"error_in_noise", plan.errorInNoise},
                          {"bvh", ready.refits() ? "refit, rebuilt where its rays would pay for it" : "built anew where something deforms"},
                          {"materials", nlohmann::json::array()},
                          {"objects", nlohmann::json::array()}};
    for (std::size_t i = 0; i < scene.materials.size(); ++i) {
        const Material &material = scene.materials[i];
        result["materials"].push_back({{"name", material.name},
                                       {"multiscatter", nameOf(multiscatterOf(material, plan.materials[i].model))},
                                       {"predicted_error", plan.materials[i].error},
                                       {"question", plan.materials[i].question ? toJson(*plan.materials[i].question) : nlohmann::json()}});
    }
    for (const RenderObject &object : ready.objects()) result["objects"].push_back(describe(object, ready.refits(), scene.render));
    return result;
}

/// Renders one channel at every frame and writes it in false colours, the range over all frames.
nlohmann::json writeFalseColours(const InfoArguments &arguments, const Scene &scene, RenderScene &ready) {
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
        images.push_back(
            {result.film.window(), scene.render.width, scene.render.height, result.film.channelNames(), result.film.resolve()});
    }
    const Vec2 range = channelRange(images, arguments.falseColour);
    for (std::size_t i = 0; i < frames.size(); ++i)
        writeImage(pathOfFrame(arguments.output, frames[i]), falseColours(images[i], arguments.falseColour, range),
                   {{"taut:channel", arguments.falseColour}, {"taut:range", fmt::format("{} {}", range.x, range.y)}});
    return {{"channel", arguments.falseColour}, {"min", range.x}, {"max", range.y}};
}

int info(const InfoArguments &arguments) {
    const auto threads = limitThreads(arguments.scene.threads);
    Scene scene = loadScene(arguments.scene, false);
    if (!arguments.falseColour.empty()) { // surfaces alone
        if (scene.environment) scene.environment->cameraVisible = false;
        for (Light &light : scene.lights) light.cameraVisible = false;
    }
    RenderScene ready(scene, planFor(scene, arguments.model), scene.render.frames.size() > 1);
    nlohmann::json result = describe(arguments, scene, ready);
    if (!arguments.falseColour.empty()) result["false_colour"] = writeFalseColours(arguments, scene, ready);
    if (arguments.json)
        std::cout << result.dump(2) << std::endl;
    else
        print(result);
    return 0;
}

} // namespace

void addInfo(CLI::App &parent, Run &run) {
    auto arguments = std::make_shared<InfoArguments>();
    CLI::App *command = parent.add_subcommand("info", "What is in a scene, what the plan makes of it, ranges over the frames");
    addSceneArguments(*command, arguments->scene);
    addModelArguments(*command, arguments->model);
    command->add_flag("--json", arguments->json, "One JSON object on standard output");
    CLI::Option *channel = command->add_option("--false-colour", arguments->falseColour,
                                               "Also render this channel in false colours: Stretch.max, AlphaMin, M.b, ...");
    CLI::Option *output = command->add_option("-o,--output", arguments->output, "Where to: out/####.png or .exr");
    channel->needs(output);
    output->needs(channel);
    command->callback([&run, arguments] { run = [arguments] { return info(*arguments); }; });
}

} // namespace taut::app
