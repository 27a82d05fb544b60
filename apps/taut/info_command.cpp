/// taut info: what is in a scene, what the policies did, and the range of stretch over the frames.

#include "commands.h"
#include "scene_arguments.h"

#include "taut/microsurface/transform.h"
#include "taut/render/render_scene.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <iostream>

namespace taut::app {

namespace {

struct InfoArguments {
    SceneArguments scene;
    bool json = false;
};

/// Extremes of the surface gradient over vertices and frames. Stretches are singular values of A.
struct StretchRange {
    float largest = 0;
    float smallest = kInfinity;
    float greatestShear = 0;   ///< |s.dt| / |t.dt|
    std::size_t collapsed = 0; ///< most vertices at once whose smaller stretch is under 1e-3 of the larger
    std::size_t folded = 0;    ///< most triangles at once that turned over against their vertex normals
    void add(const RenderObject &object);
};

void StretchRange::add(const RenderObject &object) {
    const SurfaceFrame &frame = object.frame;
    std::size_t collapsedNow = 0;
    for (std::size_t v = 0; v < frame.ds.size(); ++v) {
        const float a = glm::length(frame.ds[v]);
        const float b = a > 0 ? glm::dot(frame.ds[v], frame.dt[v]) / a : 0;
        const float d = std::sqrt(std::fmax(0.0F, glm::dot(frame.dt[v], frame.dt[v]) - b * b));
        const Vec2 sigma = singularValues(a, b, 0, d);
        largest = std::fmax(largest, sigma.x);
        smallest = std::fmin(smallest, sigma.y);
        if (d > 0) greatestShear = std::fmax(greatestShear, std::fabs(b) / d);
        if (sigma.y < 1e-3F * sigma.x) ++collapsedNow;
    }
    collapsed = std::max(collapsed, collapsedNow);
    std::size_t foldedNow = 0;
    for (const Index3 &t : object.surface.triangles) {
        const Vec3 &p = frame.positions[t.x];
        const Vec3 n = glm::cross(frame.positions[t.y] - p, frame.positions[t.z] - p) * (object.mirrored ? -1.0F : 1.0F);
        if (glm::dot(n, frame.normals[t.x]) < 0 && glm::dot(n, frame.normals[t.y]) < 0 && glm::dot(n, frame.normals[t.z]) < 0) ++foldedNow;
    }
    folded = std::max(folded, foldedNow);
}

nlohmann::json describe(const RenderObject &object, const StretchRange &range) {
    const Surface &surface = object.surface;
    const Mesh &mesh = object.mesh();
    return {{"name", object.object->name},
            {"positions", mesh.positions.size()},
            {"faces", mesh.faceCount()},
            {"triangles", surface.triangles.size()},
            {"render_vertices", surface.vertexCount()},
            {"subdivision", object.object->subdivision},
            {"follow", object.object->follow},
            {"rigid", object.rigid},
            {"skinned", !object.object->mesh->skin.empty()},
            {"morphs", object.object->mesh->morphs.size()},
            {"deformers", object.object->deformers.size()},
            {"has_uvs", !surface.uvs.empty()},
            {"stretch_max", range.largest},
            {"stretch_min", range.smallest},
            {"shear_max", range.greatestShear},
            {"collapsed_vertices", range.collapsed},
            {"folded_triangles", range.folded},
            {"policies",
             {{"SkipDegenerateFace", surface.degenerateFaces},
              {"RestAtLoneVertex", surface.loneVertices},
              {"TangentFromUv_mirrored", surface.mirroredVertices},
              {"SmoothFieldNoUv", surface.fallbackTangents}}}};
}

void print(const nlohmann::json &info) {
    fmt::print("{}: {} x {}, {} spp, {} frames ({} to {})\n", info["scene"].get<std::string>(), info["width"].get<int>(),
               info["height"].get<int>(), info["spp"].get<int>(), info["frames"].get<int>(), info["first_frame"].get<int>(),
               info["last_frame"].get<int>());
    fmt::print("{} materials, {} textures, {} lights{}\n", info["materials"].get<int>(), info["textures"].get<int>(),
               info["lights"].get<int>(), info["environment"].get<bool>() ? ", an environment" : "");
    for (const auto &o : info["objects"]) {
        fmt::print("  {}: {} triangles, {} render vertices{}{}{}{}\n", o["name"].get<std::string>(), o["triangles"].get<std::size_t>(),
                   o["render_vertices"].get<std::size_t>(), o["skinned"].get<bool>() ? ", skinned" : "",
                   o["morphs"].get<std::size_t>() > 0 ? ", morphed" : "", o["rigid"].get<bool>() ? ", rigid" : "",
                   o["follow"].get<bool>() ? "" : ", roughness held fixed");
        fmt::print("    stretch {:.4g} to {:.4g}, shear up to {:.4g}, at most {} collapsed vertices and {} folded triangles\n",
                   o["stretch_min"].get<float>(), o["stretch_max"].get<float>(), o["shear_max"].get<float>(),
                   o["collapsed_vertices"].get<std::size_t>(), o["folded_triangles"].get<std::size_t>());
        for (const auto &[policy, count] : o["policies"].items())
            if (count.get<std::size_t>() > 0) fmt::print("    {}: {}\n", policy, count.get<std::size_t>());
    }
}

int info(const InfoArguments &arguments) {
    const auto threads = limitThreads(arguments.scene.threads);
    const Scene scene = loadScene(arguments.scene, false);
    const std::vector<int> &frames = scene.render.frames;
    RenderScene ready(scene, frames.size() > 1);
    std::vector<StretchRange> ranges(ready.objects().size());
    StageTimes times;
    for (const int frame : frames) {
        ready.setFrame(frame, times);
        for (std::size_t i = 0; i < ranges.size(); ++i) ranges[i].add(ready.objects()[i]);
    }
    nlohmann::json result{{"scene", arguments.scene.scene},
                          {"width", scene.render.width},
                          {"height", scene.render.height},
                          {"spp", scene.render.spp},
                          {"frames", frames.size()},
                          {"first_frame", frames.front()},
                          {"last_frame", frames.back()},
                          {"materials", scene.materials.size()},
                          {"textures", scene.textures.size()},
                          {"lights", scene.lights.size()},
                          {"environment", scene.environment.has_value()},
                          {"objects", nlohmann::json::array()}};
    for (std::size_t i = 0; i < ranges.size(); ++i) result["objects"].push_back(describe(ready.objects()[i], ranges[i]));
    if (arguments.json)
        std::cout << result.dump(2) << std::endl;
    else
        print(result);
    return 0;
}

} // namespace

void addInfo(CLI::App &parent, Run &run) {
    auto arguments = std::make_shared<InfoArguments>();
    CLI::App *command = parent.add_subcommand("info", "What is in a scene");
    addSceneArguments(*command, arguments->scene);
    command->add_flag("--json", arguments->json, "One JSON object on standard output");
    command->callback([&run, arguments] { run = [arguments] { return info(*arguments); }; });
}

} // namespace taut::app
