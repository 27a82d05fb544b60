#pragma once
/// Warps of the unit square, each beside its density. u is uniform in [0, 1)^2.

#include "taut/base/vec.h"

#include <algorithm>
#include <bit>
#include <cstdint>
#include <limits>
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

/// Half a chord of the unit disk.
template <class T> struct HalfChord {
    T x;    ///< where it crosses the x axis
    T half; ///< sqrt(1 - x^2)
};

/// The chord x = const left of which lies the share u of the disk, the quantile of Wigner's semicircle: with x = cos(phi) and u below a
/// half, phi - sin(phi) cos(phi) = 2 pi u. sin(phi) and cos(phi) are power series in the cube root of u and its square (Chebyshev
/// interpolation, to 6e-7). No branches and calls, as above.
inline HalfChord<float> diskQuantile(float u) {
    const float w = std::max(1 - std::fabs(2 * u - 1), 1e-30F); // 0 at both ends, 1 in the middle
    // Cube root: a third of the exponent, then Halley's steps, which triple the digits of 5 %.
    float s = std::bit_cast<float>(static_cast<std::int32_t>(static_cast<float>(std::bit_cast<std::int32_t>(w)) * (1.0F / 3)) + 0x2a5137a0);
    for (int i = 0; i < 2; ++i) {
        const float cube = s * s * s;
        s *= (cube + 2 * w) / (2 * cube + w);
    }
    const float z = s * s;
    float sine = -0.05276620829F + z * (0.04408078254F + z * -0.01968313174F);
    sine = 1.330670445F + z * (-0.2356690539F + z * (-0.05563663955F + z * (-0.02813794679F + z * (0.01714237198F + z * sine))));
    float fall = 0.01640334047F + z * (-0.01345819511F + z * 0.006140884528F);
    fall = 0.885341254F + z * (0.07839799155F + z * (0.02151086076F + z * (0.01025628067F + z * (-0.004592602176F + z * fall))));
    const float x = std::max(1 - z * fall, 0.0F);
    return {u < 0.5F ? -x : x, s * sine};
}
/// The chord left of which lies the share u of the disk, in wider numbers, by bisection.
template <class T>
requires(std::is_floating_point_v<T> && !std::is_same_v<T, float>) HalfChord<T> diskQuantile(T u) {
    T below = 0;
    T above = std::numbers::pi_v<T>;
    for (int i = 0; i < std::numeric_limits<T>::digits; ++i) {
        const T phi = (below + above) / 2;
        (phi - std::sin(phi) * std::cos(phi) < std::numbers::pi_v<T> * u ? below : above) = phi;
    }
    return {-std::cos(below), std::sin(below)};
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
