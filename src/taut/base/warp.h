#pragma once
/// Warps of the unit square, each beside its density. u is uniform in [0, 1)^2.

#include "taut/base/vec.h"

namespace taut {

/// Concentric map to the unit disk (Shirley & Chiu 1997).
inline Vec2 squareToDisk(const Vec2 &u) {
    const float x = 2 * u.x - 1;
    const float y = 2 * u.y - 1;
    if (x == 0 && y == 0) return {0, 0};
    const bool wide = std::fabs(x) > std::fabs(y);
    const float r = wide ? x : y;
    const float phi = wide ? (kPi / 4) * (y / x) : kPi / 2 - (kPi / 4) * (x / y);
    return {r * std::cos(phi), r * std::sin(phi)};
}
inline float squareToDiskPdf() {
    return kInvPi;
}

/// Cosine-weighted upper hemisphere.
inline Vec3 squareToCosineHemisphere(const Vec2 &u) {
    const Vec2 d = squareToDisk(u);
    return {d.x, d.y, std::sqrt(std::fmax(0.0F, 1 - d.x * d.x - d.y * d.y))};
}
inline float squareToCosineHemispherePdf(float cosTheta) {
    return std::fmax(cosTheta, 0.0F) * kInvPi;
}

/// Uniform on the sphere.
inline Vec3 squareToSphere(const Vec2 &u) {
    const float z = 1 - 2 * u.x;
    const float r = std::sqrt(std::fmax(0.0F, 1 - z * z));
    const float phi = 2 * kPi * u.y;
    return {r * std::cos(phi), r * std::sin(phi), z};
}
inline float squareToSpherePdf() {
    return kInvPi / 4;
}

/// Uniform barycentrics (b1, b2) of a triangle (Turk 1990, the folded square keeps strata).
inline Vec2 squareToTriangle(const Vec2 &u) {
    const float root = std::sqrt(u.x);
    return {root * (1 - u.y), root * u.y};
}

} // namespace taut
