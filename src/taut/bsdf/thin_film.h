#pragma once
/// Reflectance of a thin film over an opaque base, as KHR_materials_iridescence defines it: Belcour & Barla 2017, "A Practical Extension to
/// Microfacet Theory for the Modeling of Varying Iridescence", with two pairs of interference terms, Schlick's reflectance at both
/// interfaces and Gaussian fits of the eye's sensitivities, brought to linear Rec. 709.

#include "taut/base/vec.h"

#include <numbers>

namespace taut::thin_film {

/// Index of what reflects f0 at normal incidence in air.
inline float iorOf(float f0) {
    const float root = std::sqrt(glm::clamp(f0, 0.0F, 0.9999F));
    return (1 + root) / (1 - root);
}

/// Fourier transform of the sensitivities at an optical path difference in nanometres, normalised (Belcour & Barla, eq. 10 and supplement).
inline Vec3 sensitivity(float pathDifference, const Vec3 &shift) {
    const float phase = 2 * kPi * pathDifference * 1e-9F;
    const Vec3 value(5.4856e-13F, 4.4201e-13F, 5.2481e-13F);
    const Vec3 position(1.6810e6F, 1.7953e6F, 2.2084e6F);
    const Vec3 variance(4.3278e9F, 9.3046e9F, 6.6121e9F);
    Vec3 xyz;
    for (int c = 0; c < 3; ++c)
        xyz[c] =
            value[c] * std::sqrt(2 * kPi * variance[c]) * std::cos(position[c] * phase + shift[c]) * std::exp(-phase * phase * variance[c]);
    xyz.x += 9.7470e-14F * std::sqrt(2 * kPi * 4.5282e9F) * std::cos(2.2399e6F * phase + shift.x) * std::exp(-4.5282e9F * phase * phase);
    xyz *= 1 / 1.0685e-7F;
    return {3.2404542F * xyz.x - 1.5371385F * xyz.y - 0.4985314F * xyz.z, -0.9692660F * xyz.x + 1.8760108F * xyz.y + 0.0415560F * xyz.z,
            0.0556434F * xyz.x - 0.2040259F * xyz.y + 1.0572252F * xyz.z};
}

/// In air. `cosine` of incidence; `thickness` in nanometres; held to [0, 1], which colours outside of Rec. 709 may leave.
inline Vec3 reflectance(float cosine, float filmIor, float thickness, const Vec3 &baseF0) {
    const auto schlick = [](float f0, float c) { return f0 + (1 - f0) * sqr(sqr(1 - c)) * (1 - c); };
    const float cos1 = glm::clamp(cosine, 0.0F, 1.0F);
    // A film that becomes nothing becomes air.
    const float ior = glm::mix(1.0F, filmIor, glm::smoothstep(0.0F, 0.03F, thickness));
    const float cos2Squared = 1 - (1 - cos1 * cos1) / (ior * ior);
    if (cos2Squared < 0) return Vec3(1); // total internal reflection
    const float cos2 = std::sqrt(cos2Squared);

    const float r12 = schlick(sqr((ior - 1) / (ior + 1)), cos1);
    const float t121 = 1 - r12;
    const float phi21 = ior < 1 ? 0.0F : kPi;
    const float pathDifference = 2 * ior * thickness * cos2;
    Vec3 constant;
    Vec3 amplitude;
    Vec3 root;
    Vec3 phi;
    for (int c = 0; c < 3; ++c) {
        const float base = iorOf(baseF0[c]);
        const float r23 = schlick(sqr((base - ior) / (base + ior)), cos2);
        phi[c] = phi21 + (base < ior ? kPi : 0.0F);
        const float r123 = glm::clamp(r12 * r23, 1e-5F, 0.9999F);
        root[c] = std::sqrt(r123);
        const float series = t121 * t121 * r23 / (1 - r123);
        constant[c] = r12 + series;
        amplitude[c] = series - t121;
    }
    Vec3 sum = constant;
    for (int m = 1; m <= 2; ++m) {
        amplitude *= root;
        sum += amplitude * 2.0F * sensitivity(static_cast<float>(m) * pathDifference, static_cast<float>(m) * phi);
    }
    return glm::clamp(sum, Vec3(0), Vec3(1));
}

} // namespace taut::thin_film
