#pragma once
/// Warps of the unit square, each beside its density. u is uniform in [0, 1)^2.

#include "taut/base/vec.h"

#include <algorithm>
#include <numbers>
#include <type_traits>

namespace taut {

/// (cos, sin) of 2 pi `turns`, turns in [-1/8, 1], to 2e-7: polynomials of an eighth of a turn (Chebyshev interpolation in the square of
/// the angle, to 4e-9), then the quadrant. Without branches and calls, so that loops over it can be vectorised.
inline Vec2 unitCircle(float turns) {
    const float quarters = 4 * turns;
    const int quadrant = static_cast<int>(quarters + 0.5F);
    const float t = quarters - static_cast<float>(quadrant);
    const float z = t * t;
    const float s = t * (1.570796322F + z * (-0.6459634777F + z * (0.07968021765F + z * -0.004602149213F)));
    const float c = 1 + z * (-1.233700541F + z * (0.2536692037F + z * (-0.0208600695F + z * 9.036280668e-4F)));
    const bool odd = (quadrant & 1) != 0;
    const float x = odd ? s : c;
    const float y = odd ? c : s;
    return {((quadrant + 1) & 2) != 0 ? -x : x, (quadrant & 2) != 0 ? -y : y};
}

/// Its inverse: the turns in [-1/2, 1/2] of the direction (x, y), of any length, to 3e-8 (Chebyshev interpolation of atan in the square
/// of the ratio); 0 for (0, 0).
inline float turnsOf(float x, float y) {
    const float ax = std::fabs(x);
    const float ay = std::fabs(y);
    const bool steep = ay > ax;
    const float longer = steep ? ay : ax;
    const float t = (steep ? ax : ay) / (longer > 0 ? longer : 1.0F);
    const float z = t * t;
    float turns = 0.003846168515F + z * -0.000743058349F;
    turns = 0.01576604287F + z * (-0.009448567543F + z * turns);
    turns = 0.1591549268F + z * (-0.05304946153F + z * (0.03178202523F + z * (-0.02230808795F + z * turns)));
    turns *= t;
    turns = steep ? 0.25F - turns : turns;
    turns = x < 0 ? 0.5F - turns : turns;
    return y < 0 ? -turns : turns;
}

/// unitCircle() in wider numbers, by the library.
template <class T>
requires(std::is_floating_point_v<T> && !std::is_same_v<T, float>) Vector2<T> unitCircle(T turns) {
    const T angle = 2 * std::numbers::pi_v<T> * turns;
    return {std::cos(angle), std::sin(angle)};
}

/// Concentric map to the unit disk (Shirley & Chiu 1997).
inline Vec2 squareToDisk(const Vec2 &u) {
    const float x = 2 * u.x - 1;
    const float y = 2 * u.y - 1;
    const bool wide = std::fabs(x) > std::fabs(y);
    const float r = wide ? x : y;
    const float ratio = (wide ? y : x) / (r == 0 ? 1.0F : r);
    return r * unitCircle(wide ? ratio / 8 : 0.25F - ratio / 8);
}
inline float squareToDiskPdf() {
    return kInvPi;
}

/// Cosine-weighted upper hemisphere.
inline Vec3 squareToCosineHemisphere(const Vec2 &u) {
    const Vec2 d = squareToDisk(u);
    return {d.x, d.y, std::sqrt(std::max(0.0F, 1 - d.x * d.x - d.y * d.y))};
}
inline float squareToCosineHemispherePdf(float cosTheta) {
    return std::max(cosTheta, 0.0F) * kInvPi;
}

/// Uniform on the sphere.
inline Vec3 squareToSphere(const Vec2 &u) {
    const float z = 1 - 2 * u.x;
    const float r = std::sqrt(std::max(0.0F, 1 - z * z));
    return {r * unitCircle(u.y), z};
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
