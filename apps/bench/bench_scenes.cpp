#include "bench_scenes.h"

#include "taut/mesh/shapes.h"

#include <memory>

namespace taut::bench {

namespace {

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
    material.type = BsdfType::Conductor;
    material.alphaX.value = 0.08F;
    material.alphaY.value = 0.4F;
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

constexpr int kAround = 632;
constexpr int kAcross = 158; // 199,712 triangles

/// A torus of 2 x around x across triangles, with or without a ground of 20 x 20 m.
Scene torusScene(bool ground, int maxEvents, int around = kAround, int across = kAcross) {
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

Scene underEnvironment(Scene scene, Environment environment) {
    scene.environment = std::move(environment);
    return scene;
}

Scene underArea(Scene scene) {
    scene.lights = {{Vec3(10), QuadLight{DVec3(1, -1, 3), DVec3(-2, 0, 0), DVec3(0, 2, 0)}}}; // facing down
    return scene;
}

Scene glassScene() {
    Scene scene = underEnvironment(torusScene(true, 8), studioEnvironment());
    scene.materials[0] = glass();
    return scene;
}

Scene deforming(Scene scene, int frames) {
    DeformerKeys shear;
    shear.type = DeformerType::Shear;
    shear.axis = 0;
    shear.axis2 = 2;
    shear.amount.keys = {{1, 0.0}, {static_cast<double>(frames), 0.8}};
    scene.objects[0].deformers = {shear};
    scene.render.frames.clear();
    for (int frame = 1; frame <= frames; ++frame) scene.render.frames.push_back(frame);
    return scene;
}

constexpr int kFrames = 4;

} // namespace

const std::vector<BenchScene> &benchScenes() {
    static const std::vector<BenchScene> scenes{
        {"furnace", 1, [] { return underEnvironment(torusScene(false, 8), constantEnvironment(Vec3(1))); }},
        {"area light", 1, [] { return underArea(torusScene(true, 6)); }},
        {"sky", 1, [] { return underEnvironment(torusScene(true, 8), constantEnvironment(Vec3(1))); }},
        {"HDR environment", 1, [] { return underEnvironment(torusScene(true, 8), studioEnvironment()); }},
        {"glass", 1, glassScene},
        {"deforming 200k", kFrames, [] { return deforming(underArea(torusScene(true, 6)), kFrames); }},
        {"deforming 1.2M", kFrames, [] { return deforming(underArea(torusScene(true, 6, 1548, 387)), kFrames); }}}; // 1,198,152 triangles
    return scenes;
}

} // namespace taut::bench
