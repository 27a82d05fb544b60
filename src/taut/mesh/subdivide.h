#pragma once
/// Catmull-Clark surfaces by uniform refinement (OpenSubdiv's Far): topology once, positions every frame.
///
/// The refined vertices are put on the limit surface (Halstead, Kass & DeRose 1993), so a level changes how finely the
/// surface is tessellated, never where it lies. All of it is linear in the cage's positions and held as sparse rows.

#include "taut/mesh/mesh.h"

#include <vector>

namespace taut {

/// Sparse rows: out[i] = sum over k in [offsets[i], offsets[i + 1]) of weights[k] * in[indices[k]].
struct StencilTable {
    std::vector<Index> offsets{0}; ///< [rows + 1]
    std::vector<Index> indices;    ///< into the control points
    std::vector<float> weights;    ///< a row of positions sums to 1
    [[nodiscard]] std::size_t rowCount() const { return offsets.size() - 1; }
};

/// Evaluates every row, in parallel; allocates only where `out` has another size than the table has rows. `in` holds all
/// control points and is not `out`. The same input gives the same bits for any number of threads.
void applyStencils(const StencilTable &stencils, const std::vector<Vec3> &in, std::vector<Vec3> &out);

struct Subdivision {
    Mesh mesh;              ///< refined quads with their limit positions, limit uvs and materials; no normals or tangents
    StencilTable positions; ///< limit positions from the cage's positions: one row a vertex of `mesh`
};

inline constexpr int kMaxSubdivisionLevel = 5;

/// Refines `cage` `level` times, 0 to kMaxSubdivisionLevel. Boundary edges become B-spline curves and boundary corners (one
/// face) are interpolated. Non-manifold edges and vertices are kept as infinitely sharp features. UVs are refined
/// face-varying, their island boundaries smoothly but for corners, where every corner has one; else they are left out.
/// A corner that repeats its neighbour's position is left out, and a face with fewer than three corners left.
/// Morphs and the skin stay with the cage: it is deformed first, then put through the stencils. File normals and tangents
/// are dropped, the limit surface is smooth. Level 0 returns the cage as it is, with identity rows (no limit projection).
/// Throws RunError naming the mesh where the level is out of range, the refined mesh would be too large, or OpenSubdiv
/// rejects the topology (a face that comes back to one of its positions).
Subdivision subdivide(const Mesh &cage, int level);

} // namespace taut
