#include "taut/render/shading.h"

#include "taut/deform/stored_gloss.h"
#include "taut/render/facet.h"
#include "taut/render/ray_cone.h"
#include "taut/scene/material_gloss.h"

namespace taut {

namespace {

/// A facet of a map is seen at any angle: a grazing one loses this many times the average over views that its choice is made by.
constexpr float kTiltedLoss = 5;

/// M where the material has this roughness at rest.
MicroTransform microAt(const Material &material, const RestRoughness &rest, const SurfacePoint &point, float sense) {
    if (!point.object->storedPoisson.empty()) return storedTransform(point.stretch);
    const bool leans = point.object->object->lean;
    return transformAt(material, rest, point.stretch, point.tangent, sense, leans ? &point.lean : nullptr);
}

/// Where a material is looked at.
struct FacetPlace {
    const Scene &scene;
    const SurfacePoint &point;
    const InterpolatedSurface &at;
    float sense; ///< SurfaceGeometry
};

/// The facet that a map makes of the point for this rest roughness, roughened by its strain.
HitFacet roughFacetAt(const Material &material, const RestRoughness &rest, const SlopeMap &map, const FacetPlace &place) {
    const SurfacePoint &point = place.point;
    const MicroTransform plain = microAt(material, rest, point, place.sense);
    const SlopeStatistics slopes = slopesAt(map, {place.scene, *point.object, point.corners, point.uv, place.at});
    HitFacet facet = facetAt(material, rest, slopes, point, place.sense, plain);
    if (point.strain > 0) facet.micro = roughenedBy(material, point.strain, facet.micro);
    return facet;
}

/// The coat's facet, in the frame of the base's.
void setCoat(const Material &material, const FacetPlace &place, Bsdf &bsdf) {
    const SurfacePoint &point = place.point;
    const float alpha = coatAlpha(material, place.scene, point.uv);
    const HitFacet coat = roughFacetAt(material, {alpha, alpha, 0}, material.coatSlopes, place);
    bsdf.coatMicro = coat.micro;
    bsdf.coatTilted = point.tilted || coat.tilted;
    if (bsdf.coatTilted) bsdf.coatFrame = point.facet.toLocal(coat.tilted ? point.frame.fromLocal(coat.frame) : point.frame);
}

/// What scatters at the point, and the facet that it is on.
void setBsdf(const PreparedMaterial &prepared, const FacetPlace &place, SurfacePoint &point) {
    const Scene &scene = place.scene;
    const Material &material = *prepared.material;
    point.facet = point.frame;
    Bsdf &bsdf = point.bsdf = bsdfOf(prepared, valuesAt(prepared, scene, point.baseColor, point.uv), point.facing);
    const bool glossy = bsdfInfo(material.type).microsurface;
    if (!glossy && !material.slopes.isGiven()) return;
    const RestRoughness rest = glossy ? restRoughness(material, scene, point.uv) : RestRoughness{1, 1, 0};
    const HitFacet facet = roughFacetAt(material, rest, material.slopes, place);
    point.tilted = facet.tilted;
    if (facet.tilted) point.facet = point.frame.fromLocal(facet.frame);
    if (!glossy) return;
    bsdf.micro = facet.micro;
    if (bsdf.coat > 0) setCoat(material, place, bsdf);
    bsdf.multiscatter = treatmentAt(prepared, bsdf.metallic, bsdf.micro, facet.tilted);
}

/// KHR_materials_volume: of white light the attenuation colour is left after the attenuation distance (Beer's law).
Vec3 extinctionOf(const Material &material) {
    if (material.thinWalled || !(material.attenuationDistance < kInfinity)) return Vec3(0);
    constexpr float kDarkest = 1e-6F; // a black medium lets through what no picture shows
    return -glm::log(glm::clamp(material.attenuationColor, Vec3(kDarkest), Vec3(1))) / material.attenuationDistance;
}

} // namespace

HitDeformation deformationAt(const RenderObject &object, const HitCorners<false> &corners, const SurfaceGeometry &at) {
    HitDeformation d;
    d.tangent = at.tangent;
    const SurfaceStep &step = corners.step();
    if (!step.ds.empty()) {
        const Vec3 ds = corners.interpolate(&SurfaceStep::ds);
        const Vec3 dt = corners.interpolate(&SurfaceStep::dt);
        const PlanarPolar polar = polarInFrame({glm::dot(at.s, ds), glm::dot(at.t, ds)}, {glm::dot(at.s, dt), glm::dot(at.t, dt)});
        d.stretch = polar.stretch;
        d.tangent = polar.tangent;
    } else if (!step.stretch.empty()) {
        d.stretch = decodeStretch(corners.stretchIsConstant() ? GradientInterpolation::Stretch : object.plan.interpolation,
                                  corners.stretch(), at.s, at.t);
    }
    if (object.roughens) {
        const float lambda = step.inverseLambda.empty() ? 1.0F : 1 / corners.interpolate(&SurfaceStep::inverseLambda);
        const Vec3 v = d.stretch * lambda;
        const Vec2 sigma = singularValues(v.x, v.y, v.y, v.z);
        d.strain = static_cast<float>(equivalentStrain(static_cast<double>(sigma.x), static_cast<double>(sigma.y)));
    }
    if (step.lean.empty()) return d;
    const Vec3 lean = corners.interpolate(&SurfaceStep::lean) * at.facing;
    d.lean = {glm::dot(at.s, lean), glm::dot(at.t, lean)};
    return d;
}

std::vector<PreparedMaterial> prepareMaterials(const Scene &scene, const ScenePlan &plan) {
    std::vector<PreparedMaterial> prepared;
    for (Index i = 0; i < std::max<std::size_t>(scene.materials.size(), 1); ++i) {
        const Material &material = scene.materialAt(i);
        const MultiscatterPlan model = i < plan.materials.size() ? plan.materials[i] : MultiscatterPlan{};
        // Walks draw their facets themselves; a coat over them, and paint where a texture tells it from metal, do not.
        const bool walksAlone = multiscatterOf(material, model.model) == Multiscatter::Walk && material.clearcoat.value <= 0 &&
                                material.metallic.texture == kNone;
        const float waste = walksAlone ? 1 : plan.bearableWaste;
        prepared.push_back({&material, coatEscape(material.ior), model, waste, extinctionOf(material),
                            i < plan.details.size() && plan.details[i].detail == TextureDetail::Moments});
    }
    return prepared;
}

MaterialValues valuesOf(const PreparedMaterial &prepared, const Vec3 &color) {
    const Material &material = *prepared.material;
    MaterialValues values;
    values.color = color;
    values.ior = material.ior;
    values.metallic = material.metallic.value;
    values.coatEscape = prepared.coatEscape;
    values.conductorEta = material.conductorEta;
    values.conductorK = material.conductorK;
    return values;
}

MaterialValues valuesAt(const PreparedMaterial &prepared, const Scene &scene, const Vec3 &color, const UvPoint &uv) {
    MaterialValues values = valuesOf(prepared, color);
    const Material &m = *prepared.material;
    if (!bsdfInfo(m.type).reads(kMetallicKey)) return values;
    const auto share = [&](const auto &param) { return evaluateShare(param, scene, uv); };
    values.metallic = share(m.metallic);
    values.specular = share(m.specular);
    values.specularColor = evaluate(m.specularColor, scene, uv);
    values.transmission = share(m.transmission);
    values.thinWalled = m.thinWalled;
    values.clearcoat = share(m.clearcoat);
    values.sheenColor = share(m.sheenColor);
    if (values.sheenColor != Vec3(0)) values.sheenAlpha = sheen::alphaOf(share(m.sheenRoughness));
    values.film.share = share(m.iridescence);
    if (values.film.share > 0) {
        values.film.ior = m.iridescenceIor;
        values.film.thickness = glm::mix(m.iridescenceMin, m.iridescenceMax, share(m.thickness));
    }
    return values;
}

Bsdf bsdfOf(const PreparedMaterial &prepared, const MaterialValues &values, float facing) {
    const Material &material = *prepared.material;
    Bsdf bsdf;
    bsdf.type = material.type;
    bsdf.correlated = material.masking == Masking::Correlated;
    bsdf.bearableWaste = prepared.bearableWaste;
    onBsdf(material.type, [&](auto kind) { decltype(kind)::Class::make(values, bsdf); });
    const bool refracts = bsdfInfo(material.type).refracts || bsdf.refracts;
    bsdf.eta = facing < 0 && refracts ? 1 / material.ior : material.ior;
    // What bends nothing has no half vector; this little is not seen.
    constexpr float kLeastBend = 1e-3F;
    if (bsdf.refracts && std::fabs(bsdf.eta - 1) < kLeastBend) bsdf.eta = facing < 0 ? 1 - kLeastBend : 1 + kLeastBend;
    return bsdf;
}

MeshValues meshValuesAt(const RenderObject &object, const Hit &hit, const InterpolatedSurface &at, const Vec3 &wo, float coneWidth) {
    MeshValues mesh;
    const Surface &surface = object.surface;
    const Index3 t = surface.triangles[hit.primitive];
    const Vec3 b(1 - hit.u - hit.v, hit.u, hit.v);
    const auto interpolated = [&](const auto &values) { return values[t.x] * b.x + values[t.y] * b.y + values[t.z] * b.z; };
    if (!surface.uvs.empty()) mesh.uv = interpolated(surface.uvs);
    if (!surface.uvs1.empty()) mesh.uv.second = interpolated(surface.uvs1);
    if (!surface.colors.empty()) mesh.color = interpolated(surface.colors);
    if (!(coneWidth > 0)) return mesh;
    const bool mirrored = object.isMirrored(hit.primitive);
    const auto footprint = [&](const std::vector<Vec2> &uvs) {
        if (uvs.empty()) return UvFootprint{};
        return footprintOf(at, wo, coneWidth, {uvs[t.x], uvs[mirrored ? t.z : t.y], uvs[mirrored ? t.y : t.z]});
    };
    mesh.uv.footprint = footprint(surface.uvs);
    mesh.uv.secondFootprint = footprint(surface.uvs1);
    return mesh;
}

bool mayEmit(const RenderObject &object, Index triangle) {
    const Object &source = *object.object;
    if (source.slotEmission.empty() && source.emission.value == Vec3(0)) return false;
    return emissionOf(source, slotOfTriangle(object, triangle)).radiance.value != Vec3(0);
}

Vec3 emissionAt(const RenderObject &object, Index triangle, const Scene &scene, float facing, const UvPoint &uv) {
    const Emission emission = emissionOf(*object.object, slotOfTriangle(object, triangle));
    return facing > 0 || emission.twoSided ? evaluate(emission.radiance, scene, uv) : Vec3(0);
}

Multiscatter treatmentAt(const PreparedMaterial &prepared, float metallic, const MicroTransform &m, bool tilted) {
    // As multiscatterOf() has it for a whole material, where a texture says so.
    const bool isPaint = bsdfInfo(prepared.material->type).reads(kMetallicKey) && metallic == 0;
    if (isPaint && prepared.material->multiscatter == Multiscatter::Auto) return Multiscatter::Off;
    const Multiscatter model = multiscatterOf(*prepared.material, prepared.multiscatter.model);
    if (model != Multiscatter::Auto) return model;
    const bool transmits = !bsdfInfo(prepared.material->type).compensates();
    const float negligible = prepared.multiscatter.negligibleLoss;
    if (!tilted) return chooseMultiscatter(m, transmits, negligible);
    // A lean is no more than that much roughness: |M^-1 w| <= (1 + |lean|) / sigma.
    const float lean = 1 + std::sqrt(m.p * m.p + m.q * m.q);
    const MicroTransform bound = m.upright() ? m : canonicalTransform(m.a / lean, m.b / lean, m.d / lean);
    const Multiscatter upright = chooseMultiscatter(bound, transmits, negligible / kTiltedLoss);
    return upright == Multiscatter::Off || m.upright() ? upright : Multiscatter::Walk;
}

SurfacePoint surfacePointAt(const RenderScene &scene, const std::vector<PreparedMaterial> &materials, const Hit &hit, const Vec3 &wo,
                            float time, float coneWidth) {
    SurfacePoint point;
    const RenderObject &object = scene.objects()[scene.objectOfGeometry(hit.geometry)];
    const HitCorners<false> corners(object, hit, time);
    point.object = &object;
    point.corners = corners.corners();
    point.barycentrics = corners.barycentrics();
    const InterpolatedSurface at = corners.surface();
    const SurfaceGeometry geometry = surfaceGeometry(at, wo);
    point.position = at.position;
    point.geometricNormal = geometry.geometricNormal;
    point.clearance = geometry.clearance;
    point.facing = geometry.facing;
    point.frame = Frame(geometry.s, geometry.t, geometry.n);
    static_cast<HitDeformation &>(point) = deformationAt(object, corners, geometry);

    const PreparedMaterial &material = materials[materialOfTriangle(object, hit.primitive)];
    const MeshValues mesh = meshValuesAt(object, hit, at, wo, material.filters ? coneWidth : 0.0F);
    point.uv = mesh.uv;
    point.color = mesh.color;
    point.baseColor = baseColorAt(*material.material, scene.scene(), mesh);
    setBsdf(material, {scene.scene(), point, at, geometry.sense}, point);
    if (point.bsdf.refracts && point.facing > 0) point.extinction = material.extinction;
    point.scatters = !material.material->unlit;
    if (mayEmit(object, hit.primitive)) point.emission = emissionAt(object, hit.primitive, scene.scene(), point.facing, point.uv);
    return point;
}

} // namespace taut
