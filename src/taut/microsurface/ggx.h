#pragma once
/// The transformed GGX microsurface: distribution, masking, visible normals and their densities, in the forms that stay
/// accurate in float (docs/precision.md). All directions are in local shading space, unit unless said; wo points to
/// the viewer, wi to the light. BRDF values exclude the cosine. The transform is `m`, micro-normals are `wm`.
///
/// Every function takes any real type; rendering is in float. They say `inline` because batch.h's loops need them to be. Named forms to
/// compare with: reference.h. Samplers: normal_samplers.h.

#include "taut/base/warp.h"
#include "taut/microsurface/transform.h"

#include <algorithm>
#include <numbers>
#include <optional>

namespace taut::ggx {

/// L(w) = |M^-1 w|, the length of a unit direction in standard space.
template <class T> inline T stretchedLength(const BasicMicroTransform<T> &m, const Vector3<T> &w) {
    return glm::length(m.inverse(w));
}

namespace detail {
/// D of the normal h/|h|, with the one sum that cancels under shear, b h.x + d h.y, in numbers that hold its products exactly; x and y are
/// h.x and h.y before they were rounded.
template <class T> inline T distribution(const BasicMicroTransform<T> &m, const Vector3<T> &h, Wider<T> x, Wider<T> y) {
    const Vector3<T> s{m.a * h.x, T(m.b * x + m.d * y), m.p * h.x + m.q * h.y + h.z};
    if (!(s.z > 0)) return 0;
    // Scaling by the ratio of lengths keeps the fourth powers inside float's range.
    const T ratio = glm::dot(h, h) / glm::dot(s, s);
    return m.det * std::numbers::inv_pi_v<T> * ratio * ratio;
}
} // namespace detail

/// D(h/|h|) from a normal of any length: det |h|^4 / (pi |M^T h|^4); zero where the normal faces down in standard space.
/// Keeping h unnormalised is what keeps float accurate at small alpha.
template <class T> inline T distribution(const BasicMicroTransform<T> &m, const Vector3<T> &h) {
    return detail::distribution<T>(m, h, h.x, h.y);
}
/// D at the half vector of wo and wi, of a sum that is not rounded before M^T: right to a few roundings for every M, where a rounded
/// h is wrong by 4 % at a shear of 1000 and a stretch of 1e-3.
template <class T> inline T distribution(const BasicMicroTransform<T> &m, const Vector3<T> &wo, const Vector3<T> &wi) {
    using W = Wider<T>;
    return detail::distribution<T>(m, wo + wi, W(wo.x) + wi.x, W(wo.y) + wi.y);
}

/// wo.z + L(wo) without cancellation for back-facing wo (|M^-1 wo|_xy^2 / (L - wo.z)); `length` = L(wo).
template <class T> inline T visibleArea(const BasicMicroTransform<T> &m, const Vector3<T> &wo, T length) {
    if (wo.z >= 0) return wo.z + length;
    const Vector3<T> std = m.inverse(wo);
    return (std.x * std.x + std.y * std.y) / (length - wo.z);
}

/// The area that micro-normals of a cap cut at k (capBound) show to the view: all that is visible where k = 1.
template <class T> inline T capArea(T k, T woZ, T length, T area) {
    return k < 1 ? k * woZ + length : area;
}

/// Smith masking G1(w) = 2 |w.z| / (w.z + L(w)); for w.z < 0 the normalisation of Tokuyoshi 2021.
template <class T> inline T masking(const BasicMicroTransform<T> &m, const Vector3<T> &w) {
    return 2 * std::fabs(w.z) / visibleArea(m, w, stretchedLength(m, w));
}

/// Density of visible normals (solid angle): 2 <wo, wm> D(wm) / (wo.z + L(wo)). `h` may have any length.
template <class T> inline T visibleNormalPdf(const BasicMicroTransform<T> &m, const Vector3<T> &wo, const Vector3<T> &h) {
    const T cosine = glm::dot(wo, h) / glm::length(h);
    return cosine > 0 ? 2 * cosine * distribution(m, h) / visibleArea(m, wo, stretchedLength(m, wo)) : T(0);
}

/// How far down the spherical cap of visible normals has to reach so that no reflection above the horizon is lost
/// (Eto & Tokuyoshi 2023): the factor k of woStd.z; 1 where their bound does not apply.
template <class T> inline T capBound(const BasicMicroTransform<T> &m, const Vector3<T> &wo) {
    if (wo.z <= 0 || !m.upright()) return 1;
    // k = (1 - a^2) s^2 / (s^2 + a^2 wo.z^2), a^2 = min(1, determinant / larger), without dividing for a^2.
    const auto sigma = slopeTensor(m);
    const T larger = sigma.larger();
    const T rest = larger - sigma.determinant;
    const T s = 1 + std::sqrt(wo.x * wo.x + wo.y * wo.y);
    const T s2 = s * s;
    return rest > 0 ? rest * s2 / (larger * s2 + sigma.determinant * wo.z * wo.z) : T(0);
}

/// A visible normal in standard space, not normalised: the sum of the standard view and a point on its spherical cap
/// z in (-k woStd.z, 1], uniform (Dupuy & Benyoub 2023; k < 1: Eto & Tokuyoshi 2023).
template <class T>
inline Vector3<T> sampleCap(const BasicMicroTransform<T> &m, const Vector3<T> &wo, const Vector2<T> &u, std::type_identity_t<T> k) {
    const Vector3<T> o = glm::normalize(m.inverse(wo)); // woStd
    // Height of the cap; from below 1 + o.z without cancellation, or a smooth surface would leave nothing of it.
    const bool below = o.z < 0;
    const T height = below ? (o.x * o.x + o.y * o.y) / (1 - o.z) : 1 + k * o.z;
    const T depth = u.y * height;
    const T r = std::sqrt(std::max(T(0), depth * (2 - depth)));
    const Vector2<T> side = r * unitCircle(u.x);
    return {side.x + o.x, side.y + o.y, below ? height - depth : (1 - depth) + o.z};
}

/// A visible normal (unit, local space) from such a cap. Density with k = 1: visibleNormalPdf.
template <class T>
inline Vector3<T> sampleVisibleNormal(const BasicMicroTransform<T> &m, const Vector3<T> &wo, const Vector2<T> &u,
                                      std::type_identity_t<T> k = 1) {
    return glm::normalize(m.inverseTransposed(sampleCap(m, wo, u, k)));
}

/// A visible normal in standard space as sampleCap() with k = 1, from the visible half of the unit disk across the view (Heitz 2018, JCGT
/// 7(4)), cut into chords in the plane of incidence: where polar coordinates wrap around, these keep near to each other what is near in u.
/// u.y is constant where the slope along the view is, as with the slopes that Heitz & d'Eon 2014 sample. (Without the attribute GCC 12
/// leaves it out of line, and loops over it scalar.)
template <class T>
[[gnu::always_inline]] inline Vector3<T> sampleChord(const BasicMicroTransform<T> &m, const Vector3<T> &wo, const Vector2<T> &u) {
    const Vector3<T> o = glm::normalize(m.inverse(wo)); // woStd
    const T xy2 = o.x * o.x + o.y * o.y;
    const bool slanted = xy2 > 0;
    const T inverse = 1 / std::sqrt(slanted ? xy2 : T(1));
    const T alongX = slanted ? o.x * inverse : T(1);
    const T alongY = o.y * inverse;
    const T high = T(1) + o.z;
    const T low = xy2 / (T(1) - std::min(o.z, T(0)));
    const T share = T(0.5) * (o.z < 0 ? low : high);
    const auto [x, half] = diskQuantile(u.x);
    // The height over the disk by the gap to its border, which a view from below makes small.
    const T gap = share * half * (2 - 2 * u.y);
    const T y = half - gap;
    const T height = std::sqrt(std::max(T(0), gap * (2 * half - gap)));
    // Axes: across the view (-alongY, alongX, 0), o x that, o.
    const T up = height * o.z + y * (xy2 * inverse);
    const T forth = height * (xy2 * inverse) - y * o.z;
    return {forth * alongX - x * alongY, forth * alongY + x * alongX, up};
}

/// Whether stratified samples are better spread by chords than by a cap: seen from above, where micro-normals lean more than four times
/// as far along one direction as across it, as on brushed metal (docs/reflection_sampling.md).
template <class T> inline bool prefersChords(const BasicMicroTransform<T> &m, const Vector3<T> &wo) {
    const auto sigma = slopeTensor(m);
    const T larger = sigma.larger();
    return (wo.z > 0) & (larger * larger > 16 * sigma.determinant);
}

/// capBound() for spreadVisibleNormal(): the whole cap where chords stand in for it. The bound is from the smaller alpha and leaves out
/// next to nothing there.
template <class T> inline T reflectionBound(const BasicMicroTransform<T> &m, const Vector3<T> &wo) {
    return prefersChords(m, wo) ? T(1) : capBound(m, wo);
}

/// A visible normal as sampleVisibleNormal(), by chords where prefersChords(); k from reflectionBound(), or 1.
template <class T>
inline Vector3<T> spreadVisibleNormal(const BasicMicroTransform<T> &m, const Vector3<T> &wo, const Vector2<T> &u,
                                      std::type_identity_t<T> k = 1) {
    return prefersChords(m, wo) ? glm::normalize(m.inverseTransposed(sampleChord(m, wo, u))) : sampleVisibleNormal(m, wo, u, k);
}
/// spreadVisibleNormal() without a branch, for loops over many: both a cap and a chord are made.
template <class T>
[[gnu::always_inline]] inline Vector3<T> spreadVisibleNormalBranchless(const BasicMicroTransform<T> &m, const Vector3<T> &wo,
                                                                       const Vector2<T> &u, std::type_identity_t<T> k = 1) {
    const Vector3<T> cap = sampleCap(m, wo, u, k);
    const Vector3<T> chord = sampleChord(m, wo, u);
    const bool chords = prefersChords(m, wo);
    return glm::normalize(m.inverseTransposed(Vector3<T>(chords ? chord.x : cap.x, chords ? chord.y : cap.y, chords ? chord.z : cap.z)));
}

/// A reflected direction and its density, which is 0 where it is below the horizon and the sample rejected.
template <class T> struct ReflectionSample {
    Vector3<T> wi;
    T pdf;
};
/// The reflection of such a normal with the bound above: density D / (2 (k wo.z + L(wo))), or D / (2 (wo.z + L(wo))) for k = 1.
template <class T> inline ReflectionSample<T> sampleReflection(const BasicMicroTransform<T> &m, const Vector3<T> &wo, const Vector2<T> &u) {
    const T k = capBound(m, wo);
    const Vector3<T> hStd = sampleCap(m, wo, u, k);
    const Vector3<T> h = m.inverseTransposed(hStd);
    const T hh = glm::dot(h, h);
    const Vector3<T> wi = (2 * glm::dot(wo, h) / hh) * h - wo;
    const T length = stretchedLength(m, wo);
    const T base = capArea(k, wo.z, length, visibleArea(m, wo, length));
    const T ratio = hh / glm::dot(hStd, hStd); // M^T h = hStd: D needs no more
    const T pdf = m.det * (std::numbers::inv_pi_v<T> / 2) * ratio * ratio / base;
    return {wi, wi.z > 0 ? pdf : T(0)};
}

/// G2 / (4 wo.z wi.z), the part of the BRDF that stays finite at grazing, for wo.z > 0 and wi.z > 0:
/// correlated 1 / (2 (wo.z L(wi) + wi.z L(wo))), separable 1 / ((wo.z + L(wo)) (wi.z + L(wi))).
template <class T> inline T visibility(T woZ, T lengthO, T wiZ, T lengthI, bool correlated) {
    return correlated ? 1 / (2 * (woZ * lengthI + wiZ * lengthO)) : 1 / ((woZ + lengthO) * (wiZ + lengthI));
}

/// Weight f cos / pdf of visible-normal reflection at F = 1, G2 / G1(wo), for wi.z > 0; for wo below the horizon G1(wi)
/// (Tokuyoshi 2021).
template <class T> inline T reflectionWeight(const BasicMicroTransform<T> &m, const Vector3<T> &wo, const Vector3<T> &wi, bool correlated) {
    const T lengthI = stretchedLength(m, wi);
    if (!correlated || !(wo.z > 0)) return 2 * wi.z / (wi.z + lengthI);
    const T lengthO = stretchedLength(m, wo);
    return wi.z * (wo.z + lengthO) / (wo.z * lengthI + wi.z * lengthO);
}

/// G2 for directions on opposite or equal sides of the surface, |w.z| used. Separable G1 G1; correlated: same side
/// 1 / (1 + Lo + Li), opposite sides Beta(1 + Lo, 1 + Li) (Heitz et al. 2016).
template <class T> inline T shadowing(T lambdaO, T lambdaI, bool sameSide, bool correlated) {
    if (!correlated) return 1 / ((1 + lambdaO) * (1 + lambdaI));
    if (sameSide) return 1 / (1 + lambdaO + lambdaI);
    return std::exp(std::lgamma(1 + lambdaO) + std::lgamma(1 + lambdaI) - std::lgamma(2 + lambdaO + lambdaI));
}

/// Lambda(w) = (L(w)/|w.z| - 1) / 2.
template <class T> inline T lambda(const BasicMicroTransform<T> &m, const Vector3<T> &w) {
    const T z = std::fabs(w.z);
    const Vector3<T> s = m.inverse(w);
    // L - z without cancellation: xy^2 / (L + z).
    const T xy2 = s.x * s.x + s.y * s.y;
    return xy2 / (2 * z * (std::sqrt(xy2 + z * z) + z));
}

} // namespace taut::ggx
