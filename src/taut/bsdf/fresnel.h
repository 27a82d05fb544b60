#pragma once
/// Fresnel reflectance, unpolarised. Cosines are measured from the micro-normal, on the side of the viewer.

#include "taut/microsurface/facet.h"

namespace taut::fresnel {

/// Dielectric interface; eta = index beyond / index on the viewer's side. 1 at total internal reflection.
[[gnu::always_inline]] inline float dielectric(float cosine, float eta) {
    const float c = glm::clamp(cosine, 0.0F, 1.0F);
    const float g2 = eta * eta - 1 + c * c;
    const float g = std::sqrt(std::fabs(g2)); // no branch: loops are vectorised
    // Walter et al. 2007, eq. 22.
    const float a = (g - c) / (g + c);
    const float b = (c * (g + c) - 1) / (c * (g - c) + 1);
    const float reflected = 0.5F * a * a * (1 + b * b);
    return g2 > 0 ? reflected : 1.0F;
}

/// An interface whose index is this close to 1 bends light by less than a tenth of a pixel, reflects under 3e-9 of it, and its half
/// vectors are rounding alone: light passes as if nothing were there.
inline constexpr float kMatchedIndex = 1e-4F;
inline bool isMatched(float eta) {
    return std::fabs(eta - 1) < kMatchedIndex;
}

/// (1 - cosine)^5: how far Schlick's reflectance has gone from normal incidence to grazing.
inline float schlickShare(float cosine) {
    const float m = 1 - glm::clamp(cosine, 0.0F, 1.0F);
    const float m2 = m * m;
    return m2 * m2 * m;
}
/// Schlick 1994 with reflectance f0 at normal incidence and f90 at grazing.
inline Vec3 schlick(float cosine, const Vec3 &f0, float f90 = 1) {
    return f0 + (Vec3(f90) - f0) * schlickShare(cosine);
}

/// Conductor of complex index eta + i k (relative to the outside), exact.
[[gnu::always_inline]] inline float conductor(float cosine, float eta, float k) {
    const float c = glm::clamp(cosine, 0.0F, 1.0F);
    const float c2 = c * c;
    const float s2 = 1 - c2;
    const float t0 = eta * eta - k * k - s2;
    const float a2b2 = std::sqrt(t0 * t0 + 4 * eta * eta * k * k);
    const float a = std::sqrt(std::fabs(0.5F * (a2b2 + t0))); // negative by rounding only; no branch: loops are vectorised
    const float rs = (a2b2 + c2 - 2 * a * c) / (a2b2 + c2 + 2 * a * c);
    const float rp = rs * (c2 * a2b2 + s2 * s2 - 2 * a * c * s2) / (c2 * a2b2 + s2 * s2 + 2 * a * c * s2);
    return 0.5F * (rs + rp);
}
[[gnu::always_inline]] inline Vec3 conductor(float cosine, const Vec3 &eta, const Vec3 &k) {
    return {conductor(cosine, eta.x, k.x), conductor(cosine, eta.y, k.y), conductor(cosine, eta.z, k.z)};
}

/// Hemispherical reflectance of a smooth dielectric for diffuse light arriving from outside: 2 * integral of F(c) c dc.
/// Midpoint rule with 256 nodes, called once a material.
inline float diffuseReflectance(float eta) {
    double sum = 0;
    constexpr int kNodes = 256;
    for (int i = 0; i < kNodes; ++i) {
        const double c = (i + 0.5) / kNodes;
        sum += 2 * c * static_cast<double>(dielectric(static_cast<float>(c), eta));
    }
    return static_cast<float>(sum / kNodes);
}

/// Mean of a reflectance over diffuse light, 2 * integral of F(c) c dc: Gauss-Legendre in c^2 with four nodes (error under 2e-3 for
/// metals).
template <class Reflectance> Vec3 diffuseMean(const Reflectance &reflectance) {
    constexpr float kNodes[4] = {0.06943184F, 0.33000948F, 0.66999052F, 0.93056816F};
    constexpr float kWeights[4] = {0.17392742F, 0.32607258F, 0.32607258F, 0.17392742F};
    Vec3 sum(0);
    for (int i = 0; i < 4; ++i) sum += kWeights[i] * reflectance(std::sqrt(kNodes[i]));
    return sum;
}

using facet::refract;

} // namespace taut::fresnel
