#pragma once
/// Albedo of single scattering on the transformed GGX microsurface (height-correlated, F = 1) by quasi Monte Carlo over visible normals:
/// the truth behind the fitted table.

#include "taut/base/sobol.h"
#include "taut/base/warp.h"
#include "taut/microsurface/ggx.h"

namespace taut::tables {

/// What the reflection at the visible normal of `u` contributes to the albedo: G2 / G1(wo) above the horizon.
inline float albedoSample(const MicroTransform &m, const Vec3 &wo, const Vec2 &u) {
    const Vec3 wm = ggx::sampleVisibleNormal(m, wo, u);
    const Vec3 wi = glm::normalize(2 * glm::dot(wo, wm) * wm - wo);
    if (!(wi.z > 0)) return 0;
    const float lambdaO = ggx::lambda(m, wo);
    return (1 + lambdaO) * ggx::shadowing(lambdaO, ggx::lambda(m, wi), true, true);
}

/// E(wo; M); error about 3e-4 with 4096 samples.
inline double albedo(const MicroTransform &m, const Vec3 &wo, std::uint32_t samples) {
    double sum = 0;
    for (std::uint32_t i = 0; i < samples; ++i) sum += static_cast<double>(albedoSample(m, wo, sobol2(i, 12345)));
    return sum / samples;
}

/// Its cosine-weighted mean over the hemisphere.
inline double averageAlbedo(const MicroTransform &m, std::uint32_t samples) {
    double sum = 0;
    for (std::uint32_t i = 0; i < samples; ++i) {
        const Vec3 wo = squareToCosineHemisphere(sobol2(i, 777));
        if (wo.z > 0) sum += static_cast<double>(albedoSample(m, wo, sobol2(i, 12345)));
    }
    return sum / samples;
}

} // namespace taut::tables
