#pragma once
/// A BSDF seen from one direction, and the reflection lobe of the transformed GGX as one formula for whoever evaluates it: hit by hit, or
/// many at once (render/hit_lanes.h). Always inline, so that loops over many hits are vectorised.

#include "taut/bsdf/bsdf_types.h"
#include "taut/microsurface/reflection_sampler.h"

#include <optional>

namespace taut {

/// What the lobes of one (M, wo) need beside them.
struct LobeView {
    float length = 1;   ///< L(wo)
    float area = 1;     ///< ggx::visibleArea
    float pdfScale = 0; ///< density of the sampling of reflections over D
    bool correlated = true;
    float eta = 1.5F; ///< Bsdf
};

/// A Bsdf and a wo: what evaluation and sampling share, computed once a hit (ScatteringPoint).
struct BsdfView {
    const Bsdf &bsdf;
    Vec3 wo;
    LobeView lobe;
    std::optional<ReflectionSampler> reflections; ///< of what has a microsurface and does not refract
    float split = 1;                              ///< layers: of samples, those of the upper one
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

} // namespace taut
