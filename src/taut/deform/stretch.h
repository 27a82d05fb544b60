#pragma once
/// The interpolated form of a surface gradient: polar decomposition in the tangent plane, A = V R.
///
/// V, the left stretch tensor, is kept as a symmetric 3x3 tensor in the space of ds and dt, with sqrt(det A) along the normal:
/// at rest and under rigid motion it is the identity, under uniform scaling a multiple of it, whatever the normals of a
/// triangle's corners do, so interpolating it changes no alpha there. It does not depend on the rest tangent field at all.
/// R t0, the rotated tangent, is a unit vector and is interpolated as any renderer interpolates tangents.
/// (Of the schemes in docs/decisions.md, "V is interpolated, not ds and dt", this is `stretch`: exact at rest on curved surfaces.)

#include "taut/base/vec.h"

namespace taut {

/// Symmetric 3x3 tensor.
struct SymmetricTensor {
    Vec3 diagonal{1};    ///< xx, yy, zz
    Vec3 offDiagonal{0}; ///< xy, xz, yz
    [[nodiscard]] Vec3 times(const Vec3 &v) const {
        return {diagonal.x * v.x + offDiagonal.x * v.y + offDiagonal.y * v.z, offDiagonal.x * v.x + diagonal.y * v.y + offDiagonal.z * v.z,
                offDiagonal.y * v.x + offDiagonal.z * v.y + diagonal.z * v.z};
    }
};

/// F n0 as M takes it: one over its length along the normal, and its tangential part over that length. No lean where space has
/// collapsed onto the surface.
struct Lean {
    float inverseLambda = 1;
    Vec3 tangential{0};
};
inline Lean leanOf(const Vec3 &normalImage, const Vec3 &n) {
    const float along = glm::dot(normalImage, n);
    const float lambda = std::fabs(along);
    if (!(lambda > 1e-6F * glm::length(normalImage))) return {};
    return {1 / lambda, (normalImage - n * along) / along};
}

/// Images ds of t0 and dt of b0 from those of e1 and e2, with t0 = k.x e1 + k.y e2 and b0 = k.z e1 + k.w e2 (of e1 and e2 themselves:
/// t0 and b0).
struct Tangents {
    Vec3 ds, dt;
};
inline Tangents tangentsFrom(const Vec4 &k, const Vec3 &f1, const Vec3 &f2) {
    return {f1 * k.x + f2 * k.y, f1 * k.z + f2 * k.w};
}

struct PolarGradient {
    SymmetricTensor stretch; ///< V
    Vec4 tangent;            ///< xyz = R t0, unit; w = +1 or -1: the sense of dt (-1 under mirrored UVs)
};

/// Polar decomposition of the map t0 -> ds, b0 -> dt, both perpendicular to the unit normal n. Defined for collapsed gradients.
/// For 2x2: V = (A A^T + |det| I) / tau, R = (A + |det| A^-T) / tau, tau = sqrt(|A|^2 + 2 |det|).
inline PolarGradient polarGradient(const Vec3 &ds, const Vec3 &dt, const Vec3 &n) {
    const float signedArea = glm::dot(glm::cross(ds, dt), n);
    const float hand = signedArea < 0 ? -1.0F : 1.0F;
    const float area = std::fabs(signedArea);
    const float tau = std::sqrt(glm::dot(ds, ds) + glm::dot(dt, dt) + 2 * area);
    // Selections, not branches: loops over many vertices are vectorised (polar_batch.h). A vanishing gradient has V = 0.
    const float inverse = tau > 0 ? 1 / tau : 0.0F;
    // (ds ds^T + dt dt^T + area (I - n n^T)) / tau + sqrt(area) n n^T
    const float along = std::sqrt(area) - area * inverse;
    PolarGradient polar;
    polar.stretch.diagonal = (ds * ds + dt * dt + Vec3(area)) * inverse + n * n * along;
    const auto mixed = [&](int i, int j) { return (ds[i] * ds[j] + dt[i] * dt[j]) * inverse + n[i] * n[j] * along; };
    polar.stretch.offDiagonal = {mixed(0, 1), mixed(0, 2), mixed(1, 2)};
    const Vec3 rotated = ds + glm::cross(dt, n) * hand;
    const float length = std::sqrt(glm::dot(rotated, rotated));
    const float scale = length > 0 ? 1 / length : 0.0F;
    polar.tangent = {length > 0 ? rotated.x * scale : 1.0F, rotated.y * scale, rotated.z * scale, hand};
    return polar;
}

} // namespace taut
