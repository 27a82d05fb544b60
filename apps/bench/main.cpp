/// taut_bench: samples and rays per second of the renderer, beside the same rays replayed through bare Embree calls in the same
/// run, and where the time goes. Prints a table; --output writes it as JSON.

#include "taut/base/error.h"
#include "taut/mesh/shapes.h"
#include "taut/render/image_file.h"
#include "taut/render/render_frame.h"
#include "taut/render/replay.h"

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <tbb/global_control.h>
#include <tbb/info.h>

#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <functional>
#include <iostream>
#include <memory>

namespace {

using namespace taut;

/// A scene by name; made where it is measured, in a process of its own.
struct BenchScene {
    std::string name;
    std::function<Scene()> make;
};

Object objectOf(Mesh mesh, Index material) {
    Object object;
    object.name = mesh.name;
    object.mesh = std::make_shared<const Mesh>(std::move(mesh));
    object.materials = {material};
    return object;
}

Material brushed() {
    Material material;
    material.name = "brushed";
    material.type = MaterialType::Conductor;
    material.alphaX.value = 0.08F;
    material.alphaY.value = 0.4F;
    material.multiscatter = Multiscatter::Off; // as the peers are measured
    return material;
}

/// A torus over a ground of radius 10; `triangles` of the torus about 2 x around x across.
Scene torusScene(int around, int across, bool ground, int maxEvents) {
    Scene scene;
    scene.render.width = 512;
    scene.render.height = 512;
    scene.render.maxEvents = maxEvents;
    scene.render.boxFilter = true;
    scene.materials = {brushed(), Material{}};
    scene.materials[1].name = "ground";
    scene.materials[1].color.value = Vec3(0.5F);
    scene.objects.push_back(objectOf(makeTorus(around, across, 1, 0.4F), 0));
    if (ground) {
        scene.objects.push_back(objectOf(makeGrid(1, 1, 20), 1));
        scene.objects.back().placement.translation = DVec3(0, 0, -0.4);
    }
    scene.camera.position = DVec3(0, -2.6, 1.8);
    scene.camera.lookAt = DVec3(0);
    return scene;
}

constexpr int kAround = 632;
constexpr int kAcross = 158; // 199,712 triangles

Light areaLight() {
    Light quad; // facing down
    quad.corner = DVec3(1, -1, 3);
    quad.u = DVec3(-2, 0, 0);
    quad.v = DVec3(0, 2, 0);
    quad.radiance = Vec3(10);
    return quad;
}

Scene withEnvironment(Scene scene, Environment environment) {
    scene.environment = std::move(environment);
    return scene;
}

Scene areaScene() {
    Scene scene = torusScene(kAround, kAcross, true, 6);
    scene.lights = {areaLight()};
    return scene;
}

Scene deformingScene() {
    Scene scene = areaScene();
    DeformerKeys shear;
    shear.type = DeformerType::Shear;
    shear.axis = 0;
    shear.axis2 = 2;
    shear.amount.keys = {{1, 0.0}, {8, 0.8}};
    scene.objects[0].deformers = {shear};
    scene.render.frames = {1, 2, 3, 4, 5, 6, 7, 8};
    return scene;
}

std::vector<BenchScene> benchScenes() {
    return {{"furnace", [] { return withEnvironment(torusScene(kAround, kAcross, false, 8), constantEnvironment(Vec3(1))); }},
            {"area light", areaScene},
            {"sky", [] { return withEnvironment(torusScene(kAround, kAcross, true, 8), constantEnvironment(Vec3(1))); }},
            {"studio environment", [] { return withEnvironment(torusScene(kAround, kAcross, true, 8), studioEnvironment()); }},
            {"deforming 200k", deformingScene}};
}

double peakMegabytes() {
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    return static_cast<double>(usage.ru_maxrss) / 1024;
}

/// Renders the scene's frames; the record, if any, gets the rays of the last frame.
nlohmann::json measure(const BenchScene &bench, int spp, int recordSpp) {
    const Scene scene = bench.make();
    RenderScene ready(scene, scene.render.frames.size() > 1);
    StageTimes stages;
    RayCounts counts;
    double traced = 0;
    for (const int frame : scene.render.frames) {
        ready.setFrame(frame, stages);
        FrameOptions options;
        options.spp = spp;
        options.seed = frameSeed(0, frame, false);
        const FrameResult result = renderFrame(ready, options);
        stages += result.times;
        counts += result.counts;
        traced += result.seconds;
    }
    const double peak = peakMegabytes(); // before rays are recorded
    // The same rays, recorded by one thread (recording is not part of any time above) and replayed by all.
    RayRecord record;
    RayCounts recorded;
    {
        const tbb::global_control oneThread(tbb::global_control::max_allowed_parallelism, 1);
        FrameOptions options;
        options.spp = recordSpp;
        options.seed = frameSeed(0, scene.render.frames.back(), false);
        options.record = &record;
        recorded = renderFrame(ready, options).counts;
    }
    const ReplayTimes replay = replayRays(ready.embree(), record, 3);
    const double raysPerSecond = static_cast<double>(counts.rays()) / traced;
    const double embreeRaysPerSecond = static_cast<double>(recorded.rays()) / replay.total();
    const double frameTotal = stages.deformation + stages.gradient + stages.bvh + traced;
    const double inThreads = stages.cameraRays + stages.scatteredRays + stages.shadowRays + stages.shading + stages.film;
    const double perThread = inThreads > 0 ? traced / inThreads : 0; // thread seconds to wall clock
    return {{"name", bench.name},
            {"frames", scene.render.frames.size()},
            {"spp", spp},
            {"samples_per_s", static_cast<double>(counts.paths) / traced},
            {"rays_per_s", raysPerSecond},
            {"rays_per_sample", static_cast<double>(counts.rays()) / static_cast<double>(counts.paths)},
            {"embree_rays_per_s", embreeRaysPerSecond},
            {"ratio_to_embree", raysPerSecond / embreeRaysPerSecond},
            {"share",
             {{"deformation", stages.deformation / frameTotal},
              {"gradient", stages.gradient / frameTotal},
              {"bvh", stages.bvh / frameTotal},
              {"traversal", (stages.cameraRays + stages.scatteredRays + stages.shadowRays) * perThread / frameTotal},
              {"shading", stages.shading * perThread / frameTotal},
              {"film", stages.film * perThread / frameTotal}}},
            {"seconds_per_frame", frameTotal / static_cast<double>(scene.render.frames.size())},
            {"peak_mb", peak}};
}

/// Measures in a process of its own, so that the peak memory is this scene's. The parent must not have started threads.
nlohmann::json measureApart(const BenchScene &bench, int spp, int recordSpp, int threads) {
    int channel[2];
    if (pipe(channel) != 0) throw RunError("can't make a pipe");
    const pid_t child = fork();
    if (child < 0) throw RunError("can't start a process");
    if (child == 0) {
        close(channel[0]);
        int code = 0;
        try {
            std::unique_ptr<tbb::global_control> limit;
            if (threads > 0)
                limit =
                    std::make_unique<tbb::global_control>(tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(threads));
            const std::string text = measure(bench, spp, recordSpp).dump();
            if (write(channel[1], text.data(), text.size()) != static_cast<ssize_t>(text.size())) code = 1;
        } catch (const std::exception &error) {
            std::cerr << "taut_bench: error: " << bench.name << ": " << error.what() << std::endl;
            code = 1;
        }
        std::_Exit(code);
    }
    close(channel[1]);
    std::string text;
    char buffer[4096];
    for (ssize_t got = 0; (got = read(channel[0], buffer, sizeof buffer)) > 0;) text.append(buffer, static_cast<std::size_t>(got));
    close(channel[0]);
    int status = 0;
    waitpid(child, &status, 0);
    if (status != 0) throw RunError("the measurement of '" + bench.name + "' failed");
    return nlohmann::json::parse(text);
}

void printTable(const nlohmann::json &scenes) {
    fmt::print("{:<20}{:>10}{:>9}{:>9}{:>8} |{:>7}{:>7}{:>6}{:>7}{:>7}{:>6} |{:>8}\n", "scene", "Mpaths/s", "Mrays/s", "Embree", "ratio",
               "deform", "grad", "bvh", "trav", "shade", "film", "peak MB");
    for (const auto &s : scenes) {
        const auto share = [&](const char *name) { return 100 * s["share"][name].get<double>(); };
        fmt::print("{:<20}{:>10.3f}{:>9.2f}{:>9.2f}{:>8.2f} |{:>6.1f}%{:>6.1f}%{:>5.1f}%{:>6.1f}%{:>6.1f}%{:>5.1f}% |{:>8.0f}\n",
                   s["name"].get<std::string>(), s["samples_per_s"].get<double>() * 1e-6, s["rays_per_s"].get<double>() * 1e-6,
                   s["embree_rays_per_s"].get<double>() * 1e-6, s["ratio_to_embree"].get<double>(), share("deformation"), share("gradient"),
                   share("bvh"), share("traversal"), share("shading"), share("film"), s["peak_mb"].get<double>());
    }
}

} // namespace

int main(int argc, char **argv) {
    CLI::App app("Measures the renderer against bare Embree calls for the same rays.", "taut_bench");
    std::string output;
    std::vector<std::string> only;
    int spp = 16;
    int recordSpp = 4;
    int threads = 0;
    app.add_option("--output", output, "Write the table as JSON");
    app.add_option("--scene", only, "Only these scenes");
    app.add_option("--spp", spp, "Samples per pixel of the timed render")->check(CLI::Range(1, 4096));
    app.add_option("--record-spp", recordSpp, "Samples per pixel recorded for the replay")->check(CLI::Range(1, 64));
    app.add_option("-t,--threads", threads, "Threads (default: all)")->check(CLI::Range(1, 1024));
    CLI11_PARSE(app, argc, argv);
    try {
        nlohmann::json scenes = nlohmann::json::array();
        for (const BenchScene &bench : benchScenes())
            if (only.empty() || std::find(only.begin(), only.end(), bench.name) != only.end())
                scenes.push_back(measureApart(bench, spp, recordSpp, threads));
        printTable(scenes);
        if (!output.empty())
            writeTextFile(
                output,
                nlohmann::json{{"threads", threads > 0 ? threads : tbb::info::default_concurrency()}, {"scenes", scenes}}.dump(2) + "\n");
    } catch (const std::exception &error) {
        std::cerr << "taut_bench: error: " << error.what() << std::endl;
        return 1;
    }
    return 0;
}
