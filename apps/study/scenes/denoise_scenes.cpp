#include "study/scenes/denoise_scenes.h"

#include "study/scenes/bench_scenes.h"
#include "study/scenes/scenes.h"

#include "taut/base/error.h"
#include "taut/scene/load_scene.h"

#include <cstdlib>
#include <filesystem>

namespace taut::chart {

namespace {

namespace fs = std::filesystem;

Scene load(const std::string &path, const std::vector<std::string> &overrides = {}) {
    Warnings warnings;
    return loadScene(path, overrides, warnings);
}

void addDemo(std::vector<DenoiseScene> &scenes, const std::string &name, double frame) {
    const std::string path = std::string(TAUT_DEMO_SCENES) + "/" + name + ".toml";
    if (fs::exists(path)) scenes.push_back({name, frame, 256, [path] { return load(path); }});
}

} // namespace

std::vector<DenoiseScene> denoiseScenes() {
    std::vector<DenoiseScene> scenes;
    for (const BenchScene &bench : benchScenes())
        if (bench.name != "deforming 1.2M") scenes.push_back({bench.name, static_cast<double>(bench.frames), 256, bench.make});
    addDemo(scenes, "panel", 18);
    addDemo(scenes, "body", 18);
    addDemo(scenes, "plates", 2);
    addDemo(scenes, "rubber", 18);
    const char *character = std::getenv("TAUT_CHARACTER");
    const std::string scene = std::string(TAUT_BLENDER_SCENES) + "/character.toml";
    if (character != nullptr && fs::exists(scene))
        scenes.push_back(
            {"character", 12, 256, [scene, file = fs::absolute(character).string()] { return load(scene, {"mesh.0.file=" + file}); }});
    return scenes;
}

std::vector<DenoiseScene> movingScenes() {
    std::vector<DenoiseScene> scenes;
    addDemo(scenes, "panel", 1);
    addDemo(scenes, "rubber", 1);
    return scenes;
}

Scene highlightScene(int size) {
    Object plate = objectOf(makeGrid(16, 16, 2));
    DeformerKeys stretch = stretchBy({});
    stretch.factor.keys = {{1, DVec3(1.6, 0.8, 1)}};
    DeformerKeys shear = deformer(DeformerType::Shear, {}, 1, 0);
    shear.amount.keys = {{1, 0.5}};
    plate.deformers = {stretch, shear};
    Scene scene;
    scene.render.width = scene.render.height = size;
    scene.render.maxEvents = 1;
    scene.materials = {brushedMetal(0.05F, 0.12F)};
    scene.objects.push_back(std::move(plate));
    scene.camera.position = DVec3(0, 0, 6);
    scene.camera.up.keys = {{1, DVec3(0, 1, 0)}};
    scene.camera.fovY.keys = {{1, 0.4}};
    scene.lights.push_back({Vec3(60), SphereLight{DVec3(0, 0, 2.5), 0.08}});
    scene.environment = constantEnvironment(Vec3(0.05F));
    return scene;
}

Scene atWidth(Scene scene, int width) {
    scene.render.height = std::max(1, static_cast<int>(static_cast<double>(width) * scene.render.height / scene.render.width + 0.5));
    scene.render.width = width;
    return scene;
}

std::string fileNameOf(std::string name) {
    for (char &c : name)
        if (c == ' ') c = '_';
    return name;
}

} // namespace taut::chart
