#pragma once
/// The unit normal of a deformed tangent parallelogram, and what stands in for it where the parallelogram has collapsed.

#include "taut/base/frame.h"

#include <cmath>

namespace taut {

/// A deformed tangent parallelogram this much thinner than its sides counts as collapsed.
inline constexpr float kCollapsedSine = 1e-6F;
/// ... and one of less than this area, whatever its shape: squares of it leave float.
inline constexpr float kCollapsedArea = 1e-15F;

inline bool isCollapsed(float area, const Vec3 &f1, const Vec3 &f2) {
    return !(area > kCollapsedArea && area > kCollapsedSine * glm::length(f1) * glm::length(f2));
}

/// `v` with length 1, however long it is; 0 where it has no length.
inline Vec3 unitOf(const Vec3 &v) {
    const float size = std::fmax(std::fabs(v.x), std::fmax(std::fabs(v.y), std::fabs(v.z)));
    return size > 0 && std::isfinite(size) ? glm::normalize(v / size) : Vec3(0);
}

/// Policy KeepRestNormal: where the tangent parallelogram has collapsed its normal is the rest normal, carried along and made
/// perpendicular to what is left of the tangents.
inline Vec3 collapsedNormal(const Vec3 &f1, const Vec3 &f2, const Vec3 &carried) {
    const Vec3 u1 = unitOf(f1);
    const Vec3 u2 = unitOf(f2);
    if (!std::isfinite(glm::length(glm::cross(f1, f2)))) { // no collapse, but an area that float does not hold
        const Vec3 upright = glm::cross(u1, u2);
        if (const float sine = glm::length(upright); sine > kCollapsedSine) return upright / sine;
    }
    const Vec3 &longer = glm::dot(f1, f1) >= glm::dot(f2, f2) ? u1 : u2;
    Vec3 n = unitOf(carried);
    if (longer != Vec3(0)) {
        n -= longer * glm::dot(longer, n);
        if (!(glm::dot(n, n) > 1e-12F)) n = smoothFrameFromNormal(longer).s;
    }
    const Vec3 unit = unitOf(n);
    return unit != Vec3(0) ? unit : Vec3(0, 0, 1);
}

/// Unit normal of the tangents f1, f2; `carried` is the image of the rest normal, used where they have collapsed.
inline Vec3 normalOf(const Vec3 &f1, const Vec3 &f2, const Vec3 &carried) {
    const Vec3 n = glm::cross(f1, f2);
    const float length = glm::length(n);
    if (!std::isfinite(length)) return normalOf(f1 * 0x1p-64F, f2 * 0x1p-64F, carried); // squares of areas have left float
    return isCollapsed(length, f1, f2) ? collapsedNormal(f1, f2, carried) : n / length;
}

} // namespace taut
