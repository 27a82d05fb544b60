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

#include "taut/base/vec.h"

namespace taut {

/// Canonical M with what evaluation needs of its inverse. Made by the functions below; never has det = 0.
struct MicroTransform {
    float a = 1, b = 0, d = 1; ///< 2x2 block [a b; 0 d], local shading space
    float p = 0, q = 0;        ///< lean (column 3)
    float inverseA = 1, inverseD = 1;
    float det = 1; ///< a d > 0

    /// M^T w: maps a micro-normal (or half vector, any length) of the transformed surface to the standard one.
    [[nodiscard]] Vec3 transposed(const Vec3 &w) const { return {a * w.x, b * w.x + d * w.y, p * w.x + q * w.y + w.z}; }
    /// M^-1 w: maps a direction (not normalised) to standard space. Leaves w.z as it is.
    [[nodiscard]] Vec3 inverse(const Vec3 &w) const {
        const float y = (w.y - q * w.z) * inverseD;
        return {(w.x - p * w.z - b * y) * inverseA, y, w.z};
    }
    /// M^-T w: maps a standard micro-normal to the transformed surface (not normalised).
    [[nodiscard]] Vec3 inverseTransposed(const Vec3 &w) const {
        const float x = w.x * inverseA;
        const float y = (w.y - b * x) * inverseD;
        return {x, y, w.z - p * x - q * y};
    }
    [[nodiscard]] bool upright() const { return p == 0 && q == 0; }
};

/// Singular values of M's 2x2 block that rendering in float can carry: alpha = 1 / sigma stays in [1e-5, 1e5]. A collapsed
/// surface (a singular value of 0) becomes infinitely rough in theory; the policy, `ClampSingularValues`, is to hold the
/// singular value at the end of this range and keep its direction.
inline constexpr float kLeastSingularValue = 1e-5F;
inline constexpr float kGreatestSingularValue = 1e5F;

/// Larger and smaller singular value of [a b; c d], without cancellation in the smaller (it is det / larger).
inline Vec2 singularValues(float a, float b, float c, float d) {
    const float e = 0.5F * (a + d);
    const float f = 0.5F * (a - d);
    const float g = 0.5F * (c + b);
    const float h = 0.5F * (c - b);
    const float larger = std::hypot(e, h) + std::hypot(f, g);
    return {larger, larger > 0 ? std::fabs(a * d - b * c) / larger : 0.0F};
}

/// From any 2x2 block [a b; c d] (rows; det of either sign or zero) and a lean. Rotates on the right to triangular form, which
/// leaves M M^T alone, and clamps singular values (policy above).
inline MicroTransform microTransform(float a, float b, float c, float d, float p = 0, float q = 0) {
    // LQ by one Givens rotation: the second row becomes (0, hypot(c, d)).
    float length = std::hypot(c, d);
    const float cosine = length > 0 ? d / length : 1;
    const float sine = length > 0 ? c / length : 0;
    MicroTransform m;
    m.a = std::fabs(a * cosine - b * sine); // the sign of a column is free in M M^T; b belongs to the other column
    m.b = a * sine + b * cosine;
    m.d = length;
    m.p = p;
    m.q = q;
    const Vec2 sigma = singularValues(m.a, m.b, 0, m.d);
    if (!(sigma.y >= kLeastSingularValue && sigma.x <= kGreatestSingularValue)) {
        // Rebuild from the eigenvectors of M M^T with its singular values clamped.
        const float angle = std::isfinite(sigma.x) ? 0.5F * std::atan2(2 * m.b * m.d, m.a * m.a + m.b * m.b - m.d * m.d) : 0;
        const float cs = std::cos(angle);
        const float sn = std::sin(angle);
        const float larger = std::isfinite(sigma.x) ? glm::clamp(sigma.x, kLeastSingularValue, kGreatestSingularValue) : 1.0F;
        const float smaller = std::isfinite(sigma.y) ? glm::clamp(sigma.y, kLeastSingularValue, kGreatestSingularValue) : 1.0F;
        length = std::hypot(sn * larger, cs * smaller);
        m.d = length;
        m.a = larger * smaller / length;
        m.b = cs * sn * (larger * larger - smaller * smaller) / length;
    }
    m.inverseA = 1 / m.a;
    m.inverseD = 1 / m.d;
    m.det = m.a * m.d;
    return m;
}

/// Rest material: M0 = R(rotation) diag(1/alphaX, 1/alphaY); rotation in radians, counter-clockwise from the tangent.
inline MicroTransform microTransformFromAlpha(float alphaX, float alphaY, float rotation = 0) {
    if (rotation == 0) return microTransform(1 / alphaX, 0, 0, 1 / alphaY);
    const float c = std::cos(rotation);
    const float s = std::sin(rotation);
    return microTransform(c / alphaX, -s / alphaY, s / alphaX, c / alphaY);
}

/// GGX parameters that look the same: alphaMax >= alphaMin and the direction of the rougher axis, radians in (-pi/2, pi/2],
/// from the slope tensor Sigma = (M M^T)^-1. Defined for an upright M; ignores a lean.
struct EquivalentAlpha {
    float max, min, phi;
};
inline EquivalentAlpha equivalentAlpha(const MicroTransform &m) {
    const Vec2 sigma = singularValues(m.a, m.b, 0, m.d);
    // The rougher axis is the less stretched one: perpendicular to the major axis of M M^T.
    const float phi = 0.5F * std::atan2(-2 * m.b * m.d, m.d * m.d - m.a * m.a - m.b * m.b);
    return {1 / sigma.y, 1 / sigma.x, phi};
}

/// The slope tensor Sigma = (M M^T)^-1 = M^-T M^-1 of the 2x2 block, local shading space; its eigenvalues are alpha^2.
struct SlopeTensor {
    float xx, xy, yy;
    float determinant;

    [[nodiscard]] float larger() const { return 0.5F * (xx + yy + std::sqrt(sqr(xx - yy) + 4 * sqr(xy))); }
    [[nodiscard]] float smaller() const { return determinant / larger(); } ///< without cancellation
};
inline SlopeTensor slopeTensor(const MicroTransform &m) {
    const float skew = -m.b * m.inverseA * m.inverseD; // M^-1 = [1/a skew; 0 1/d]
    return {sqr(m.inverseA), skew * m.inverseA, sqr(skew) + sqr(m.inverseD), sqr(m.inverseA * m.inverseD)};
}

/// Stretch along the normal that a material with Poisson ratio nu in [-1, 0.5] takes when its surface is deformed with area
/// factor |det A|: lambda = det^(-nu/(1-nu)).
inline float normalStretch(float areaFactor, float poisson) {
    return poisson == 0 ? 1.0F : std::pow(areaFactor, -poisson / (1 - poisson));
}

} // namespace taut
