#pragma once
/// How far a surface is stretched at a vertex, from the faces around it one by one, where a fit over all of them goes wrong: at folds.
///
/// A mean of gradients gets shorter where the faces turn against each other: by cos(45 degrees) on the ridge of a right angle, to
/// nothing where a sheet is folded flat. That is no stretch. The mean of the faces' own stretches knows lengths within faces alone, so
/// that no isometric motion changes it. Under smooth maps both are of second order, but for a linear map of a curved ring the mean of
/// gradients is exact. docs/decisions.md, "Folds are no stretch".

#include "taut/base/frame.h"
#include "taut/deform/surface.h"

#include <limits>

namespace taut {

/// U of A = R U, of the map whose columns u and w are images of two orthonormal tangents, as (xx, xy, yy):
/// U = (C + sqrt(det C) I) / sqrt(tr C + 2 sqrt(det C)) with C = A^T A. Zero for a map to nothing.
inline Vec3 rightStretch(const Vec3 &u, const Vec3 &w) {
    const Vec3 across = glm::cross(u, w);
    const float area = std::sqrt(glm::dot(across, across));
    const Vec3 c(glm::dot(u, u) + area, glm::dot(u, w), glm::dot(w, w) + area);
    const float tau = std::sqrt(c.x + c.z);
    return c * (tau > 0 ? 1 / tau : 0.0F);
}
/// A^T A of the same map.
inline Vec3 metricOf(const Vec3 &u, const Vec3 &w) {
    return {glm::dot(u, u), glm::dot(u, w), glm::dot(w, w)};
}
inline float squareOf(const Vec3 &symmetric) {
    return symmetric.x * symmetric.x + 2 * symmetric.y * symmetric.y + symmetric.z * symmetric.z;
}

/// Calls f(u, w, share) with the images of e1 and e2 in each face around a surface vertex. `edgeTo`: from the deformed vertex to a
/// deformed position.
template <class Edge, class F> void forEachRingFace(const Surface &surface, std::size_t s, const Edge &edgeTo, const F &f) {
    for (Index k = surface.ringOffsets[s]; k < surface.ringOffsets[s + 1]; ++k) {
        const RingFace &face = surface.ringFaces[k];
        const Vec3 a = edgeTo(face.positions[0]);
        const Vec3 b = edgeTo(face.positions[1]);
        const Vec4 &e = face.fromEdges;
        f(a * e.x + b * e.y, a * e.z + b * e.w, face.share);
    }
}

/// How far the faces around a surface vertex are stretched, each in its own plane, whatever bends or folds between them.
struct RingStretch {
    Vec3 mean{0};      ///< of U in (e1, e2), as (xx, xy, yy)
    float unequal = 0; ///< root mean square of what the faces' U differ from it
    float strain = 0;  ///< ... from that of a rigid face
};
/// A face counts no more in the squares: a sliver that opens by any factor must not hide a fold beside it. Its part of the mean is in
/// proportion to its area.
inline constexpr float kMostSquare = 16;
template <class Edge> RingStretch ringStretch(const Surface &surface, std::size_t s, const Edge &edgeTo) {
    Vec3 mean(0); // less the identity, so that rigid faces leave no rounding behind
    float square = 0;
    forEachRingFace(surface, s, edgeTo, [&](const Vec3 &u, const Vec3 &w, float share) {
        const Vec3 strain = rightStretch(u, w) - Vec3(1, 0, 1);
        const float own = squareOf(strain);
        mean += strain * share;
        square += (own < kMostSquare ? own : kMostSquare) * share;
    });
    return {mean + Vec3(1, 0, 1), std::sqrt(std::fmax(0.0F, square - squareOf(mean))), std::sqrt(square)};
}

/// Stretches that differ by less than this (relative) are one: no bits change for it.
inline constexpr float kSameStretch = 1e-4F;
/// What the mean of the faces' stretches may be off by on a ring that is curved at rest: so many times its tilt times its strain.
inline constexpr float kTiltError = 16;

/// How far a stretch found in another way than from the faces is to give way to their mean, 0 to 1: not at all unless the two differ by
/// more than that mean may be off itself, which is what the faces differ among themselves, and their strain where they do not lie in
/// one plane at rest; altogether from twice that on, so that nothing jumps.
inline float foldWeight(const RingStretch &ring, float tilt, const Vec3 &own) {
    const float difference = std::sqrt(squareOf(own - ring.mean));
    if (!(difference > kSameStretch * std::sqrt(squareOf(ring.mean)))) return 0;
    const float doubt = ring.unequal + kTiltError * tilt * ring.strain;
    if (!(difference > doubt)) return 0;
    const float t = std::fmin(difference / std::fmax(doubt, std::numeric_limits<float>::min()) - 1, 1.0F);
    return t * t * (3 - 2 * t);
}

/// At a fold, tangents f1, f2 of the unit normal that come from a fit get the stretch of the faces and keep their rotation alone.
template <class Edge> void unfold(const Surface &surface, std::size_t s, const Edge &edgeTo, const Vec3 &normal, Vec3 &f1, Vec3 &f2) {
    // Without a fold the faces' mean metric is the fit's, which costs no roots.
    Vec3 metric(0);
    forEachRingFace(surface, s, edgeTo, [&](const Vec3 &u, const Vec3 &w, float share) { metric += metricOf(u, w) * share; });
    if (!(squareOf(metric - metricOf(f1, f2)) > sqr(2 * kSameStretch) * squareOf(metric))) return;
    const RingStretch ring = ringStretch(surface, s, edgeTo);
    const Vec3 g1 = f1 - normal * glm::dot(normal, f1); // what has collapsed may stand on its normal
    const Vec3 g2 = f2 - normal * glm::dot(normal, f2);
    const Vec3 own = rightStretch(g1, g2);
    const float weight = foldWeight(ring, surface.ringTilts[s], own);
    if (!(weight > 0)) return;
    const Vec3 u = own + (ring.mean - own) * weight;
    const Vec3 rotated = g1 + glm::cross(g2, normal); // R e1 of the polar decomposition
    const float length = glm::length(rotated);
    const Vec3 r1 = length > 0 ? rotated / length : quickFrameFromNormal(normal).s;
    const Vec3 r2 = glm::cross(normal, r1);
    f1 = r1 * u.x + r2 * u.y;
    f2 = r1 * u.y + r2 * u.z;
}

} // namespace taut
