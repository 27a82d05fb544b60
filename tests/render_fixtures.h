#pragma once
/// Small scenes made in code, and images of them, for tests of the renderer.

#include "taut/mesh/shapes.h"
#include "taut/render/frame_render.h"

#include <memory>

namespace taut::test {

inline Object makeObject(Mesh mesh, Index material = 0) {
    Object object;
    object.name = mesh.name;
    object.mesh = std::make_shared<const Mesh>(std::move(mesh));
    object.materials = {material};
    return object;
}

inline Material ggxMaterial(float alphaX, float alphaY, float rotation = 0) {
    Material material;
    material.name = "ggx";
    material.type = BsdfType::Conductor;
    material.alphaX.value = alphaX;
    material.alphaY.value = alphaY;
    material.rotation.value = rotation;
    return material;
}

/// A square image of one object under a quad light and a dim constant sky, seen from above at an angle.
inline Scene smallScene(Object object, const Material &material, int size = 48) {
    Scene scene;
    scene.render.width = size;
    scene.render.height = size;
    scene.render.boxFilter = true;
    scene.render.maxEvents = 4;
    scene.materials = {material};
    scene.objects.push_back(std::move(object));
    scene.camera.position = DVec3(0.3, -2.2, 1.9);
    scene.camera.lookAt = DVec3(0);
    scene.lights.push_back({Vec3(6, 5, 4), QuadLight{DVec3(-1.5, 1, 1.5), DVec3(0, 0, 1), DVec3(1.5, 0, 0), true}});
    scene.environment = constantEnvironment(Vec3(0.2F, 0.25F, 0.3F));
    return scene;
}

/// A torus that is sheared from rest at frame 1 to 0.8 along x over z at frame 3.
inline Object shearedTorus(int around, int across) {
    Object torus = makeObject(makeTorus(around, across, 0.7F, 0.25F));
    DeformerKeys shear;
    shear.type = DeformerType::Shear;
    shear.axis = 0;
    shear.axis2 = 2;
    shear.amount.keys = {{1, 0.0}, {3, 0.8}};
    torus.deformers = {shear};
    return torus;
}

/// An object's surface at a frame, in world space.
inline DeformedVertices surfaceOf(const Object &object, double frame, double fps = 24) {
    ObjectSurface surface;
    prepareObjectSurface(object, fps, surface);
    double ignored = 0;
    surfaceAtFrame(surface, frame, fps, DMat4(1), ignored, ignored);
    return surface.vertices;
}

/// The object with its points taken through a linear map: the largest difference of the metric that its surface vertices find from
/// the map's own in their tangent planes.
inline float linearError(Object object, const DMat3 &linear) {
    std::vector<Vec3> points;
    for (const Vec3 &p : object.mesh->positions) points.emplace_back(linear * DVec3(p));
    object.points = pointFrames({std::span<const Vec3>(points)});
    ObjectSurface surface;
    prepareObjectSurface(object, 24, surface);
    double ignored = 0;
    surfaceAtFrame(surface, 1, 24, DMat4(1), ignored, ignored);
    double error = 0;
    for (std::size_t s = 0; s < surface.surface.normals.size(); ++s) {
        const Frame frame = surface.surface.frameAt(s);
        const DVec3 e1 = linear * DVec3(frame.s);
        const DVec3 e2 = linear * DVec3(frame.t);
        const DVec3 f1(surface.gradient.f1[s]);
        const DVec3 f2(surface.gradient.f2[s]);
        const DVec3 difference(glm::dot(f1, f1) - glm::dot(e1, e1), glm::dot(f1, f2) - glm::dot(e1, e2),
                               glm::dot(f2, f2) - glm::dot(e2, e2));
        error = std::max(error, glm::length(difference));
    }
    return static_cast<float>(error);
}

/// Renders one frame; interleaved channels of film.resolve().
inline std::vector<float> renderImage(const Scene &scene, double frame, int spp, const std::vector<std::string_view> &aovs = {},
                                      std::uint32_t seed = 1) {
    RenderScene ready(scene, false);
    StageTimes times;
    ready.setFrame(frame, times);
    FrameOptions options;
    options.spp = spp;
    options.aovs = aovsNamed(aovs, "aovs");
    options.seed = seed;
    const FrameResult result = renderFrame(ready, options);
    return result.film.resolve();
}

/// R G B of R G B A.
inline std::vector<float> coloursOf(const std::vector<float> &rgba) {
    std::vector<float> rgb;
    for (std::size_t i = 0; i < rgba.size(); ++i)
        if (i % 4 < 3) rgb.push_back(rgba[i]);
    return rgb;
}

/// Largest |a - b| / max(|a|, |b|, floor) over all values.
inline float greatestDifference(const std::vector<float> &a, const std::vector<float> &b, float floor = 1e-3F) {
    if (a.size() != b.size()) return kInfinity;
    float greatest = 0;
    for (std::size_t i = 0; i < a.size(); ++i) {
        const float difference = std::fabs(a[i] - b[i]) / std::fmax(floor, std::fmax(std::fabs(a[i]), std::fabs(b[i])));
        if (!(difference <= greatest)) greatest = difference; // NaN counts as the greatest
    }
    return greatest;
}

/// Share of values that differ by more than `tolerance`, relative as above.
inline double shareOver(const std::vector<float> &a, const std::vector<float> &b, float tolerance, float floor = 1e-3F) {
    std::size_t count = 0;
    for (std::size_t i = 0; i < a.size(); ++i)
        if (!(std::fabs(a[i] - b[i]) <= tolerance * std::fmax(floor, std::fmax(std::fabs(a[i]), std::fabs(b[i]))))) ++count;
    return static_cast<double>(count) / static_cast<double>(a.size());
}

inline DeformerKeys stretchDeformer(const DVec3 &factor) {
    DeformerKeys keys;
    keys.type = DeformerType::Stretch;
    keys.factor = factor;
    return keys;
}

/// x displaced by `amount` times y.
inline DeformerKeys shearDeformer(double amount, int axis = 0, int axis2 = 1) {
    DeformerKeys keys;
    keys.type = DeformerType::Shear;
    keys.axis = axis;
    keys.axis2 = axis2;
    keys.amount = amount;
    return keys;
}

} // namespace taut::test
