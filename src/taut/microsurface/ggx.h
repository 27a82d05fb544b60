#pragma once
/// The transformed GGX microsurface: distribution, masking, visible normals and their densities, in the forms that stay
/// accurate in float (docs/design.md, section 1). All directions are in local shading space, unit unless said; wo points to
/// the viewer, wi to the light. BRDF values exclude the cosine. The transform is `m`, micro-normals are `wm`.

#include "taut/base/warp.h"
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
    // k = (1 - a^2) s^2 / (s^2 + a^2 wo.z^2), a^2 = min(1, determinant / larger), without dividing for a^2.
    const SlopeTensor sigma = slopeTensor(m);
    const float larger = sigma.larger();
    const float rest = larger - sigma.determinant;
    const float s = 1 + std::sqrt(wo.x * wo.x + wo.y * wo.y);
    const float s2 = s * s;
    return rest > 0 ? rest * s2 / (larger * s2 + sigma.determinant * wo.z * wo.z) : 0.0F;
}

/// A visible normal in standard space, not normalised: the sum of the standard view and a point on its spherical cap
/// z in (-k woStd.z, 1], uniform (Dupuy & Benyoub 2023; k < 1: Eto & Tokuyoshi 2023).
inline Vec3 sampleCap(const MicroTransform &m, const Vec3 &wo, const Vec2 &u, float k) {
    const Vec3 woStd = glm::normalize(m.inverse(wo));
    const float z = (1 - u.y) - u.y * k * woStd.z;
    const float r = std::sqrt(glm::clamp(1 - z * z, 0.0F, 1.0F));
    return Vec3(r * unitCircle(u.x), z) + woStd;
}

/// A visible normal (unit, local space) from such a cap. Density with k = 1: visibleNormalPdf.
inline Vec3 sampleVisibleNormal(const MicroTransform &m, const Vec3 &wo, const Vec2 &u, float k = 1) {
    return glm::normalize(m.inverseTransposed(sampleCap(m, wo, u, k)));
}

/// A reflected direction and its density, which is 0 where it is below the horizon and the sample rejected.
struct Reflected {
    Vec3 wi;
    float pdf;
};
/// The reflection of such a normal with the bound above: density D / (2 (k wo.z + L(wo))), or D / (2 (wo.z + L(wo))) for k = 1.
inline Reflected sampleReflection(const MicroTransform &m, const Vec3 &wo, const Vec2 &u) {
    const float k = capBound(m, wo);
    const Vec3 hStd = sampleCap(m, wo, u, k);
    const Vec3 h = m.inverseTransposed(hStd);
    const float hh = glm::dot(h, h);
    const Vec3 wi = (2 * glm::dot(wo, h) / hh) * h - wo;
    const float length = stretchedLength(m, wo);
    const float base = k < 1 ? k * wo.z + length : visibleArea(m, wo, length);
    const float ratio = hh / glm::dot(hStd, hStd); // M^T h = hStd: D needs no more
    const float pdf = m.det * (0.5F * kInvPi) * ratio * ratio / base;
    return {wi, wi.z > 0 ? pdf : 0.0F};
}

/// G2 / (4 wo.z wi.z), the part of the BRDF that stays finite at grazing, for wo.z > 0 and wi.z > 0:
/// correlated 1 / (2 (wo.z L(wi) + wi.z L(wo))), separable 1 / ((wo.z + L(wo)) (wi.z + L(wi))).
inline float visibility(float woZ, float lengthO, float wiZ, float lengthI, bool correlated) {
    return correlated ? 1 / (2 * (woZ * lengthI + wiZ * lengthO)) : 1 / ((woZ + lengthO) * (wiZ + lengthI));
}

/// Weight f cos / pdf of visible-normal reflection at F = 1, G2 / G1(wo), for wi.z > 0; for wo below the horizon G1(wi)
/// (Tokuyoshi 2021).
inline float reflectionWeight(const MicroTransform &m, const Vec3 &wo, const Vec3 &wi, bool correlated) {
    const float lengthI = stretchedLength(m, wi);
    if (!correlated || !(wo.z > 0)) return 2 * wi.z / (wi.z + lengthI);
    const float lengthO = stretchedLength(m, wo);
    return wi.z * (wo.z + lengthO) / (wo.z * lengthI + wi.z * lengthO);
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
