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
inline float squareOf(const Vec3 &symmetric) {
    return symmetric.x * symmetric.x + 2 * symmetric.y * symmetric.y + symmetric.z * symmetric.z;
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
/// `edgeTo`: from the deformed vertex to a deformed position.
template <class Edge> RingStretch ringStretch(const Surface &surface, std::size_t s, const Edge &edgeTo) {
    Vec3 mean(0); // less the identity, so that rigid faces leave no rounding behind
    float square = 0;
    for (Index k = surface.ringOffsets[s]; k < surface.ringOffsets[s + 1]; ++k) {
        const RingFace &face = surface.ringFaces[k];
        const Vec3 a = edgeTo(face.positions[0]);
        const Vec3 b = edgeTo(face.positions[1]);
        const Vec4 &e = face.fromEdges;
        const Vec3 u = rightStretch(a * e.x + b * e.y, a * e.z + b * e.w) - Vec3(1, 0, 1);
        mean += u * face.share;
        square += std::fmin(squareOf(u), kMostSquare) * face.share;
    }
    return {mean + Vec3(1, 0, 1), std::sqrt(std::fmax(0.0F, square - squareOf(mean))), std::sqrt(square)};
}

/// Stretches that differ by less than this (relative) are one: no bits change for it.
inline constexpr float kSameStretch = 1e-4F;
/// What the mean of the faces' stretches may be off by on a ring that is curved at rest: so many times its tilt times its strain.
inline constexpr float kTiltError = 16;

/// Tangents f1, f2 of the unit normal, from a fit, keep their stretch unless it differs from the faces' mean by more than that may be
/// off itself: by what the faces differ among themselves, and by their strain where they do not lie in one plane at rest. Then it is a
/// fold, and f1 and f2 keep their rotation alone.
inline void unfold(const RingStretch &ring, float tilt, const Vec3 &normal, Vec3 &f1, Vec3 &f2) {
    const Vec3 g1 = f1 - normal * glm::dot(normal, f1); // what has collapsed may stand on its normal
    const Vec3 g2 = f2 - normal * glm::dot(normal, f2);
    const Vec3 own = rightStretch(g1, g2);
    const float difference = std::sqrt(squareOf(own - ring.mean));
    if (!(difference > kSameStretch * std::sqrt(squareOf(ring.mean)))) return;
    const float doubt = ring.unequal + kTiltError * tilt * ring.strain;
    if (!(difference > doubt)) return;
    const float t = std::fmin(difference / std::fmax(doubt, std::numeric_limits<float>::min()) - 1, 1.0F);
    const float weight = t * t * (3 - 2 * t); // no jump: all of it at twice the doubt
    const Vec3 u = own + (ring.mean - own) * weight;
    const Vec3 rotated = g1 + glm::cross(g2, normal); // R e1 of the polar decomposition
    const float length = glm::length(rotated);
    const Vec3 r1 = length > 0 ? rotated / length : quickFrameFromNormal(normal).s;
    const Vec3 r2 = glm::cross(normal, r1);
    f1 = r1 * u.x + r2 * u.y;
    f2 = r1 * u.y + r2 * u.z;
}

} // namespace taut
