#pragma once
/// 3x4 affine maps in float: what moves points and vectors of a mesh.

#include "taut/base/vec.h"

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
