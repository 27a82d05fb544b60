#pragma once
/// Joining positions that a file keeps apart: glTF splits a position at every UV seam and hard edge.

#include "taut/mesh/mesh.h"

namespace taut {

/// [positions] -> the first position that coincides with it at rest, within 1e-9 of the mesh's size, and moves alike
/// (same skin row, same morph displacements). Without `weld` each stands for itself.
std::vector<Index> weldPositions(const Mesh &mesh, bool weld);

/// The mesh with its corners on welded positions; those left over stay, unused.
Mesh welded(const Mesh &mesh);

} // namespace taut
