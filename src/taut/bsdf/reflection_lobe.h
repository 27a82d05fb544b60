#pragma once
/// The single-scattering lobes of the transformed GGX, each as one formula for whoever evaluates it: hit by hit (bsdf.h) or many at once
/// (render/hit_lanes.h). Always inline, so that loops over many hits are vectorised.

#include "taut/bsdf/bsdf_types.h"
#include "taut/microsurface/ggx.h"

namespace taut {

/// What the lobe of one (M, wo) needs beside them.
struct LobeView {
    float length = 1;   ///< L(wo)
    float area = 1;     ///< ggx::visibleArea
    float pdfScale = 0; ///< density of its sampling over D
    bool correlated = true;
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

/// Refraction (Walter et al. 2007, eq. 21, as radiance: without the factor eta^2) for wi.z < 0, and the density of Fresnel's choice of a
/// visible normal. fCos means nothing where the density is 0.
[[gnu::always_inline]] inline BsdfEval refractionLobe(const MicroTransform &m, const LobeView &view, const Vec3 &wo, const Vec3 &wi,
                                                      float eta, const Vec3 &tint) {
    const Vec3 h = facet::refractionHalf(wo, wi, eta);
    const float inverse = 1 / std::sqrt(glm::dot(h, h));
    const float cosO = glm::dot(wo, h) * inverse;
    const float jacobian = facet::refractionJacobian(cosO, glm::dot(wi, h) * inverse, eta);
    const float transmitted = 1 - fresnel::dielectric(cosO, eta);
    const float visible = 2 * cosO * ggx::distribution(m, h) / view.area; // D_vis
    // G2 / G1(wo): what is left of the light on its way out.
    const float lambdaI = ggx::lambda(m, wi);
    const float lambdaO = ggx::lambda(m, wo);
    const float both = ggx::shadowing(lambdaO, lambdaI, false, view.correlated) * (1 + lambdaO);
    const float leaving = wo.z > 0 ? both : 1 / (1 + lambdaI);
    const float pdf = transmitted * visible * jacobian;
    const Vec3 fCos = tint * (pdf * leaving / (eta * eta));
    return {Vec3(fCos.x, fCos.y, fCos.z), jacobian > 0 ? pdf : 0.0F};
}

} // namespace taut
