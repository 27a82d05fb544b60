#include "taut/render/shading.h"

#include "taut/scene/material_gloss.h"

namespace taut {

namespace {

Multiscatter multiscatterAt(const PreparedMaterial &prepared, const Bsdf &bsdf) {
    if (prepared.material->multiscatter != Multiscatter::Auto) return prepared.material->multiscatter;
    if (!bsdf.correlated) return Multiscatter::Off; // table and walk are those of correlated heights
    if (prepared.multiscatter.model != Multiscatter::Auto) return prepared.multiscatter.model;
    return chooseMultiscatter(bsdf.micro, bsdf.type == BsdfType::Dielectric, prepared.multiscatter.negligibleLoss);
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
    bsdf.bearableWaste = prepared.bearableWaste;
    const bool leans = point.object->object->lean;
    // Stored gloss comes as sqrt(M M^T) in the place of V.
    bsdf.micro = point.object->storedPoisson.empty()
                     ? transformAt(material, scene, uv, point.stretch, point.tangent, sense, leans ? &point.lean : nullptr)
                     : microTransform(point.stretch.x, point.stretch.y, point.stretch.y, point.stretch.z);
    if (material.type == MaterialType::Conductor || material.type == MaterialType::Dielectric)
        bsdf.multiscatter = multiscatterAt(prepared, bsdf);
    return bsdf;
}

} // namespace

std::vector<PreparedMaterial> prepareMaterials(const Scene &scene, const ScenePlan &plan) {
    std::vector<PreparedMaterial> prepared;
    for (std::size_t i = 0; i < scene.materials.size(); ++i)
        prepared.push_back({&scene.materials[i], coatEscape(scene.materials[i].ior), plan.materials[i], plan.bearableWaste});
    return prepared;
}

namespace {

/// Attributes of a triangle's three corners at one time: between two steps of the shutter where there are several.
class CornerValues {
  public:
    CornerValues(const RenderObject &object, const Index3 &corners, Index triangle, float time) : corners_(corners), triangle_(triangle) {
        const std::size_t last = object.steps.size() - 1;
        const float at = time * static_cast<float>(last);
        const std::size_t before = last == 0 ? 0 : std::min(static_cast<std::size_t>(at), last - 1);
        first_ = &object.steps[before];
        second_ = last == 0 ? nullptr : &object.steps[before + 1];
        u_ = at - static_cast<float>(before);
    }
    template <class T> [[nodiscard]] T at(std::vector<T> SurfaceStep::*values, Index i) const {
        const T &a = (first_->*values)[i];
        return second_ == nullptr ? a : mix(a, (second_->*values)[i]);
    }
    template <class T> [[nodiscard]] T interpolate(std::vector<T> SurfaceStep::*values, const Vec3 &b) const {
        return weighted(at(values, corners_.x), at(values, corners_.y), at(values, corners_.z), b);
    }
    /// V in the form of its scheme; of the mesh, the face or the corners.
    [[nodiscard]] SymmetricTensor stretch(const RenderObject &object, const Vec3 &b) const {
        if (first_->stretch.size() == 1) return at(&SurfaceStep::stretch, 0);
        return object.stretchOnFaces() ? at(&SurfaceStep::stretch, triangle_) : interpolate(&SurfaceStep::stretch, b);
    }
    [[nodiscard]] const SurfaceStep &step() const { return *first_; }

  private:
    template <class T> static T weighted(const T &x, const T &y, const T &z, const Vec3 &b) { return x * b.x + y * b.y + z * b.z; }
    static SymmetricTensor weighted(const SymmetricTensor &x, const SymmetricTensor &y, const SymmetricTensor &z, const Vec3 &b) {
        return {weighted(x.diagonal, y.diagonal, z.diagonal, b), weighted(x.offDiagonal, y.offDiagonal, z.offDiagonal, b)};
    }
    template <class T> [[nodiscard]] T mix(const T &x, const T &y) const { return glm::mix(x, y, u_); }
    [[nodiscard]] SymmetricTensor mix(const SymmetricTensor &x, const SymmetricTensor &y) const {
        return {glm::mix(x.diagonal, y.diagonal, u_), glm::mix(x.offDiagonal, y.offDiagonal, u_)};
    }
    Index3 corners_;
    Index triangle_;
    const SurfaceStep *first_;
    const SurfaceStep *second_;
    float u_;
};

/// V, the rotated tangent and the lean at the point, in its frame.
void deformationAt(const RenderObject &object, const CornerValues &values, SurfacePoint &point) {
    const SurfaceStep &step = values.step();
    const Vec3 &s = point.frame.s;
    const Vec3 &t = point.frame.t;
    if (!step.ds.empty()) {
        const Vec3 ds = values.interpolate(&SurfaceStep::ds, point.barycentrics);
        const Vec3 dt = values.interpolate(&SurfaceStep::dt, point.barycentrics);
        const PlanarPolar polar = polarInFrame({glm::dot(s, ds), glm::dot(t, ds)}, {glm::dot(s, dt), glm::dot(t, dt)});
        point.stretch = polar.stretch;
        point.tangent = polar.tangent;
    } else if (!step.stretch.empty()) {
        const bool onFaces = object.stretchOnFaces() || step.stretch.size() == 1;
        point.stretch = decodeStretch(onFaces ? GradientInterpolation::Stretch : object.plan.interpolation,
                                      values.stretch(object, point.barycentrics), s, t);
    }
    if (step.lean.empty()) return;
    const Vec3 lean = values.interpolate(&SurfaceStep::lean, point.barycentrics) * (point.front ? 1.0F : -1.0F);
    point.lean = {glm::dot(s, lean), glm::dot(t, lean)};
}

} // namespace

SurfacePoint surfacePointAt(const RenderScene &scene, const std::vector<PreparedMaterial> &materials, const Hit &hit, const Vec3 &wo,
                            float time) {
    SurfacePoint point;
    const RenderObject &object = scene.objects()[scene.objectOfGeometry(hit.geometry)];
    const Surface &surface = object.surface;
    const Index3 t = surface.triangles[hit.primitive];
    const Vec3 b(1 - hit.u - hit.v, hit.u, hit.v);
    const CornerValues values(object, t, hit.primitive, time);

    point.object = &object;
    point.corners = t;
    point.barycentrics = b;
    InterpolatedSurface at;
    const Vec3 p0 = values.at(&SurfaceStep::positions, t.x);
    const Vec3 p1 = values.at(&SurfaceStep::positions, t.y);
    const Vec3 p2 = values.at(&SurfaceStep::positions, t.z);
    at.position = p0 * b.x + p1 * b.y + p2 * b.z;
    at.e1 = p1 - p0;
    at.e2 = p2 - p0;
    at.normal = values.interpolate(&SurfaceStep::normals, b);
    at.tangent = values.interpolate(&SurfaceStep::tangents, b);
    at.corners = std::max(extentOf(p0), std::max(extentOf(p1), extentOf(p2)));
    at.hand = object.mirrored ? -1.0F : 1.0F;
    if (object.instanced) place(at, affineAt(object.placements, time));
    const SurfaceGeometry geometry = surfaceGeometry(at, wo);
    point.position = at.position;
    point.geometricNormal = geometry.geometricNormal;
    point.clearance = geometry.clearance;
    point.front = geometry.facing > 0;
    point.frame = Frame(geometry.s, geometry.t, geometry.n);
    point.tangent = geometry.tangent;
    deformationAt(object, values, point);
    if (!surface.uvs.empty()) point.uv = surface.uvs[t.x] * b.x + surface.uvs[t.y] * b.y + surface.uvs[t.z] * b.z;

    const Index slot = surface.triangleSlots.empty() ? 0 : surface.triangleSlots[hit.primitive];
    const Object &source = *object.object;
    const Index material = source.materials[std::min<std::size_t>(slot, source.materials.size() - 1)];
    point.bsdf = makeBsdf(materials[material], scene.scene(), point, geometry.sense, point.baseColor);
    if (source.emission.value != Vec3(0) && (point.front || source.emissionTwoSided))
        point.emission = evaluate(source.emission, scene.scene(), point.uv);
    return point;
}

} // namespace taut
