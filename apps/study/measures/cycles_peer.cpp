#include "study/measures/cycles_peer.h"

#include "taut/base/error.h"
#include "taut/render/image_file.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <fcntl.h>
#include <filesystem>
#include <fstream>
#include <spawn.h>
#include <sstream>
#include <string>
#include <sys/wait.h>
#include <unistd.h>

namespace taut::chart {

namespace fs = std::filesystem;
using nlohmann::json;

namespace {

template <class V> json toJson(const V &v) {
    return {v.x, v.y, v.z};
}

template <class T> void writeArray(const fs::path &path, const std::vector<T> &values) {
    std::ofstream file(path, std::ios::binary);
    file.write(reinterpret_cast<const char *>(values.data()), static_cast<std::streamsize>(values.size() * sizeof(T)));
    if (!file.flush()) throw RunError("can't write '" + path.string() + "'");
}

/// World positions of the control points: render vertices that share one are joined, so that Blender's normals are smooth there.
std::vector<Vec3> worldPoints(const RenderScene &ready, const RenderObject &object) {
    std::vector<Vec3> points(object.mesh().positions.size());
    const std::vector<Vec3> &positions = object.steps.front().positions;
    for (std::size_t v = 0; v < object.surface.vertexCount(); ++v) {
        const Vec3 p = object.placements.empty() ? positions[v] : transformPoint(object.placements.front(), positions[v]);
        points[object.surface.surfacePosition[object.surface.vertexSurface[v]]] = Vec3(ready.worldFromRender() * glm::dvec4(DVec3(p), 1));
    }
    return points;
}

/// World normals of the triangles' corners.
std::vector<Vec3> cornerNormals(const RenderScene &ready, const RenderObject &object) {
    const std::vector<Vec3> &normals = object.steps.front().normals;
    std::vector<Vec3> corners;
    for (const Index3 &t : object.surface.triangles)
        for (int k = 0; k < 3; ++k) {
            const Vec3 n = object.placements.empty() ? normals[t[k]] : transformVector(object.placements.front(), normals[t[k]]);
            corners.push_back(glm::normalize(Vec3(Mat3(ready.worldFromRender()) * n)));
        }
    return corners;
}

std::string materialName(std::size_t index) {
    return "material" + std::to_string(index);
}

json meshJson(const RenderScene &ready, std::size_t index, const fs::path &folder) {
    const RenderObject &object = ready.objects()[index];
    const Surface &surface = object.surface;
    std::vector<Index> triangles;
    std::vector<Vec2> uvs;
    for (const Index3 &t : surface.triangles)
        for (int k = 0; k < 3; ++k) {
            triangles.push_back(surface.surfacePosition[surface.vertexSurface[t[k]]]);
            uvs.push_back(surface.uvs.empty() ? Vec2(0) : surface.uvs[t[k]]);
        }
    const std::string name = "mesh" + std::to_string(index);
    writeArray(folder / (name + ".triangles"), triangles);
    writeArray(folder / (name + ".uvs"), uvs);
    json out{{"name", name},
             {"materials", json::array()},
             {"triangles", name + ".triangles"},
             {"corner_uvs", name + ".uvs"},
             {"points", json::array()}};
    for (const Index material : object.object->materials) out["materials"].push_back(materialName(material));
    if (!surface.triangleSlots.empty()) {
        writeArray(folder / (name + ".slots"), surface.triangleSlots);
        out["slots"] = name + ".slots";
    }
    if (!object.object->rig) return out; // shapes of our own are smooth, and Blender finds their normals as they move
    if (ready.scene().render.frames.size() > 1) throw RunError("can't give moving normals of corners to Cycles");
    writeArray(folder / (name + ".normals"), cornerNormals(ready, object));
    out["corner_normals"] = name + ".normals";
    return out;
}

/// Writes a texture once as linear floats, and says how it is looked up.
json textureJson(const Scene &scene, Index index, const fs::path &folder) {
    const Texture &texture = scene.textures[index];
    if (texture.sampler.moved || texture.sampler.uvSet != 0 || texture.sampler.nearest || texture.sampler.wrapU == TextureWrap::Mirror ||
        texture.sampler.wrapU != texture.sampler.wrapV)
        throw RunError("can't give the texture '" + texture.name + "' to Cycles");
    const std::string file = "texture" + std::to_string(index) + ".exr";
    Image image{{0, 0, texture.width, texture.height}, texture.width, texture.height, {"R", "G", "B"}, {}};
    const auto channels = static_cast<std::size_t>(texture.channels);
    for (std::size_t i = 0; i < texture.texels.size(); i += channels)
        for (std::size_t c = 0; c < 3; ++c) image.values.push_back(texture.texels[i + (channels < 3 ? 0 : c)]);
    writeImage((folder / file).string(), image, {});
    return {{"file", file}, {"repeats", texture.sampler.wrapU == TextureWrap::Repeat}};
}

json materialJson(const Scene &scene, std::size_t index, const fs::path &folder) {
    const Material &material = scene.materials[index];
    json out{{"name", materialName(index)}, {"color", toJson(material.color.value)}, {"type", bsdfInfo(material.type).name}};
    const auto refuse = [&] { throw RunError("can't give the material '" + material.name + "' to Cycles"); };
    if (material.alphaX.texture != kNone || material.alphaY.texture != kNone || material.metallic.texture != kNone ||
        material.slopes.isGiven() || material.alphaMode != AlphaMode::Opaque)
        refuse();
    switch (material.type) {
    case BsdfType::Conductor:
    case BsdfType::Metal:
    case BsdfType::Dielectric:
    case BsdfType::Diffuse: break;
    case BsdfType::MetallicRoughness:
        if (material.alphaX.value != material.alphaY.value || material.transmission.value > 0 || material.clearcoat.value > 0) refuse();
        out["metallic"] = material.metallic.value;
        break;
    default: refuse();
    }
    const auto alpha = [&](float value) { return material.alphaIsRoughness ? sqr(value) : value; };
    out["alpha"] = {alpha(material.alphaX.value), alpha(material.alphaY.value)};
    out["ior"] = material.ior;
    if (material.color.texture != kNone) out["color_texture"] = textureJson(scene, material.color.texture, folder);
    return out;
}

json environmentJson(const std::optional<Environment> &environment, const fs::path &folder) {
    if (!environment) return json::object();
    if (environment->constant) return {{"radiance", toJson(environment->texels.front())}};
    Image image{{0, 0, environment->width, environment->height}, environment->width, environment->height, {"R", "G", "B"}, {}};
    for (const Vec3 &texel : environment->texels) image.values.insert(image.values.end(), {texel.x, texel.y, texel.z});
    writeImage((folder / "environment.exr").string(), image, {});
    return {{"file", "environment.exr"}, {"width", environment->width}};
}

/// Fills a folder, scene.json and all that it names.
void writeScene(RenderScene &ready, int threads, const fs::path &folder) {
    const Scene &scene = ready.scene();
    json description{{"threads", threads}, {"meshes", json::array()}, {"materials", json::array()}, {"lights", json::array()}};
    for (std::size_t i = 0; i < scene.objects.size(); ++i) description["meshes"].push_back(meshJson(ready, i, folder));
    for (std::size_t f = 0; f < scene.render.frames.size(); ++f) {
        StageTimes times;
        ready.setFrame(scene.render.frames[f], times);
        for (std::size_t i = 0; i < scene.objects.size(); ++i) {
            json &names = description["meshes"][i]["points"];
            if (f > 0 && scene.objects[i].deformers.empty()) continue;
            names.push_back("mesh" + std::to_string(i) + "." + std::to_string(f) + ".points");
            writeArray(folder / names.back().get<std::string>(), worldPoints(ready, ready.objects()[i]));
        }
    }
    for (std::size_t i = 0; i < scene.materials.size(); ++i) description["materials"].push_back(materialJson(scene, i, folder));
    for (const Light &light : scene.lights) {
        const auto &quad = std::get<QuadLight>(light.shape);
        description["lights"].push_back({{"type", "quad"},
                                         {"corner", toJson(quad.corner)},
                                         {"u", toJson(quad.u)},
                                         {"v", toJson(quad.v)},
                                         {"radiance", toJson(light.radiance)}});
    }
    const Camera &camera = scene.camera;
    description["camera"] = {{"position", toJson(camera.position.at(1))},
                             {"look_at", toJson(camera.lookAt.at(1))},
                             {"up", toJson(camera.up.at(1))},
                             {"fov_deg", glm::degrees(camera.fovY.at(1))}};
    description["environment"] = environmentJson(scene.environment, folder);
    description["render"] = {{"width", scene.render.width}, {"height", scene.render.height}, {"max_events", scene.render.maxEvents}};
    writeTextFile((folder / "scene.json").string(), description.dump(1) + "\n");
}

/// Red, green and blue of an image that Cycles wrote.
std::vector<float> readRgb(const fs::path &file) {
    const Image image = readImage(file.string());
    std::vector<std::size_t> places;
    for (const char *name : {"R", "G", "B"}) {
        const auto found = std::find(image.channels.begin(), image.channels.end(), name);
        if (found == image.channels.end()) throw RunError("Cycles wrote an image of fewer than three channels");
        places.push_back(static_cast<std::size_t>(found - image.channels.begin()));
    }
    std::vector<float> rgb;
    for (std::size_t i = 0; i < image.values.size(); i += image.channels.size())
        for (const std::size_t place : places) rgb.push_back(image.values[i + place]);
    return rgb;
}

} // namespace

bool hasBlender() {
    std::istringstream path(std::getenv("PATH") != nullptr ? std::getenv("PATH") : "");
    for (std::string folder; std::getline(path, folder, ':');)
        if (access((fs::path(folder) / "blender").c_str(), X_OK) == 0) return true;
    return false;
}

struct CyclesPeer::Process {
    fs::path folder;
    pid_t id = 0;
    FILE *requests = nullptr;
    FILE *answers = nullptr;

    Process() {
        std::string name = (fs::temp_directory_path() / "taut_cycles.XXXXXX").string();
        if (mkdtemp(name.data()) == nullptr) throw RunError("can't make a folder in " + fs::temp_directory_path().string());
        folder = name;
    }
    ~Process() {
        if (requests != nullptr) std::fclose(requests); // the end of its input ends it
        int status = 0;
        if (id > 0) waitpid(id, &status, 0);
        if (answers != nullptr) std::fclose(answers);
        std::error_code ignored;
        fs::remove_all(folder, ignored);
    }
    Process(const Process &) = delete;
    Process &operator=(const Process &) = delete;

    json answer() {
        std::string line;
        for (int c = std::fgetc(answers); c != EOF; c = std::fgetc(answers)) {
            if (c != '\n') {
                line.push_back(static_cast<char>(c));
                continue;
            }
            if (line.rfind("CYCLES ", 0) == 0) return json::parse(line.substr(7));
            line.clear(); // Blender's own progress
        }
        std::ifstream log(folder / "blender.log");
        throw RunError("Blender ended early: " + std::string(std::istreambuf_iterator<char>(log), {}));
    }
};

CyclesPeer::CyclesPeer(RenderScene &ready, int threads) : process_(std::make_unique<Process>()) {
    writeScene(ready, threads, process_->folder);
    std::signal(SIGPIPE, SIG_IGN); // a Blender that is gone shows when its answer is read
    int in[2];
    int out[2];
    if (pipe2(in, O_CLOEXEC) != 0 || pipe2(out, O_CLOEXEC) != 0) throw RunError("can't make a pipe");
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_adddup2(&actions, in[0], STDIN_FILENO);
    posix_spawn_file_actions_adddup2(&actions, out[1], STDOUT_FILENO);
    posix_spawn_file_actions_addopen(&actions, STDERR_FILENO, (process_->folder / "blender.log").c_str(), O_WRONLY | O_CREAT | O_TRUNC,
                                     0644);
    std::vector<std::string> words{"blender",
                                   "-b",
                                   "-noaudio",
                                   "--factory-startup",
                                   "--python-exit-code",
                                   "1",
                                   "--python",
                                   TAUT_BLENDER_SCRIPTS "/cycles.py",
                                   "--",
                                   "serve",
                                   (process_->folder / "scene.json").string()};
    std::vector<char *> arguments;
    for (std::string &word : words) arguments.push_back(word.data());
    arguments.push_back(nullptr);
    const int failed = posix_spawnp(&process_->id, "blender", &actions, nullptr, arguments.data(), environ);
    posix_spawn_file_actions_destroy(&actions);
    close(in[0]);
    close(out[1]);
    process_->requests = fdopen(in[1], "w");
    process_->answers = fdopen(out[0], "r");
    if (failed != 0) throw RunError("can't start blender");
    process_->answer(); // ready
}

CyclesPeer::~CyclesPeer() = default;

CyclesRender CyclesPeer::render(const CyclesRequest &request) {
    const fs::path output = process_->folder / "image.exr";
    const json line{{"frame", request.frame}, {"spp", request.spp},       {"seed", request.seed},
                    {"width", request.width}, {"height", request.height}, {"output", request.image ? output.string() : ""}};
    std::fputs((line.dump() + "\n").c_str(), process_->requests);
    std::fflush(process_->requests);
    const json answer = process_->answer();
    return {answer["seconds"], answer["peak_mb"], request.image ? readRgb(output) : std::vector<float>()};
}

} // namespace taut::chart
