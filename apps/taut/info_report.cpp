#include "info_report.h"

#include "taut/mesh/topology.h"
#include "taut/scene/ground.h"

#include <fmt/format.h>

namespace taut::app {

/// What a policy for what has no right answer did, by its name (surface.h).
std::array<std::pair<std::string_view, Index>, 5> policiesOf(const Surface &surface) {
    return {{{"NormalsFollowWinding", surface.turnedVertices},
             {"RestAtLoneVertex", surface.loneVertices},
             {"SkipDegenerateFace", surface.degenerateFaces},
             {"SmoothFieldNoUv", surface.fallbackTangents},
             {"TangentFromUv_mirrored", surface.mirroredVertices}}};
}

std::string stageOf(const Scene &scene) {
    const std::optional<Ground> ground = groundOf(scene);
    if (!ground) return "";
    return fmt::format("taut render stands it on a ground at z = {:.6g}{}{}{} (--no-ground: not)", ground->height,
                       ground->yUp ? ", y up" : "", scene.unsaid.light ? ", in the neutral studio" : ", under its own light",
                       scene.unsaid.camera ? ", framed" : ", seen by its own camera");
}

std::string_view bvhOf(const RenderScene &ready) {
    return ready.refits() ? "refit, rebuilt where its rays would pay for it" : "built anew where something deforms";
}

nlohmann::json toJson(const Question &q) {
    nlohmann::json choices = nlohmann::json::array();
    for (const Choice &c : q.choices)
        choices.push_back({{"name", nameOf(c)}, {"predicted_error", c.error}, {"cost", c.cost}, {"noise", c.noise}});
    return {{"name", nameOf(q)}, {"unit", unitOf(q)}, {"taken", nameOf(q.choices[q.taken])}, {"choices", choices}};
}

nlohmann::json toJson(const MeshPlan &plan) {
    nlohmann::json questions = nlohmann::json::array();
    for (const Question &q : plan.questions) questions.push_back(toJson(q));
    return {{"stretch", nameOf(plan.stretch)},
            {"gradient", nameOf(plan.estimator)},
            {"interpolation", nameOf(plan.interpolation)},
            {"questions", questions}};
}

namespace {

nlohmann::json toJson(const RenderObject &object, const GradientField &field) {
    const Surface &surface = object.surface;
    const Mesh &mesh = object.mesh();
    const MeshPlan &plan = object.plan;
    const Topology topology = topologyOf(*object.object->mesh, object.object->rig.has_value());
    nlohmann::json alpha; // null without a microsurface
    if (plan.greatestAlpha > 0) alpha = {{"min", plan.leastAlpha}, {"max", plan.greatestAlpha}};
    nlohmann::json policies;
    for (const auto &[name, count] : policiesOf(surface)) policies[std::string(name)] = count;
    return {{"name", object.object->name},
            {"positions", mesh.positions.size()},
            {"faces", mesh.faceCount()},
            {"components", topology.components},
            {"boundary_loops", topology.boundaryLoops},
            {"complex_edges", topology.complexEdges},
            {"triangles", surface.triangles.size()},
            {"render_vertices", surface.vertexCount()},
            {"subdivision", plan.subdivisionLevel},
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
            {"alpha", alpha},
            {"collapsed_vertices", field.collapsed},
            {"folded_triangles", field.folded},
            {"plan", app::toJson(plan)},
            {"policies", policies}};
}

nlohmann::json toJson(const SceneFile &file) {
    nlohmann::json clips = nlohmann::json::array();
    for (const auto &[name, seconds] : file.clips) clips.push_back({{"name", name}, {"seconds", seconds}});
    return {{"path", file.path},         {"clips", clips},          {"cameras", file.cameras}, {"lights", file.lights},
            {"variants", file.variants}, {"left_out", file.leftOut}};
}

} // namespace

nlohmann::json toJson(const Report &report) {
    const Scene &scene = report.scene;
    const std::vector<int> &frames = scene.render.frames;
    const ScenePlan &plan = report.ready.plan();
    nlohmann::json result{{"scene", report.scene.path},
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
                          {"bvh", bvhOf(report.ready)},
                          {"files", nlohmann::json::array()},
                          {"materials", nlohmann::json::array()},
                          {"objects", nlohmann::json::array()}};
    if (const std::optional<Ground> ground = groundOf(scene))
        result["ground"] = {{"height", ground->height}, {"centre", {ground->centre.x, ground->centre.y}}, {"radius", ground->radius}};
    for (const PilotFinding &f : plan.pilots)
        result["pilots"].push_back({{"choice", nameOf(f.value)},
                                    {"error", f.error},
                                    {"spread", f.spread},
                                    {"analysis", f.predicted},
                                    {"noise_of_a_sample", f.noise},
                                    {"rays_a_sample", f.rays}});
    if (plan.events) result["events"] = toJson(*plan.events);
    if (plan.motion) result["motion_steps"] = toJson(*plan.motion);
    if (plan.budget)
        result["budget"] = {
            {"error", plan.budget->error}, {"bias", plan.budget->bias}, {"noise", plan.budget->noise}, {"samples", plan.budget->samples}};
    for (const SceneFile &file : scene.files) result["files"].push_back(toJson(file));
    for (std::size_t i = 0; i < scene.materials.size(); ++i) {
        const MultiscatterPlan &planned = plan.materials[i];
        result["materials"].push_back(
            {{"name", scene.materials[i].name},
             {"multiscatter", nameOf(multiscatterOf(scene.materials[i], planned.model))},
             {"predicted_error", planned.error},
             {"question", planned.question ? toJson(*planned.question) : nlohmann::json()},
             {"texture_detail", nameOf(plan.details[i].detail)},
             {"texture_question", plan.details[i].question ? toJson(*plan.details[i].question) : nlohmann::json()}});
    }
    for (std::size_t i = 0; i < report.fields.size(); ++i) result["objects"].push_back(toJson(report.ready.objects()[i], report.fields[i]));
    return result;
}

} // namespace taut::app
