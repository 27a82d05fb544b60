#pragma once
/// Facets of a normal, bump or height map: geometry between the mesh and the microsurface, which deforms as both do.
///
/// In the rest tangent frame (t0, b0, n) a map gives slopes s = -grad h, so the mapped normal is n0 ~ (s, 1), and R(s) turns z to n0, its x
/// axis the tangent t0 made perpendicular to n0. Under the deformation F = [A l; 0 lambda] of the mesh the facet's micro-geometry is
///
///     T = F R(s) M0,
///
/// M0 the rest material in the facet's own frame. generalTransform(T) gives the facet's normal n' and, in the frame of n', a transform that
/// leans: turning the normal alone and keeping A there is wrong by that lean. Slopes go to
///
///     s' = lambda A^-T s / (1 - l . A^-T s).
///
/// Over a footprint in which slopes have the mean mu and the covariance C, s = mu and the slope tensor of M0 grows by 2 C as the facet sees
/// it (Olano & Baker 2010, "LEAN Mapping", and Dupuy et al. 2013, "LEADR Mapping", for Gaussian slopes; the factor 2 is the best fit of GGX
/// in total variation).

#include "taut/microsurface/general_transform.h"
#include "taut/microsurface/roughening.h"

namespace taut {

/// Slopes are held at this length: 84 degrees from the mesh's normal.
inline constexpr float kSteepestSlope = 10;

/// A mean slope and, as xx, xy, yy, the covariance of slopes around it; in the rest tangent frame.
struct SlopeStatistics {
    Vec2 mean{0};
    Vec3 covariance{0};
    /// Whether they change anything.
    [[nodiscard]] bool tilt() const { return mean != Vec2(0) || covariance != Vec3(0); }
};

/// F = [A l; 0 lambda] by columns, from the block of A.
inline DMat3 surfaceDeformation(const BasicBlock<double> &a, const DVec2 &lean = DVec2(0), double lambda = 1) {
    return {a.a, a.c, 0, a.b, a.d, 0, lean.x, lean.y, lambda};
}

/// F in orthonormal frames where A = V R and F is divided by the stretch along the normal: V as ss, st, tt in the frame that F leads to,
/// `tangent` R t0 there, `sense` the side of it on which R b0 lies, the lean divided already.
inline DMat3 surfaceDeformation(const DVec3 &stretch, const DVec2 &tangent, double sense, double inverseLambda,
                                const DVec2 &lean = DVec2(0)) {
    const DVec2 t = tangent * inverseLambda;
    const DVec2 b = DVec2(-t.y, t.x) * sense;
    return surfaceDeformation({stretch.x * t.x + stretch.y * t.y, stretch.x * b.x + stretch.y * b.y, stretch.y * t.x + stretch.z * t.y,
                               stretch.y * b.x + stretch.z * b.y},
                              lean);
}

/// R(s).
inline DMat3 facetRotation(const DVec2 &slope) {
    const DVec3 n = DVec3(slope, 1) / std::sqrt(glm::dot(slope, slope) + 1);
    const DVec3 x = glm::normalize(DVec3(1 + slope.y * slope.y, -slope.x * slope.y, -slope.x)); // x - n (n.x), over n.z^2
    const DVec3 y = glm::cross(n, x);
    return {x.x, x.y, x.z, y.x, y.y, y.z, n.x, n.y, n.z};
}

/// s' of a facet whose normal stays on the mesh's side; the slope of M^-T z.
inline DVec2 carriedSlope(const DMat3 &deformation, const DVec2 &slope) {
    const DVec3 normal = glm::inverse(glm::transpose(deformation)) * DVec3(slope, 1);
    return DVec2(normal) / normal.z;
}

/// The block of M0 where the covariance of slopes is added to the rest material's slope tensor: seen in the facet's frame, in which a
/// change of slope ds is R^T (ds, 0) over the length of (s, 1), to first order.
inline BasicBlock<double> broadenedBlock(const BasicBlock<double> &rest, const SlopeStatistics &slopes) {
    if (slopes.covariance == Vec3(0)) return rest;
    const DVec2 mean(slopes.mean);
    const DMat3 r = facetRotation(mean);
    const double shrink = 1 / (1 + glm::dot(mean, mean));
    const auto seen = [&](const DVec3 &u, const DVec3 &v) {
        const DVec3 c(slopes.covariance);
        return 2 * shrink * (u.x * v.x * c.x + (u.x * v.y + u.y * v.x) * c.y + u.y * v.y * c.z);
    };
    const MicroTransform m =
        withAddedSlopes(microTransform(rest.a, rest.b, rest.c, rest.d), seen(r[0], r[0]), seen(r[0], r[1]), seen(r[1], r[1]));
    return {static_cast<double>(m.a), static_cast<double>(m.b), 0, static_cast<double>(m.d)};
}

/// T: `rest` is the block of M0 in the facet's own frame, x along the projected tangent.
inline DMat3 mappedMatrix(const DMat3 &deformation, const DVec2 &slope, const BasicBlock<double> &rest) {
    return deformation * facetRotation(slope) * DMat3(rest.a, rest.c, 0, rest.b, rest.d, 0, 0, 0, 1);
}

/// Normals of a facet that face away from its mesh, or nearly, are not followed: no map means an overhang.
inline constexpr float kLeastFacing = 1e-3F;

/// The facet under the deformation: its normal n' and M, in the space that F leads to. Nothing where F has no inverse.
inline std::optional<GeneralTransform> mappedTransform(const DMat3 &deformation, const SlopeStatistics &slopes,
                                                       const BasicBlock<double> &rest) {
    return generalTransform(mappedMatrix(deformation, DVec2(slopes.mean), broadenedBlock(rest, slopes)));
}

} // namespace taut
