#pragma once
/// The transformed GGX microsurface: distribution, masking, visible normals and their densities, in the forms that stay
/// accurate in float (docs/design.md, section 1). All directions are in local shading space, unit unless said; wo points to
/// the viewer, wi to the light. BRDF values exclude the cosine. The transform is `m`, micro-normals are `wm`.

#include "taut/microsurface/transform.h"

#include <optional>

namespace taut::ggx {

/// L(w) = |M^-1 w|, the length of a unit direction in standard space.
inline float stretchedLength(const MicroTransform &m, const Vec3 &w) {
    return glm::length(m.inverse(w));
}

/// D(h/|h|) from an unnormalised half vector: det |h|^4 / (pi |M^T h|^4); zero where the normal faces down in standard space.
/// Keeping h unnormalised is what keeps float accurate at small alpha.
inline float distribution(const MicroTransform &m, const Vec3 &h) {
    const Vec3 s = m.transposed(h);
    if (!(s.z > 0)) return 0;
    // Scaling by the ratio of lengths keeps the fourth powers inside float's range.
    const float ratio = glm::dot(h, h) / glm::dot(s, s);
    return m.det * kInvPi * ratio * ratio;
}

/// wo.z + L(wo) without cancellation for back-facing wo (|M^-1 wo|_xy^2 / (L - wo.z)); `length` = L(wo).
inline float visibleArea(const MicroTransform &m, const Vec3 &wo, float length) {
    if (wo.z >= 0) return wo.z + length;
    const Vec3 std = m.inverse(wo);
    return (std.x * std.x + std.y * std.y) / (length - wo.z);
}

/// Smith masking G1(w) = 2 |w.z| / (w.z + L(w)); for w.z < 0 the normalisation of Tokuyoshi 2021.
inline float masking(const MicroTransform &m, const Vec3 &w) {
    return 2 * std::fabs(w.z) / visibleArea(m, w, stretchedLength(m, w));
}

/// Density of visible normals (solid angle): 2 <wo, wm> D(wm) / (wo.z + L(wo)). `h` may have any length.
inline float visibleNormalPdf(const MicroTransform &m, const Vec3 &wo, const Vec3 &h) {
    const float cosine = glm::dot(wo, h) / glm::length(h);
    return cosine > 0 ? 2 * cosine * distribution(m, h) / visibleArea(m, wo, stretchedLength(m, wo)) : 0.0F;
}

/// How far down the spherical cap of visible normals has to reach so that no reflection above the horizon is lost
/// (Eto & Tokuyoshi 2023): the factor k of woStd.z; 1 where their bound does not apply.
inline float capBound(const MicroTransform &m, const Vec3 &wo) {
    if (wo.z <= 0 || !m.upright()) return 1;
    const float a = std::fmin(1.0F, 1 / singularValues(m.a, m.b, 0, m.d).x);
    const float s = 1 + std::sqrt(std::fmax(0.0F, 1 - wo.z * wo.z));
    const float a2 = a * a;
    const float s2 = s * s;
    return (1 - a2) * s2 / (s2 + a2 * wo.z * wo.z);
}

/// A visible normal (unit, local space): uniform on the spherical cap z in (-k woStd.z, 1] around the standard direction
/// (Dupuy & Benyoub 2023; k < 1: Eto & Tokuyoshi 2023). Density with k = 1: visibleNormalPdf.
inline Vec3 sampleVisibleNormal(const MicroTransform &m, const Vec3 &wo, const Vec2 &u, float k = 1) {
    const Vec3 woStd = glm::normalize(m.inverse(wo));
    const float z = (1 - u.y) - u.y * k * woStd.z;
    const float r = std::sqrt(glm::clamp(1 - z * z, 0.0F, 1.0F));
    const float phi = 2 * kPi * u.x;
    const Vec3 hStd = Vec3(r * std::cos(phi), r * std::sin(phi), z) + woStd;
    return glm::normalize(m.inverseTransposed(hStd));
}

/// G2 / (4 wo.z wi.z), the part of the BRDF that stays finite at grazing, for wo.z > 0 and wi.z > 0:
/// correlated 1 / (2 (wo.z L(wi) + wi.z L(wo))), separable 1 / ((wo.z + L(wo)) (wi.z + L(wi))).
inline float visibility(float woZ, float lengthO, float wiZ, float lengthI, bool correlated) {
    return correlated ? 1 / (2 * (woZ * lengthI + wiZ * lengthO)) : 1 / ((woZ + lengthO) * (wiZ + lengthI));
}

/// G2 for directions on opposite or equal sides of the surface, |w.z| used. Separable G1 G1; correlated: same side
/// 1 / (1 + Lo + Li), opposite sides Beta(1 + Lo, 1 + Li) (Heitz et al. 2016).
inline float shadowing(float lambdaO, float lambdaI, bool sameSide, bool correlated) {
    if (!correlated) return 1 / ((1 + lambdaO) * (1 + lambdaI));
    if (sameSide) return 1 / (1 + lambdaO + lambdaI);
    return std::exp(std::lgamma(1 + lambdaO) + std::lgamma(1 + lambdaI) - std::lgamma(2 + lambdaO + lambdaI));
}

/// Lambda(w) = (L(w)/|w.z| - 1) / 2.
inline float lambda(const MicroTransform &m, const Vec3 &w) {
    const float z = std::fabs(w.z);
    const Vec3 s = m.inverse(w);
    // L - z without cancellation: xy^2 / (L + z).
    const float xy2 = s.x * s.x + s.y * s.y;
    return 0.5F * xy2 / (z * (std::sqrt(xy2 + z * z) + z));
}

} // namespace taut::ggx
