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

#include <limits>
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

/// The parts of a general M, without a branch: loops over many hits are vectorised.
struct GeneralForm {
    Vec3 s, t, n;             ///< GeneralTransform::frame
    BasicBlock<double> block; ///< of M in that frame, not yet brought to canonical form
    double p, q;              ///< lean
    bool hasInverse;          ///< else the rest means nothing
};
inline GeneralForm generalForm(const DMat3 &m) {
    // n' / r = M^-T z = (column 0 x column 1) / det M.
    const DVec3 area = glm::cross(m[0], m[1]);
    const double size = std::sqrt(glm::dot(area, area));
    const double det = glm::dot(area, m[2]);
    const double r = std::fabs(det) / size;
    constexpr double kGreatest = std::numeric_limits<double>::max();
    const auto isFinite = [](const DVec3 &v) {
        return (std::fabs(v.x) <= kGreatest) & (std::fabs(v.y) <= kGreatest) & (std::fabs(v.z) <= kGreatest);
    };
    const bool hasInverse = (r > 0) & (1 / r <= kGreatest) & isFinite(m[0]) & isFinite(m[1]) & isFinite(m[2]);
    const double upwards = (det < 0 ? -1 : 1) / size;
    const Vec3 n(static_cast<float>(area.x * upwards), static_cast<float>(area.y * upwards), static_cast<float>(area.z * upwards));
    const Vec3 s = smoothTangentFromNormal(n);
    const Vec3 t = glm::cross(n, s);
    const DVec3 x = DVec3(s) / r;
    const DVec3 y = DVec3(t) / r;
    GeneralForm form;
    form.s = {s.x, s.y, s.z};
    form.t = {t.x, t.y, t.z};
    form.n = {n.x, n.y, n.z};
    form.block = {glm::dot(x, m[0]), glm::dot(x, m[1]), glm::dot(y, m[0]), glm::dot(y, m[1])};
    form.p = glm::dot(x, m[2]);
    form.q = glm::dot(y, m[2]);
    form.hasInverse = hasInverse;
    return form;
}

/// Nothing where M is not invertible (or not finite): the macro-surface has no normal, or no thickness to be scaled by.
inline std::optional<GeneralTransform> generalTransform(const DMat3 &m) {
    const GeneralForm form = generalForm(m);
    if (!form.hasInverse) return std::nullopt;
    return GeneralTransform{{form.s, form.t, form.n},
                            microTransform(form.block.a, form.block.b, form.block.c, form.block.d, form.p, form.q)};
}

} // namespace taut
