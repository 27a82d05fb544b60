#include "taut/render/path_state.h"
#include "taut/scene/material_gloss.h"

namespace taut {

namespace {

/// As surfaceGeometry() has it: by the triangle, not by its shading normals.
bool isSeenFromOutside(const RenderObject &object, const Hit &hit, const Ray &ray) {
    const InterpolatedSurface at = HitCorners<false>(object, hit, ray.time).surface();
    return glm::dot(glm::cross(at.e1, at.e2), ray.direction) <= 0;
}

float opacityAt(const Material &material, const Scene &scene, const Surface &surface, const Hit &hit) {
    const Index3 t = surface.triangles[hit.primitive];
    const auto at = [&](const auto &values) { return values[t.x] * (1 - hit.u - hit.v) + values[t.y] * hit.u + values[t.z] * hit.v; };
    UvPoint uv;
    if (!surface.uvs.empty()) uv = at(surface.uvs);
    if (!surface.uvs1.empty()) uv.second = at(surface.uvs1);
    const bool tinted = material.vertexColors && !surface.colors.empty();
    return opacityOf(material, scene, uv, tinted ? at(surface.colors).w : 1.0F);
}

} // namespace

bool PathTracer::State::Surfaces::isThere(std::size_t ray, const Hit &hit) const {
    const RenderScene &scene = state_.scene;
    const RenderObject &object = scene.objects()[scene.objectOfGeometry(hit.geometry)];
    const Material &material = scene.scene().materialAt(materialOfTriangle(object, hit.primitive));
    if (!mayBeAbsent(material)) return true;
    if (!material.doubleSided && !isSeenFromOutside(object, hit, shadows_ ? state_.shadowRays[ray] : state_.rays[ray])) return false;
    const float opacity = opacityAt(material, scene.scene(), object.surface, hit);
    if (opacity >= 1) return true;
    if (opacity <= 0) return false;
    const Path &path = state_.paths[shadows_ ? state_.shadowTests[ray].path : state_.active[ray]];
    return sobol1(path.sample, hash(hash(path.seed, dimension_), hash(hit.geometry, hit.primitive))) < opacity;
}

} // namespace taut
