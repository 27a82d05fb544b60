#pragma once
/// A BSDF seen from one direction, and the reflection lobe of the transformed GGX as one formula for whoever evaluates it: hit by hit, or
/// many at once (render/hit_lanes.h). Always inline, so that loops over many hits are vectorised.

#include "taut/bsdf/bsdf_types.h"
#include "taut/microsurface/facet.h"
#include "taut/microsurface/reflection_sampler.h"

#include <optional>

namespace taut {

/// A kind with several lobes, seen from one direction: shares of samples, and of light.
struct LobeShares {
    float facets = 1;  ///< of samples: reflection by the facets of the base
    float diffuse = 0; ///< and those sent to all directions alike
    float through = 0; ///< and to the other side
    float coat = 0;    ///< and reflected by a coat
    float kept = 1;    ///< of the diffuse part, so that no light is made
    float under = 1;   ///< of light that layers above leave to those below
};

/// What the lobes of one (M, wo) need beside them.
struct LobeView {
    float length = 1;   ///< L(wo)
    float area = 1;     ///< ggx::visibleArea
    float pdfScale = 0; ///< density of the sampling of reflections over D
    bool correlated = true;
    float eta = 1.5F; ///< Bsdf
    LobeShares shares{};
};

/// Layers on top, seen from one direction (metallic_roughness.h).
struct LayerView {
    float coatShare = 0;  ///< of light that the coat reflects
    float sheenScale = 1; ///< keeps the fibres' albedo at 1
    LobeView coatLobe;
    std::optional<ReflectionSampler> coatReflections;
};

/// A Bsdf and a wo: what evaluation and sampling share, computed once a hit (ScatteringPoint).
struct BsdfView {
    const Bsdf &bsdf;
    Vec3 wo;
    LobeView lobe;
    std::optional<ReflectionSampler> reflections; ///< of what has a microsurface and does not refract
    LayerView layers{};
};

/// F D visibility cos, and the density of its sampling, for wi.z > 0. `reflectance` of the cosine between wo and the half vector.
template <class Reflectance>
[[gnu::always_inline]] inline BsdfEval reflectionLobe(const MicroTransform &m, const LobeView &view, const Vec3 &wo, const Vec3 &wi,
                                                      const Reflectance &reflectance) {
    const Vec3 h = wo + wi;
    const float density = ggx::distribution(m, wo, wi);
    const float cosine = glm::dot(wo, h) / std::sqrt(glm::dot(h, h));
    const float lengthI = ggx::stretchedLength(m, wi);
    // For a back-facing wo the weight is F G1(wi), Tokuyoshi 2021.
    const float front = ggx::visibility(wo.z, view.length, wi.z, lengthI, view.correlated);
    const float shape = wo.z > 0 ? front : 1 / (view.area * (wi.z + lengthI));
    return {Vec3(density * shape * wi.z) * reflectance(cosine), density * view.pdfScale};
}

/// What an interface between media lets pass (Walter et al. 2007, eq. 21), as radiance: without the factor eta^2; and the density of
/// sampling a visible normal to refract at, times the transmittance. `transmittance` of the cosine between wo and the facet's normal.
/// fCos means nothing where the density is 0.
template <class Transmittance>
[[gnu::always_inline]] inline BsdfEval refractionLobe(const MicroTransform &m, const LobeView &view, const Vec3 &wo, const Vec3 &wi,
                                                      const Transmittance &transmittance) {
    const Vec3 h = facet::refractionHalf(wo, wi, view.eta);
    const float inverse = 1 / std::sqrt(glm::dot(h, h));
    const float cosO = glm::dot(wo, h) * inverse;
    const float jacobian = facet::refractionJacobian(cosO, glm::dot(wi, h) * inverse, view.eta);
    const float transmitted = transmittance(cosO);
    const float visible = 2 * cosO * ggx::distribution(m, h) / view.area; // D_vis
    // G2 / G1(wo): what is left of the light on its way out.
    const float lambdaI = ggx::lambda(m, wi);
    const float lambdaO = ggx::lambda(m, wo);
    const float both = ggx::shadowing(lambdaO, lambdaI, false, view.correlated) * (1 + lambdaO);
    const float leaving = wo.z > 0 ? both : 1 / (1 + lambdaI);
    const float pdf = transmitted * visible * jacobian;
    return {Vec3(pdf * leaving / (view.eta * view.eta)), jacobian > 0 ? pdf : 0.0F};
}

} // namespace taut
