#include "study/scenes/scenes.h"

namespace taut::chart {

Object objectOf(Mesh mesh, Index material) {
    Object object;
    object.name = mesh.name.empty() ? "object" : mesh.name;
    object.mesh = std::make_shared<const Mesh>(std::move(mesh));
    object.materials = {material};
    return object;
}

Material brushedMetal(float alphaX, float alphaY) {
    Material material;
    material.name = "metal";
    material.type = BsdfType::Conductor;
    material.alphaX.value = alphaX;
    material.alphaY.value = alphaY;
    return material;
}

Keyed<double> ramp(double to, double lastFrame) {
    Keyed<double> keyed;
    keyed.keys = {{1, 0.0}, {lastFrame, to}};
    return keyed;
}

DeformerKeys deformer(DeformerType type, const Keyed<double> &amount, int axis, int axis2, double reach, double wavelength) {
    DeformerKeys keys;
    keys.type = type;
    keys.axis = axis;
    keys.axis2 = axis2;
    keys.lower = -reach;
    keys.upper = reach;
    (type == DeformerType::Wave ? keys.amplitude : keys.amount) = amount;
    keys.wavelength = wavelength;
    return keys;
}

DeformerKeys stretchBy(const Keyed<DVec3> &factor) {
    DeformerKeys keys;
    keys.type = DeformerType::Stretch;
    keys.factor = factor;
    return keys;
}

Object twistedTorus(Mesh torus, double twist, double wave) {
    Object object = objectOf(std::move(torus));
    object.deformers = {deformer(DeformerType::Twist, twist, 0, 2), deformer(DeformerType::Wave, wave, 1, 2)};
    return object;
}

Scene studyScene(Object object, const Material &material, int size) {
    Scene scene;
    scene.render.width = scene.render.height = size;
    scene.render.maxEvents = 4;
    scene.render.boxFilter = true;
    scene.materials = {material};
    scene.objects.push_back(std::move(object));
    scene.camera.position = DVec3(0.3, -2.4, 2.1);
    scene.environment = constantEnvironment(Vec3(0.2F, 0.25F, 0.3F));
    scene.lights.push_back({Vec3(6, 5, 4), QuadLight{DVec3(-0.8, 1, 1.2), DVec3(0, 0, 0.8), DVec3(1.6, 0, 0), true}});
    return scene;
}

Scene torusScene(Mesh torus, double ground, std::vector<Material> materials, int size, int maxEvents) {
    Scene scene;
    scene.render.width = scene.render.height = size;
    scene.render.maxEvents = maxEvents;
    scene.render.boxFilter = true;
    scene.objects.push_back(objectOf(std::move(torus)));
    if (materials.size() > 1) {
        scene.objects.push_back(objectOf(makeGrid(1, 1, 20), 1));
        scene.objects.back().placement.translation = DVec3(0, 0, ground);
    }
    scene.materials = std::move(materials);
    scene.camera.position = DVec3(0, -2.6, 1.8);
    scene.camera.lookAt = DVec3(0);
    return scene;
}

Light lampAbove() {
    return {Vec3(10), QuadLight{DVec3(1, -1, 3), DVec3(-2, 0, 0), DVec3(0, 2, 0)}};
}

} // namespace taut::chart
