#include "study/scenes/bench_scenes.h"

#include "study/scenes/scenes.h"

#include "taut/base/error.h"
#include "taut/scene/load_scene.h"

#include <filesystem>

namespace taut::chart {

namespace {

constexpr int kFrames = 4;

Material brushed() {
    Material material = brushedMetal(0.08F, 0.4F);
    material.masking = Masking::Separable;
    material.multiscatter = Multiscatter::Off;
    return material;
}

/// Smooth enough for Cycles' Fresnel, which is that of the surface and not of its facets, to be the same.
Material glass() {
    Material material = brushed();
    material.name = "glass";
    material.type = BsdfType::Dielectric;
    material.alphaX.value = material.alphaY.value = 0.01F;
    material.ior = 1.5F;
    return material;
}

/// A torus, of 199,712 triangles where nothing else is said, on grey ground.
Scene onGround(int maxEvents, const Material &material, Mesh torus = makeTorus(632, 158, 1, 0.4F)) {
    Material grey;
    grey.name = "ground";
    grey.color.value = Vec3(0.5F);
    return torusScene(std::move(torus), -0.4, {material, grey}, 512, maxEvents);
}

Scene under(Scene scene, Environment environment) {
    scene.environment = std::move(environment);
    return scene;
}

Scene underLamp(Scene scene) {
    scene.lights = {lampAbove()};
    return scene;
}

Scene deforming(Scene scene) {
    scene.objects[0].deformers = {deformer(DeformerType::Shear, ramp(0.8, kFrames), 0, 2)};
    scene.render.frames.clear();
    for (int frame = 1; frame <= kFrames; ++frame) scene.render.frames.push_back(frame);
    return scene;
}

/// A square light above the camera's left, in proportion to how far it looks.
Light lampBeside(const Camera &camera) {
    const DVec3 target = camera.lookAt.at(1);
    const DVec3 back = camera.position.at(1) - target;
    const double size = glm::length(back);
    const DVec3 right = glm::normalize(glm::cross(camera.up.at(1), back)) * size;
    const DVec3 side = 0.25 * right;
    const DVec3 centre = target + 0.7 * back - 0.5 * right + DVec3(0, 0, 0.7 * size);
    const DVec3 up = 0.25 * size * glm::normalize(glm::cross(target - centre, side));
    return {Vec3(40), QuadLight{centre - 0.5 * (side + up), side, up}}; // side x up points at the target
}

Scene character(const std::string &file) {
    Warnings ignored;
    Scene scene = loadScene(file, {}, ignored);
    scene.lights.clear();
    scene.environment.reset();
    scene.render.width = scene.render.height = 512;
    scene.render.maxEvents = 6;
    scene.render.boxFilter = true;
    scene.render.frames = {13};
    scene.camera.fovY = Keyed<double>(0.6 * scene.camera.fovY.at(1)); // to see more of it, and less around it
    for (Material &material : scene.materials) {
        material.masking = Masking::Separable;
        material.multiscatter = Multiscatter::Off;
    }
    return scene;
}

} // namespace

std::vector<BenchScene> characterScenes(const std::string &file) {
    const std::string name = std::filesystem::path(file).stem().string();
    return {{name + ", sky", 1, [=] { return under(character(file), constantEnvironment(Vec3(1))); }},
            {name + ", lamp", 1,
             [=] {
                 Scene scene = character(file);
                 scene.lights = {lampBeside(scene.camera)};
                 return scene;
             }},
            {name + ", HDR", 1, [=] { return under(character(file), studioEnvironment()); }}};
}

const std::vector<BenchScene> &benchScenes() {
    static const std::vector<BenchScene> scenes{
        {"furnace", 1,
         [] { return under(torusScene(makeTorus(632, 158, 1, 0.4F), 0, {brushed()}, 512, 8), constantEnvironment(Vec3(1))); }},
        {"area light", 1, [] { return underLamp(onGround(6, brushed())); }},
        {"sky", 1, [] { return under(onGround(8, brushed()), constantEnvironment(Vec3(1))); }},
        {"HDR environment", 1, [] { return under(onGround(8, brushed()), studioEnvironment()); }},
        {"glass", 1, [] { return under(onGround(8, glass()), studioEnvironment()); }},
        {"deforming 200k", kFrames, [] { return deforming(underLamp(onGround(6, brushed()))); }},
        {"deforming 1.2M", kFrames,
         [] { return deforming(underLamp(onGround(6, brushed(), makeTorus(1548, 387, 1, 0.4F)))); }}}; // 1,198,152 triangles
    return scenes;
}

} // namespace taut::chart
