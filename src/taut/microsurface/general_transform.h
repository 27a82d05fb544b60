#pragma once
/// M as any invertible 3x3 matrix: micro-geometry under a linear map that tilts the macro-surface too.
///
/// The macro-surface z = 0 of the standard microsurface goes to a plane with normal n' = M^-T z / |M^-T z|, and per area of that plane
///
///     D(m) = |det M| / (pi |M^-T z| |M^T m|^4)      where (M^T m).z > 0,      integral of D(m) m = n'.
///
/// (|M^-T z| is 1 where the last row of M is (0, 0, 1).) In an orthonormal frame R = (s, t, n') the matrix R^T M has the last row
/// (0, 0, r), r = 1 / |M^-T z|: it keeps the plane, and a uniform scale changes no normal, so R^T M / r is a transform with
/// lean as transform.h has them. Nothing else is needed: everything works in that frame on that transform.

#include "taut/base/frame.h"
#include "taut/microsurface/ggx.h"

#include <optional>

namespace taut {

/// D at a unit normal m straight from the general matrix, in M's own space. What the canonical form is tested against.
inline double generalDistribution(const DMat3 &m, const DVec3 &normal) {
    const DVec3 s = glm::transpose(m) * normal;
    if (!(s.z > 0)) return 0;
    const double tilt = glm::length(glm::inverse(glm::transpose(m))[2]); // |M^-T z|
    return std::fabs(glm::determinant(m)) * std::numbers::inv_pi / (tilt * sqr(glm::dot(s, s)));
}

/// A general M brought to canonical form.
struct GeneralTransform {
    Frame frame;          ///< `macroFrame`: z = n', in the space that M maps to; smoothFrameFromNormal(n'), so the identity where n' = z
    MicroTransform micro; ///< in that frame
};

/// Nothing where M is not invertible (or not finite): the macro-surface has no normal, or no thickness to be scaled by.
inline std::optional<GeneralTransform> generalTransform(const DMat3 &m) {
    // n' / r = M^-T z = (column 0 x column 1) / det M.
    const DVec3 area = glm::cross(m[0], m[1]);
    const double size = glm::length(area);
    const double det = glm::dot(area, m[2]);
    const double r = std::fabs(det) / size;
    const auto isFinite = [](const DVec3 &v) { return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z); };
    if (!(r > 0) || !std::isfinite(1 / r) || !isFinite(m[0]) || !isFinite(m[1]) || !isFinite(m[2])) return std::nullopt;

    GeneralTransform general;
    general.frame = smoothFrameFromNormal(Vec3(area * ((det < 0 ? -1 : 1) / size)));
    const DVec3 s = DVec3(general.frame.s) / r;
    const DVec3 t = DVec3(general.frame.t) / r;
    const double p = glm::dot(s, m[2]);
    const double q = glm::dot(t, m[2]);
    general.micro = microTransform(glm::dot(s, m[0]), glm::dot(s, m[1]), glm::dot(t, m[0]), glm::dot(t, m[1]), p, q);
    return general;
}

} // namespace taut
