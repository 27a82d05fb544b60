#pragma once
/// The simplest gradient: constant per triangle, from its rest and its deformed edges.

#include "taut/deform/stretch.h"
#include "taut/deform/surface.h"

#include <span>

namespace taut {

/// The inverse of the rest metric of every triangle, (xx, xy, yy) of [e1 e2]^T [e1 e2] with its edges from the first corner; zero
/// for a triangle without area. `restPositions` are those of the render vertices, in rest space.
std::vector<Vec3> restMetrics(const Surface &surface, std::span<const Vec3> restPositions);

/// V of every triangle: S = E G0^-1 E^T with deformed edges E, its square root in the triangle's plane and sqrt(det) along its
/// normal, as in polarGradient(). The identity for a triangle without rest area (policy SkipDegenerateFace).
void faceStretches(const Surface &surface, std::span<const Vec3> metrics, std::span<const Vec3> positions,
                   std::vector<SymmetricTensor> &out);

} // namespace taut
