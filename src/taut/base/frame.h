#pragma once
/// Orthonormal right-handed frames (s, t, n). Stretch and shear never live in a frame: they live in M.

#include "taut/base/vec.h"

#include <cassert>

namespace taut {

/// Orthonormal frame; local z is `n`. Checked on construction in debug builds.
struct Frame {
    Vec3 s{1, 0, 0};
    Vec3 t{0, 1, 0};
    Vec3 n{0, 0, 1};

    Frame() = default;
    Frame(const Vec3 &s_, const Vec3 &t_, const Vec3 &n_) : s(s_), t(t_), n(n_) {
        assert(std::fabs(glm::dot(s, t)) < 1e-4F && std::fabs(glm::dot(s, n)) < 1e-4F && std::fabs(glm::dot(t, n)) < 1e-4F);
        assert(std::fabs(glm::dot(s, s) - 1) < 1e-4F && std::fabs(glm::dot(t, t) - 1) < 1e-4F && std::fabs(glm::dot(n, n) - 1) < 1e-4F);
    }

    [[nodiscard]] Vec3 toLocal(const Vec3 &w) const { return {glm::dot(w, s), glm::dot(w, t), glm::dot(w, n)}; }
    [[nodiscard]] Vec3 fromLocal(const Vec3 &l) const { return s * l.x + t * l.y + n * l.z; }
    [[nodiscard]] Frame toLocal(const Frame &f) const { return {toLocal(f.s), toLocal(f.t), toLocal(f.n)}; }
    /// A frame that is given in this one.
    [[nodiscard]] Frame fromLocal(const Frame &f) const { return {fromLocal(f.s), fromLocal(f.t), fromLocal(f.n)}; }
};

/// Frame of a unit normal that is a smooth function of the normal away from n = -z, where the field has its one
/// singular point (the sphere's hair must part somewhere). Frisvad 2012, without the branch of Duff et al. 2017, which
/// would put a seam along the equator.
inline Vec3 smoothTangentFromNormal(const Vec3 &n) {
    // 1 / (1 + z), below the equator as (1 - z) / (x^2 + y^2): near the singular point 1 + z has lost its digits.
    // Selections, not branches: loops over many hits are vectorised.
    const float xy2 = n.x * n.x + n.y * n.y;
    const bool pole = (n.z < 0) & (xy2 < 1e-14F);
    const float k = n.z < 0 ? (1 - n.z) / xy2 : 1 / (1 + n.z);
    const Vec3 along(1 - n.x * n.x * k, -n.x * n.y * k, -n.x);
    const float scale = 1 / std::sqrt(glm::dot(along, along));
    return {pole ? 0.0F : along.x * scale, pole ? -1.0F : along.y * scale, pole ? 0.0F : along.z * scale};
}
inline Frame smoothFrameFromNormal(const Vec3 &n) {
    const Vec3 s = smoothTangentFromNormal(n);
    return {s, glm::cross(n, s), n};
}

/// Frame of a unit normal by one division and no root, where any will do that is always the same for a normal: it jumps where n.z
/// changes sign. Duff et al. 2017.
inline Frame quickFrameFromNormal(const Vec3 &n) {
    const float sign = std::copysign(1.0F, n.z);
    const float a = -1 / (sign + n.z);
    const float b = n.x * n.y * a;
    return {{1 + sign * n.x * n.x * a, sign * b, -sign * n.x}, {b, sign + n.y * n.y * a, -n.y}, n};
}

/// Frame with normal `n` (unit) whose s is `tangent` made perpendicular to n; falls back to smoothFrameFromNormal where
/// the tangent vanishes in the plane of n.
inline Frame frameFromNormalTangent(const Vec3 &n, const Vec3 &tangent) {
    const Vec3 s = tangent - n * glm::dot(n, tangent);
    const float lengthSquared = glm::dot(s, s);
    if (!(lengthSquared > 1e-12F * glm::dot(tangent, tangent))) return smoothFrameFromNormal(n);
    // The second projection removes what cancellation left of n in s.
    Vec3 unit = s / std::sqrt(lengthSquared);
    unit = glm::normalize(unit - n * glm::dot(n, unit));
    return {unit, glm::cross(n, unit), n};
}

} // namespace taut
