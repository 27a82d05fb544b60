#pragma once
/// Splits polygons into triangles, once, on the rest shape: a quad along the diagonal that leaves two convex halves (the
/// shorter one where both do), larger polygons by clipping ears in the plane of their Newell normal, the largest first, in n log n.

#include "taut/base/vec.h"

#include <span>
#include <vector>

namespace taut {

/// Appends triangles of one polygon as corner numbers 0..n-1. `points` are its corners in order; n - 2 triangles are made.
void triangulate(std::span<const Vec3> points, std::vector<Index3> &triangles);

/// Newell's normal of a polygon: twice its vector area (not normalised; zero for a degenerate polygon).
Vec3 polygonNormal(std::span<const Vec3> points);

} // namespace taut
