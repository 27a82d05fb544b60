#include "taut/render/shading.h"

#include "taut/scene/material_gloss.h"

namespace taut {

namespace {

Multiscatter multiscatterAt(const Material &material, const Bsdf &bsdf) {
    if (material.multiscatter != Multiscatter::Auto) return material.multiscatter;
    if (!bsdf.correlated) return Multiscatter::Off; // table and walk are those of correlated heights
    return chooseMultiscatter(bsdf.micro, bsdf.type == BsdfType::Dielectric);
}

Bsdf makeBsdf(const PreparedMaterial &prepared, const Scene &scene, const SurfacePoint &point, float sense, Vec3 &baseColor) {
    const Vec2 &uv = point.uv;
    const Material &material = *prepared.material;
    Bsdf bsdf;
    baseColor = evaluate(material.color, scene, uv);
    bsdf.correlated = material.masking == Masking::Correlated;
    bsdf.eta = material.ior;
    switch (material.type) {
    case MaterialType::Diffuse:
        bsdf.type = BsdfType::Diffuse;
        bsdf.albedo = baseColor;
        return bsdf;
    case MaterialType::Conductor:
        bsdf.type = material.hasConductorIor ? BsdfType::Conductor : BsdfType::SchlickConductor;
        bsdf.conductorEta = material.conductorEta;
        bsdf.conductorK = material.conductorK;
        bsdf.f0 = baseColor;
        break;
    case MaterialType::Dielectric:
        bsdf.type = BsdfType::Dielectric;
        bsdf.tint = baseColor;
        if (!point.front) bsdf.eta = 1 / material.ior;
        break;
    case MaterialType::Coated:
        bsdf.type = BsdfType::Coated;
        bsdf.albedo = baseColor;
        break;
    case MaterialType::MetallicRoughness: {
        const float metallic = glm::clamp(evaluate(material.metallic, scene, uv), 0.0F, 1.0F);
        bsdf.type = BsdfType::MetallicRoughness;
        bsdf.albedo = baseColor * (1 - metallic);
        bsdf.f0 = glm::mix(Vec3(sqr((material.ior - 1) / (material.ior + 1))), baseColor, metallic);
        break;
    }
    }
    bsdf.diffuseEscape = prepared.coatEscape;
    bsdf.micro = transformAt(material, scene, uv, point.stretch, point.tangent, sense);
    if (material.type == MaterialType::Conductor || material.type == MaterialType::Dielectric)
        bsdf.multiscatter = multiscatterAt(material, bsdf);
    return bsdf;
}

} // namespace

std::vector<PreparedMaterial> prepareMaterials(const Scene &scene) {
    std::vector<PreparedMaterial> prepared;
    for (const Material &material : scene.materials) prepared.push_back({&material, coatEscape(material.ior)});
    return prepared;
}

SurfacePoint surfacePointAt(const RenderScene &scene, const std::vector<PreparedMaterial> &materials, const Hit &hit, const Vec3 &wo) {
    SurfacePoint point;
    const RenderObject &object = scene.objects()[scene.objectOfGeometry(hit.geometry)];
    const Surface &surface = object.surface;
    const SurfaceFrame &vertices = object.frame;
    const Index3 t = surface.triangles[hit.primitive];
    const Vec3 b(1 - hit.u - hit.v, hit.u, hit.v);
    const auto interpolate = [&](const auto &values) { return values[t.x] * b.x + values[t.y] * b.y + values[t.z] * b.z; };

    point.object = &object;
    point.corners = t;
    point.barycentrics = b;
    point.position = interpolate(vertices.positions);
    const Vec3 &p0 = vertices.positions[t.x];
    Vec3 geometric = glm::cross(vertices.positions[t.y] - p0, vertices.positions[t.z] - p0);
    const float doubleArea = glm::length(geometric);
    geometric = doubleArea > 0 ? geometric / doubleArea : wo;
    if (object.mirrored) geometric = -geometric;
    point.front = glm::dot(geometric, wo) >= 0;
    point.geometricNormal = point.front ? geometric : -geometric;

    Vec3 normal = interpolate(vertices.normals);
    const float normalLength = glm::length(normal);
    normal = normalLength > 0 ? normal / normalLength : geometric;
    const Vec4 tangent = interpolate(object.tangents);
    point.frame = smoothFrameFromNormal(point.front ? normal : -normal);
    const Vec2 projected(glm::dot(point.frame.s, Vec3(tangent)), glm::dot(point.frame.t, Vec3(tangent)));
    const float projectedLength = glm::length(projected);
    if (projectedLength > 0) point.tangent = projected / projectedLength;
    // The sense of b0 is held against the outside; the frame follows the viewer's side.
    const float sense = (tangent.w < 0) == point.front ? -1.0F : 1.0F;

    if (!object.stretch.empty()) {
        SymmetricTensor v;
        const auto &stretch = object.stretch;
        v.diagonal = stretch[t.x].diagonal * b.x + stretch[t.y].diagonal * b.y + stretch[t.z].diagonal * b.z;
        v.offDiagonal = stretch[t.x].offDiagonal * b.x + stretch[t.y].offDiagonal * b.y + stretch[t.z].offDiagonal * b.z;
        const Vec3 vs = v.times(point.frame.s);
        point.stretch = {glm::dot(point.frame.s, vs), glm::dot(point.frame.t, vs), glm::dot(point.frame.t, v.times(point.frame.t))};
    }
    if (!surface.uvs.empty()) point.uv = interpolate(surface.uvs);

    const Index slot = surface.triangleSlots.empty() ? 0 : surface.triangleSlots[hit.primitive];
    const Object &source = *object.object;
    const Index material = source.materials[std::min<std::size_t>(slot, source.materials.size() - 1)];
    point.bsdf = makeBsdf(materials[material], scene.scene(), point, sense, point.baseColor);
    if (source.emission.value != Vec3(0) && (point.front || source.emissionTwoSided))
        point.emission = evaluate(source.emission, scene.scene(), point.uv);
    return point;
}

} // namespace taut
