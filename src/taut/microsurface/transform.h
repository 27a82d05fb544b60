#pragma once
/// The microsurface transform M: every microsurface here is the standard one (GGX, alpha = 1) under a linear map
///
///         | a  b  p |
///     M = | 0  d  q |        micro-geometry -> M geometry,  micro-normals -> M^-T normals
///         | 0  0  1 |
///
/// in local shading space (orthonormal, z = macro-normal). The distribution depends on M only through M M^T, so the 2x2 block
/// is kept upper triangular with a, d > 0: three floats for an upright microsurface, five for a leaning one.
/// "Microsurface Transformations", Computer Graphics Forum 41(4), 2022.
///
/// Rendering uses float (`MicroTransform`); the same code in double and long double is what it is measured against. M is brought
/// to its canonical form in double, so that the float one is right to a rounding for any block of floats, however sheared.
/// A general invertible 3x3 matrix: general_transform.h. Storage in halves: packed_transform.h.

#include "taut/base/vec.h"

#include <type_traits>

namespace taut {

/// Canonical M with what evaluation needs of its inverse. Made by the functions below; never has det = 0.
template <class T> struct BasicMicroTransform {
    T a = 1, b = 0, d = 1; ///< 2x2 block [a b; 0 d], local shading space
    T p = 0, q = 0;        ///< lean (column 3)
    T inverseA = 1, inverseD = 1;
    T det = 1; ///< a d > 0

    /// M^T w: maps a micro-normal (or half vector, any length) of the transformed surface to the standard one.
    [[nodiscard]] Vector3<T> transposed(const Vector3<T> &w) const { return {a * w.x, b * w.x + d * w.y, p * w.x + q * w.y + w.z}; }
    /// M^-1 w: maps a direction (not normalised) to standard space. Leaves w.z as it is.
    [[nodiscard]] Vector3<T> inverse(const Vector3<T> &w) const {
        const T y = (w.y - q * w.z) * inverseD;
        return {(w.x - p * w.z - b * y) * inverseA, y, w.z};
    }
    /// M^-T w: maps a standard micro-normal to the transformed surface (not normalised).
    [[nodiscard]] Vector3<T> inverseTransposed(const Vector3<T> &w) const {
        const T x = w.x * inverseA;
        const T y = (w.y - b * x) * inverseD;
        return {x, y, w.z - p * x - q * y};
    }
    [[nodiscard]] bool upright() const { return (p == 0) & (q == 0); }
};
using MicroTransform = BasicMicroTransform<float>;

/// What M is worked out in before it is rounded to T.
template <class T> using Wider = std::conditional_t<std::is_same_v<T, float>, double, T>;

/// Singular values of M's 2x2 block that rendering in float can carry: alpha = 1 / sigma stays in [1e-5, 1e5]. A collapsed
/// surface (a singular value of 0) becomes infinitely rough in theory; the policy, `ClampSingularValues`, is to hold the
/// singular value at the end of this range and keep its direction.
inline constexpr float kLeastSingularValue = 1e-5F;
inline constexpr float kGreatestSingularValue = 1e5F;

/// Larger and smaller singular value of [a b; c d], without cancellation in the smaller (it is |det| / larger).
template <class T = float>
Vector2<T> singularValues(std::type_identity_t<T> a, std::type_identity_t<T> b, std::type_identity_t<T> c, std::type_identity_t<T> d) {
    const T e = (a + d) / 2;
    const T f = (a - d) / 2;
    const T g = (c + b) / 2;
    const T h = (c - b) / 2;
    const T larger = std::hypot(e, h) + std::hypot(f, g);
    return {larger, larger > 0 ? std::fabs(a * d - b * c) / larger : T(0)};
}
/// Of M's 2x2 block: 1 / alphaMin and 1 / alphaMax.
template <class T> Vector2<T> singularValues(const BasicMicroTransform<T> &m) {
    const T larger = singularValues<T>(m.a, m.b, 0, m.d).x;
    return {larger, m.det / larger};
}

/// M from its canonical numbers as they are; a, d > 0.
template <class T = float>
BasicMicroTransform<T> canonicalTransform(std::type_identity_t<Wider<T>> a, std::type_identity_t<Wider<T>> b,
                                          std::type_identity_t<Wider<T>> d, std::type_identity_t<Wider<T>> p = 0,
                                          std::type_identity_t<Wider<T>> q = 0) {
    return {T(a), T(b), T(d), T(p), T(q), T(1 / a), T(1 / d), T(a * d)};
}

/// A 2x2 block turned on the right into [across along; 0 length], which leaves M M^T alone.
template <class W> struct TriangularForm {
    W across, along, length;
    bool inRange; ///< its singular values are within the limits above
};
/// LQ of [a b; c d] by one Givens rotation: the second row becomes (0, |(c, d)|), the first keeps its area and its product with the
/// second. The signs of the columns are free in M M^T.
template <class W> inline TriangularForm<W> triangularForm(W a, W b, W c, W d) {
    constexpr W kLeast = kLeastSingularValue;
    constexpr W kGreatest = kGreatestSingularValue;
    const W det = std::fabs(a * d - b * c);
    const W length = std::sqrt(c * c + d * d);
    const W along = length > 0 ? (a * c + b * d) / length : b;
    const W across = length > 0 ? det / length : std::fabs(a);
    const W norm2 = across * across + along * along + length * length;
    // Without && : loops over many hits are vectorised.
    const bool inRange = (det > 0) & (norm2 <= kGreatest * kGreatest) & (det * det >= kLeast * kLeast * norm2);
    return {across, along, length, inRange};
}

/// From any 2x2 block [a b; c d] (rows; det of either sign or zero) and a lean. Rotates on the right to triangular form, which
/// leaves M M^T alone, and clamps singular values (policy above).
template <class T = float>
BasicMicroTransform<T> microTransform(std::type_identity_t<Wider<T>> a, std::type_identity_t<Wider<T>> b, std::type_identity_t<Wider<T>> c,
                                      std::type_identity_t<Wider<T>> d, std::type_identity_t<Wider<T>> p = 0,
                                      std::type_identity_t<Wider<T>> q = 0) {
    using W = Wider<T>;
    constexpr W kLeast = kLeastSingularValue;
    constexpr W kGreatest = kGreatestSingularValue;
    const auto [across, along, length, inRange] = triangularForm<W>(a, b, c, d);
    if (inRange) return canonicalTransform<T>(across, along, length, p, q);

    const Vector2<W> sigma = singularValues<W>(across, along, 0, length);
    if (sigma.y >= kLeast && sigma.x <= kGreatest) return canonicalTransform<T>(across, along, length, p, q);
    // Rebuild from the eigenvectors of M M^T with its singular values clamped.
    const W angle = std::isfinite(sigma.x) ? std::atan2(2 * along * length, across * across + along * along - length * length) / 2 : W(0);
    const W cosine = std::cos(angle);
    const W sine = std::sin(angle);
    const W larger = std::isfinite(sigma.x) ? glm::clamp(sigma.x, kLeast, kGreatest) : W(1);
    const W smaller = std::isfinite(sigma.y) ? glm::clamp(sigma.y, kLeast, kGreatest) : W(1);
    const W height = std::hypot(sine * larger, cosine * smaller);
    return canonicalTransform<T>(larger * smaller / height, cosine * sine * (larger * larger - smaller * smaller) / height, height, p, q);
}

/// A 2x2 block by rows, [a b; c d].
template <class T> struct BasicBlock { T a = 1, b = 0, c = 0, d = 1; };
using Block = BasicBlock<float>;

/// Rest material: the block of M0 = R diag(1/alphaX, 1/alphaY), R turning the x axis to the unit vector `axis`.
template <class T> BasicBlock<Wider<T>> restBlock(T alphaX, T alphaY, const Vector2<T> &axis) {
    using W = Wider<T>;
    const W x = alphaX;
    const W y = alphaY;
    return {axis.x / x, -axis.y / y, axis.y / x, axis.x / y};
}

/// Rest material as a whole; rotation in radians, counter-clockwise from the tangent.
template <class T = float>
BasicMicroTransform<T> microTransformFromAlpha(std::type_identity_t<T> alphaX, std::type_identity_t<T> alphaY,
                                               std::type_identity_t<T> rotation = 0) {
    const Vector2<T> axis = rotation == 0 ? Vector2<T>(1, 0) : Vector2<T>(std::cos(rotation), std::sin(rotation));
    const auto rest = restBlock<T>(alphaX, alphaY, axis);
    return microTransform<T>(rest.a, rest.b, rest.c, rest.d);
}

/// A rest surface under a deformation: M = [A/lambda, lean/lambda; 0, 1] M0, with A the surface's gradient between orthonormal tangent
/// frames (rest to deformed), lambda the stretch along the normal (normalStretch) and `lean` how far the tangent plane's points
/// are carried sideways per unit of height, before division by lambda. `rest` is the block of M0.
template <class T, class R>
BasicMicroTransform<T> deformedTransform(const BasicBlock<T> &gradient, const BasicBlock<R> &rest, std::type_identity_t<T> lambda = 1,
                                         const Vector2<T> &lean = Vector2<T>(0)) {
    using W = Wider<T>;
    const W inverse = 1 / W(lambda);
    const BasicBlock<W> a{gradient.a * inverse, gradient.b * inverse, gradient.c * inverse, gradient.d * inverse};
    return microTransform<T>(a.a * rest.a + a.b * rest.c, a.a * rest.b + a.b * rest.d, a.c * rest.a + a.d * rest.c,
                             a.c * rest.b + a.d * rest.d, lean.x * inverse, lean.y * inverse);
}
/// A deformation after another: of a surface that is a transformed one already, leaning or not.
template <class T>
BasicMicroTransform<T> deformedTransform(const BasicBlock<T> &gradient, const BasicMicroTransform<T> &rest,
                                         std::type_identity_t<T> lambda = 1, const Vector2<T> &lean = Vector2<T>(0)) {
    const Vector2<T> carried(gradient.a * rest.p + gradient.b * rest.q + lean.x, gradient.c * rest.p + gradient.d * rest.q + lean.y);
    return deformedTransform(gradient, BasicBlock<T>{rest.a, rest.b, 0, rest.d}, lambda, carried);
}

/// GGX parameters that look the same: alphaMax >= alphaMin and the direction of the rougher axis, radians in (-pi/2, pi/2],
/// from the slope tensor Sigma = (M M^T)^-1. Defined for an upright M; ignores a lean.
template <class T> struct BasicEquivalentAlpha { T max, min, phi; };
using EquivalentAlpha = BasicEquivalentAlpha<float>;
template <class T> BasicEquivalentAlpha<T> equivalentAlpha(const BasicMicroTransform<T> &m) {
    const Vector2<T> sigma = singularValues(m);
    // The rougher axis is the less stretched one: perpendicular to the major axis of M M^T.
    const T phi = std::atan2(-2 * m.b * m.d, m.d * m.d - m.a * m.a - m.b * m.b) / 2;
    return {1 / sigma.y, 1 / sigma.x, phi};
}

/// The slope tensor Sigma = (M M^T)^-1 = M^-T M^-1 of the 2x2 block, local shading space; its eigenvalues are alpha^2.
template <class T> struct SlopeTensor {
    T xx, xy, yy;
    T determinant;

    [[nodiscard]] T larger() const { return T(0.5) * (xx + yy + std::sqrt(sqr(xx - yy) + 4 * sqr(xy))); }
    [[nodiscard]] T smaller() const { return determinant / larger(); } ///< without cancellation
};
template <class T> SlopeTensor<T> slopeTensor(const BasicMicroTransform<T> &m) {
    const T skew = -m.b * m.inverseA * m.inverseD; // M^-1 = [1/a skew; 0 1/d]
    return {sqr(m.inverseA), skew * m.inverseA, sqr(skew) + sqr(m.inverseD), sqr(m.inverseA * m.inverseD)};
}

/// Stretch along the normal that a material with Poisson ratio nu in [-1, 0.5] takes when its surface is deformed with area
/// factor |det A|: lambda = det^(-nu/(1-nu)).
inline float normalStretch(float areaFactor, float poisson) {
    return poisson == 0 ? 1.0F : std::pow(areaFactor, -poisson / (1 - poisson));
}

} // namespace taut
