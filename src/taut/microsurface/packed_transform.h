#pragma once
/// M in storage: three numbers upright, five leaning; as floats without loss, or as halves.
///
/// In halves: (a, b, d)/2, then (p, q)/2. Halves are logarithmic by themselves: every number from 6.1e-5 to 65504 is held to one
/// part in 2048. The factor of a half moves that range to [1.2e-4, 1.3e5], which alpha 1e-4..10 and stretch 1e-3..1e3 need up to
/// the clamp of singular values. b is packed for the d that comes back, so that its own rounding is the only one it brings in: the
/// roughness across any direction is off by at most 2^-11 (1 + |b|/a), |b|/a = |Sxy| / det M of S = M M^T. That is 0.05 % without
/// shear, 0.1 % at a shear of 1; for b/a in the hundreds three numbers of 16 bits cannot hold the direction of the long axis,
/// whatever they are: use floats. taut chart precision prints it beside other choices.

#include "taut/microsurface/transform.h"

#include <glm/gtc/packing.hpp>

#include <array>

namespace taut {

/// The canonical numbers: a, b, d, then p, q.
using StoredUpright = std::array<float, 3>;
using StoredLeaning = std::array<float, 5>;
inline StoredUpright storeUpright(const MicroTransform &m) {
    return {m.a, m.b, m.d};
}
inline StoredLeaning storeLeaning(const MicroTransform &m) {
    return {m.a, m.b, m.d, m.p, m.q};
}
inline MicroTransform loadTransform(const StoredUpright &s) {
    return canonicalTransform(s[0], s[1], s[2]);
}
inline MicroTransform loadTransform(const StoredLeaning &s) {
    return canonicalTransform(s[0], s[1], s[2], s[3], s[4]);
}

/// IEEE 754 halves, as bits.
using PackedUpright = std::array<std::uint16_t, 3>;
using PackedLeaning = std::array<std::uint16_t, 5>;

/// The nearest half of finite size.
inline std::uint16_t packHalf(float x) {
    constexpr float kGreatestHalf = 65504;
    return glm::packHalf1x16(glm::clamp(x, -kGreatestHalf, kGreatestHalf));
}

/// Larger singular values than 1.3e5 are clamped by microTransform; diagonals below 1.2e-4 lose digits, down to 1e-5 (1 %).
inline PackedUpright packUpright(const MicroTransform &m) {
    const std::uint16_t d = packHalf(m.d / 2);
    return {packHalf(m.a / 2), packHalf(m.b * m.inverseD * glm::unpackHalf1x16(d)), d};
}
inline PackedLeaning packLeaning(const MicroTransform &m) {
    const PackedUpright upright = packUpright(m);
    return {upright[0], upright[1], upright[2], packHalf(m.p / 2), packHalf(m.q / 2)};
}
/// Any bits give a transform: diagonals are held at the least singular value, what is not a number at 1 (b, p and q: 0).
inline MicroTransform unpackTransform(const PackedLeaning &bits) {
    const auto number = [](std::uint16_t half, float scale, float otherwise) {
        const float x = scale * glm::unpackHalf1x16(half);
        return std::isfinite(x) ? x : otherwise;
    };
    const float a = std::fmax(number(bits[0], 2, 1), kLeastSingularValue);
    const float d = std::fmax(number(bits[2], 2, 1), kLeastSingularValue);
    return canonicalTransform(a, number(bits[1], 2, 0), d, number(bits[3], 2, 0), number(bits[4], 2, 0));
}
inline MicroTransform unpackTransform(const PackedUpright &bits) {
    return unpackTransform(PackedLeaning{bits[0], bits[1], bits[2], 0, 0});
}

/// How far M is from M' where a surface has one and should have the other: the greatest relative error of its stretch |M^T w| over all
/// directions in the surface, which is that of the roughness there; from the singular values of M'^-1 M. Upright parts only.
inline double roughnessError(const MicroTransform &found, const MicroTransform &truth) {
    // [1/a, -b/(a d); 0, 1/d] [A B; 0 D]
    const double a = static_cast<double>(found.a) / static_cast<double>(truth.a);
    const double d = static_cast<double>(found.d) / static_cast<double>(truth.d);
    const double b = (static_cast<double>(found.b) - static_cast<double>(truth.b) * d) / static_cast<double>(truth.a);
    const Vector2<double> sigma = singularValues<double>(a, b, 0, d);
    return std::fmax(std::fabs(sigma.x - 1), std::fabs(sigma.y - 1));
}

} // namespace taut
