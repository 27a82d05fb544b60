#pragma once
/// How the surface gradient is interpolated within a triangle: what is stored at its corners, and how the left stretch tensor V of
/// A = V R is had back at a point. Tensors are in the space of the deformed surface (render space in the renderer).
///
/// The 3x3 tensors carry sqrt(det A) along the normal (stretch.h), so that at rest and under rigid motion and uniform scaling
/// every scheme gives back exactly what it was given, whatever the normals of the corners do. All but DsDt are independent of the
/// rest tangent field; DsDt is the linear interpolation of the pair of vectors, which loses length where the corners' rest
/// frames disagree (docs/decisions.md, "V is interpolated, not ds and dt").

#include "taut/deform/stretch.h"

namespace taut {

enum class GradientInterpolation {
    Stretch,      ///< V itself: the square root of S = A A^T
    DsDt,         ///< the vectors ds and dt
    Cholesky,     ///< L of S = L L^T
    LogEuclidean, ///< log V (Arsigny et al. 2006)
    Face,         ///< constant: the mean of the corners' V
};

/// Singular values of A below this much of the greater one are held there by LogEuclidean.
inline constexpr float kLeastLogStretch = 1e-6F;

/// L of the Cholesky factorisation of V V, stored as diagonal and (l10, l20, l21). Rows of a collapsed tensor are zero.
inline SymmetricTensor choleskyOf(const SymmetricTensor &v) {
    const Vec3 x = v.times({1, 0, 0});
    const Vec3 y = v.times({0, 1, 0});
    const Vec3 z = v.times({0, 0, 1});
    SymmetricTensor l;
    l.diagonal.x = glm::length(x);
    const Vec3 e0 = l.diagonal.x > 0 ? x / l.diagonal.x : Vec3(0); // Gram-Schmidt on the rows of V
    l.offDiagonal.x = glm::dot(e0, y);
    l.offDiagonal.y = glm::dot(e0, z);
    // What rounding leaves of a row that depends on the first has no direction of its own.
    const auto rest = [&](const Vec3 &row, float along) {
        const Vec3 r = row - e0 * along;
        return glm::dot(r, r) > 1e-12F * glm::dot(row, row) ? r : Vec3(0);
    };
    const Vec3 y1 = rest(y, l.offDiagonal.x);
    const Vec3 z1 = rest(z, l.offDiagonal.y);
    l.diagonal.y = glm::length(y1);
    const Vec3 e1 = l.diagonal.y > 0 ? y1 / l.diagonal.y : Vec3(0);
    l.offDiagonal.z = glm::dot(e1, z1);
    l.diagonal.z = glm::length(z1 - e1 * l.offDiagonal.z);
    return l;
}

/// A function f of the symmetric 2x2 [x y; y z] by its eigenvalues: f(l) on both, as (xx, xy, yy).
template <class F> Vec3 functionOf(const Vec3 &t, const F &f) {
    const float mean = 0.5F * (t.x + t.z);
    const float half = 0.5F * (t.x - t.z);
    const float radius = std::hypot(half, t.y);
    const float upper = f(mean + radius);
    const float lower = f(mean - radius);
    const float a = 0.5F * (upper + lower);
    const float b = radius > 0 ? 0.5F * (upper - lower) / radius : 0.0F;
    return {a + b * half, b * t.y, a - b * half};
}

/// The tensor seen in two directions: (s.Ts, s.Tt, t.Tt).
inline Vec3 seenIn(const SymmetricTensor &tensor, const Vec3 &s, const Vec3 &t) {
    const Vec3 ts = tensor.times(s);
    return {glm::dot(s, ts), glm::dot(t, ts), glm::dot(t, tensor.times(t))};
}

/// A tensor with the components of `t` on two unit tangents of a surface and `along` on its normal.
inline SymmetricTensor tensorFrom(const Vec3 &components, const Vec3 &s, const Vec3 &t, const Vec3 &n, float along) {
    SymmetricTensor out;
    out.diagonal = s * s * components.x + 2.0F * s * t * components.y + t * t * components.z + n * n * along;
    const auto mixed = [&](int i, int j) {
        return s[i] * s[j] * components.x + (s[i] * t[j] + t[i] * s[j]) * components.y + t[i] * t[j] * components.z + n[i] * n[j] * along;
    };
    out.offDiagonal = {mixed(0, 1), mixed(0, 2), mixed(1, 2)};
    return out;
}

/// What a corner stores under a scheme, from its V; s, t, n are any orthonormal frame with the surface's normal.
inline SymmetricTensor encodeStretch(GradientInterpolation scheme, const SymmetricTensor &v, const Vec3 &s, const Vec3 &t, const Vec3 &n) {
    if (scheme == GradientInterpolation::Cholesky) return choleskyOf(v);
    if (scheme != GradientInterpolation::LogEuclidean) return v;
    const Vec3 inPlane = seenIn(v, s, t);
    const float greatest = std::fmax(inPlane.x + inPlane.z, 1e-30F);
    const auto logOf = [&](float x) { return std::log(std::fmax(x, kLeastLogStretch * greatest)); };
    return tensorFrom(functionOf(inPlane, logOf), s, t, n, logOf(glm::dot(n, v.times(n))));
}

/// V in the frame (s, t) of a point from the interpolated tensor of a scheme, as (ss, st, tt). Not for DsDt.
inline Vec3 decodeStretch(GradientInterpolation scheme, const SymmetricTensor &tensor, const Vec3 &s, const Vec3 &t) {
    switch (scheme) {
    case GradientInterpolation::Cholesky: {
        // S seen in the frame, and its square root (S + sqrt(det) I) / sqrt(trace + 2 sqrt(det)).
        const auto transposedTimes = [&](const Vec3 &w) {
            const Vec3 &d = tensor.diagonal;
            const Vec3 &o = tensor.offDiagonal;
            return Vec3(d.x * w.x + o.x * w.y + o.y * w.z, d.y * w.y + o.z * w.z, d.z * w.z);
        };
        const Vec3 a = transposedTimes(s);
        const Vec3 b = transposedTimes(t);
        const Vec3 squared(glm::dot(a, a), glm::dot(a, b), glm::dot(b, b));
        const float area = glm::length(glm::cross(a, b));
        const float root = std::sqrt(squared.x + squared.z + 2 * area);
        if (!(root > 0)) return Vec3(0);
        return Vec3(squared.x + area, squared.y, squared.z + area) / root;
    }
    case GradientInterpolation::LogEuclidean: return functionOf(seenIn(tensor, s, t), [](float x) { return std::exp(x); });
    default: return seenIn(tensor, s, t);
    }
}

/// V and the rotated tangent R t0 of A = V R in the frame (s, t), from the interpolated ds and dt projected into it.
struct PlanarPolar {
    Vec3 stretch{1, 0, 1}; ///< (ss, st, tt)
    Vec2 tangent{1, 0};
};
inline PlanarPolar polarInFrame(const Vec2 &ds, const Vec2 &dt) {
    const float det = ds.x * dt.y - ds.y * dt.x;
    const float hand = det < 0 ? -1.0F : 1.0F;
    const float area = std::fabs(det);
    const float tau = std::sqrt(glm::dot(ds, ds) + glm::dot(dt, dt) + 2 * area);
    PlanarPolar polar;
    if (!(tau > 0)) return {Vec3(0), {1, 0}};
    polar.stretch = Vec3(ds.x * ds.x + dt.x * dt.x + area, ds.x * ds.y + dt.x * dt.y, ds.y * ds.y + dt.y * dt.y + area) / tau;
    const Vec2 rotated = ds + hand * Vec2(dt.y, -dt.x);
    const float length = glm::length(rotated);
    polar.tangent = length > 0 ? rotated / length : Vec2(1, 0);
    return polar;
}

} // namespace taut
