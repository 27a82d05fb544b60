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
    return {{"name", name},
            {"material", ready.scene().materials[object.object->materials.front()].name},
            {"triangles", name + ".triangles"},
            {"corner_uvs", name + ".uvs"},
            {"points", json::array()}};
}

json materialJson(const Material &material) {
    json out{{"name", material.name}, {"color", toJson(material.color.value)}};
    switch (material.type) {
    case BsdfType::Conductor:
    case BsdfType::Metal:
    case BsdfType::Dielectric:
    case BsdfType::Diffuse: out["type"] = bsdfInfo(material.type).name; break;
    default: throw RunError("can't give the material '" + material.name + "' to Cycles");
    }
    out["alpha"] = {material.alphaX.value, material.alphaY.value};
    out["ior"] = material.ior;
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
    for (const Material &material : scene.materials) description["materials"].push_back(materialJson(material));
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
