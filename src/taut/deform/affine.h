#pragma once
/// 3x4 affine maps in float: what moves points and vectors of a mesh.

#include "taut/base/vec.h"

#include <cmath>
#include <span>

namespace taut {

/// Column-major: columns x, y, z, translation.
using Affine = Matrix<4, 3, float>;

/// The upper three rows of an affine matrix.
inline Affine affineOf(const DMat4 &m) {
    return Affine(Vec3(m[0]), Vec3(m[1]), Vec3(m[2]), Vec3(m[3]));
}

inline Vec3 transformPoint(const Affine &m, const Vec3 &p) {
    return m[0] * p.x + m[1] * p.y + m[2] * p.z + m[3];
}
inline Vec3 transformVector(const Affine &m, const Vec3 &v) {
    return m[0] * v.x + m[1] * v.y + m[2] * v.z;
}

/// The inverse of a map of any scale: glm's determinant is a product of three scales, which leaves float at 1e-13 and 1e13. The scale
/// is taken out and put back as a power of two, exactly.
inline Mat3 inverseOf(const Mat3 &m) {
    float size = 0;
    for (int c = 0; c < 3; ++c)
        for (int r = 0; r < 3; ++r) size = std::fmax(size, std::fabs(m[c][r]));
    const float scale = size > 0 && std::isfinite(size) ? std::ldexp(1.0F, -std::ilogb(size)) : 1.0F;
    return glm::inverse(m * scale) * scale;
}

/// 1 where a linear map keeps orientation, -1 where it turns space over, 0 where it is too flat to tell.
inline int orientationOf(const DMat3 &m) {
    const double det = glm::determinant(m);
    const double sizes = glm::dot(m[0], m[0]) * glm::dot(m[1], m[1]) * glm::dot(m[2], m[2]);
    return det * det > 1e-12 * sizes ? (det < 0 ? -1 : 1) : 0;
}

inline Mat3 linearOf(const Affine &m) {
    return {m[0], m[1], m[2]};
}

/// Between equally spaced maps, entry by entry; `time` in 0 to 1.
inline Affine affineAt(std::span<const Affine> maps, float time) {
    if (maps.size() == 1) return maps[0];
    const std::size_t last = maps.size() - 1;
    const float at = time * static_cast<float>(last);
    const std::size_t before = static_cast<std::size_t>(at) < last ? static_cast<std::size_t>(at) : last - 1;
    const float u = at - static_cast<float>(before);
    Affine m;
    for (int c = 0; c < 4; ++c) m[c] = glm::mix(maps[before][c], maps[before + 1][c], u);
    return m;
}

} // namespace taut
