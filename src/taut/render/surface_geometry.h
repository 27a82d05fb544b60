#pragma once
/// From what is interpolated between a triangle's corners to the shading frame: one formula for hits one by one (shading.h) and many
/// at once (hit_lanes.h). Selections, not branches.
///
/// Two signs, 1 or -1. `facing`: 1 where the surface is seen from the outside; frames, normals and leans follow the viewer's side.
/// `sense`: 1 where b0, across the rest tangent t0, lies at cross(n, t0), -1 where the UV map is mirrored: of a tangent, in w, against
/// the outward normal; of a SurfaceGeometry against the viewer's. An object that its placement mirrors (ObjectSurface::mirrored) needs
/// none: the edges of its triangles change places.

#include "taut/base/frame.h"
#include "taut/deform/gradient_interpolation.h"
#include "taut/microsurface/transform.h"

#include <bit>
#include <cstdint>

namespace taut {

/// A point of a triangle, render space.
struct InterpolatedSurface {
    Vec3 position;
    Vec3 e1, e2;   ///< edges from the first corner, counter-clockwise seen from the outside
    Vec3 normal;   ///< of any length
    Vec4 tangent;  ///< rotated rest tangent, of any length; w: the sense, outside
    float corners; ///< greatest coordinate of what the position is computed from
};

struct SurfaceGeometry {
    Vec3 geometricNormal; ///< unit, towards the viewer
    Vec3 s, t, n;         ///< shading frame, a function of the shading normal n alone; n on the viewer's side
    Vec2 tangent;         ///< unit, in the frame
    float clearance;      ///< distance from the surface at which a ray may start
    float facing;
    float sense; ///< of the tangent, on the viewer's side
};

/// Greatest coordinate.
inline float extentOf(const Vec3 &v) {
    const float x = std::fabs(v.x);
    const float y = std::fabs(v.y);
    const float z = std::fabs(v.z);
    const float xy = x > y ? x : y;
    return xy > z ? xy : z;
}

/// Render space has the camera at the origin, so rounding of a position grows with its distance; and with the size of what it is
/// computed from: a triangle whose corners are far away, a mesh that is placed from afar.
inline float clearanceOf(const Vec3 &position, float corners) {
    const float near = 4e-6F * extentOf(position);
    const float far = 1e-6F * corners;
    const float larger = near > far ? near : far;
    return larger > 1e-12F ? larger : 1e-12F;
}

/// A power of two that brings lengths of about `extent` near 1, exactly: squares of the areas of triangles leave float from a billion
/// metres on.
inline float scaleToUnit(float extent) {
    const auto exponent = std::bit_cast<std::uint32_t>(extent) & 0x7f800000U;
    return std::bit_cast<float>(0x7f000000U - (exponent < 0x7f000000U ? exponent : 0x7e800000U));
}

/// `wo`: unit, back along the ray.
inline SurfaceGeometry surfaceGeometry(const InterpolatedSurface &p, const Vec3 &wo) {
    SurfaceGeometry g;
    const float unit = scaleToUnit(p.corners);
    const Vec3 cross = glm::cross(p.e1 * unit, p.e2 * unit);
    const float doubleArea = std::sqrt(glm::dot(cross, cross));
    const bool flat = doubleArea > 0;
    const float inverse = flat ? 1 / doubleArea : 0.0F;
    const Vec3 geometric(flat ? cross.x * inverse : wo.x, flat ? cross.y * inverse : wo.y, flat ? cross.z * inverse : wo.z);
    g.facing = glm::dot(geometric, wo) >= 0 ? 1.0F : -1.0F;
    g.geometricNormal = geometric * g.facing;
    const float length = std::sqrt(glm::dot(p.normal, p.normal));
    const bool smooth = length > 0;
    const float scale = (smooth ? 1 / length : 0.0F) * g.facing;
    g.n.x = smooth ? p.normal.x * scale : g.geometricNormal.x;
    g.n.y = smooth ? p.normal.y * scale : g.geometricNormal.y;
    g.n.z = smooth ? p.normal.z * scale : g.geometricNormal.z;
    g.s = smoothTangentFromNormal(g.n);
    g.t = glm::cross(g.n, g.s);
    const Vec3 tangent(p.tangent.x, p.tangent.y, p.tangent.z);
    const float x = glm::dot(g.s, tangent);
    const float y = glm::dot(g.t, tangent);
    const float tangentLength = std::sqrt(x * x + y * y);
    const bool known = tangentLength > 0;
    const float perLength = known ? 1 / tangentLength : 0.0F;
    g.tangent = {known ? x * perLength : 1.0F, known ? y * perLength : 0.0F};
    g.clearance = clearanceOf(p.position, p.corners);
    g.sense = (p.tangent.w < 0 ? -1.0F : 1.0F) * g.facing;
    return g;
}

} // namespace taut
