#include "taut/render/shading.h"

#include "taut/scene/material_gloss.h"

namespace taut {

namespace {

Multiscatter multiscatterAt(const PreparedMaterial &prepared, const MicroTransform &m) {
    const Multiscatter model = multiscatterOf(*prepared.material, prepared.multiscatter.model);
    if (model != Multiscatter::Auto) return model;
    return chooseMultiscatter(m, bsdfInfo(prepared.material->type).transmits, prepared.multiscatter.negligibleLoss);
}

Bsdf bsdfAt(const PreparedMaterial &prepared, const Scene &scene, const SurfacePoint &point, float sense) {
    const Material &material = *prepared.material;
    const BsdfInfo &info = bsdfInfo(material.type);
    const float metallic = info.reads(kMetallicKey) ? evaluate(material.metallic, scene, point.uv) : 0.0F;
    Bsdf bsdf = bsdfOf(prepared, point.baseColor, metallic, point.facing);
    if (!info.microsurface) return bsdf;
    const bool leans = point.object->object->lean;
    // Stored gloss comes as sqrt(M M^T) in the place of V.
    bsdf.micro = point.object->storedPoisson.empty()
                     ? transformAt(material, scene, point.uv, point.stretch, point.tangent, sense, leans ? &point.lean : nullptr)
                     : microTransform(point.stretch.x, point.stretch.y, point.stretch.y, point.stretch.z);
    bsdf.multiscatter = multiscatterAt(prepared, bsdf.micro);
    return bsdf;
}

/// V, the rotated tangent and the lean at the point, in its frame.
void deformationAt(const RenderObject &object, const HitCorners<false> &corners, SurfacePoint &point) {
    const SurfaceStep &step = corners.step();
    const Vec3 &s = point.frame.s;
    const Vec3 &t = point.frame.t;
    if (!step.ds.empty()) {
        const Vec3 ds = corners.interpolate(&SurfaceStep::ds);
        const Vec3 dt = corners.interpolate(&SurfaceStep::dt);
        const PlanarPolar polar = polarInFrame({glm::dot(s, ds), glm::dot(t, ds)}, {glm::dot(s, dt), glm::dot(t, dt)});
        point.stretch = polar.stretch;
        point.tangent = polar.tangent;
    } else if (!step.stretch.empty()) {
        point.stretch = decodeStretch(corners.stretchIsConstant() ? GradientInterpolation::Stretch : object.plan.interpolation,
                                      corners.stretch(), s, t);
    }
    if (step.lean.empty()) return;
    const Vec3 lean = corners.interpolate(&SurfaceStep::lean) * point.facing;
    point.lean = {glm::dot(s, lean), glm::dot(t, lean)};
}

} // namespace

std::vector<PreparedMaterial> prepareMaterials(const Scene &scene, const ScenePlan &plan) {
    std::vector<PreparedMaterial> prepared;
    for (Index i = 0; i < std::max<std::size_t>(scene.materials.size(), 1); ++i) {
        const Material &material = scene.materialAt(i);
        prepared.push_back(
            {&material, coatEscape(material.ior), i < plan.materials.size() ? plan.materials[i] : MultiscatterPlan{}, plan.bearableWaste});
    }
    return prepared;
}

Bsdf bsdfOf(const PreparedMaterial &prepared, const Vec3 &color, float metallic, float facing) {
    const Material &material = *prepared.material;
    Bsdf bsdf;
    bsdf.type = material.type;
    bsdf.correlated = material.masking == Masking::Correlated;
    bsdf.bearableWaste = prepared.bearableWaste;
    bsdf.eta = facing < 0 && bsdfInfo(material.type).refracts ? 1 / material.ior : material.ior;
    const MaterialValues values{color, material.ior, metallic, prepared.coatEscape, material.conductorEta, material.conductorK};
    onBsdf(material.type, [&](auto kind) { decltype(kind)::Class::make(values, bsdf); });
    return bsdf;
}

SurfacePoint surfacePointAt(const RenderScene &scene, const std::vector<PreparedMaterial> &materials, const Hit &hit, const Vec3 &wo,
                            float time) {
    SurfacePoint point;
    const RenderObject &object = scene.objects()[scene.objectOfGeometry(hit.geometry)];
    const Surface &surface = object.surface;
    const HitCorners<false> corners(object, hit, time);
    const Index3 t = corners.corners();
    const Vec3 b = corners.barycentrics();
    point.object = &object;
    point.corners = t;
    point.barycentrics = b;
    const InterpolatedSurface at = corners.surface();
    const SurfaceGeometry geometry = surfaceGeometry(at, wo);
    point.position = at.position;
    point.geometricNormal = geometry.geometricNormal;
    point.clearance = geometry.clearance;
    point.facing = geometry.facing;
    point.frame = Frame(geometry.s, geometry.t, geometry.n);
    point.tangent = geometry.tangent;
    deformationAt(object, corners, point);
    if (!surface.uvs.empty()) point.uv = surface.uvs[t.x] * b.x + surface.uvs[t.y] * b.y + surface.uvs[t.z] * b.z;

    const PreparedMaterial &material = materials[materialOfTriangle(object, hit.primitive)];
    point.baseColor = evaluate(material.material->color, scene.scene(), point.uv);
    point.bsdf = bsdfAt(material, scene.scene(), point, geometry.sense);
    const Object &source = *object.object;
    if (source.emission.value != Vec3(0) && (point.facing > 0 || source.emissionTwoSided))
        point.emission = evaluate(source.emission, scene.scene(), point.uv);
    return point;
}

} // namespace taut
