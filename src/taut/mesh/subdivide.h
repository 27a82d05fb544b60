#pragma once
/// Subdivision surfaces by uniform refinement (OpenSubdiv's Far): Catmull-Clark and Loop, with creases and corners. Topology
/// once, positions every frame.
///
/// The refined vertices are put on the limit surface (Halstead, Kass & DeRose 1993), so a level changes how finely the
/// surface is tessellated, never where it lies; their limit tangents give its exact derivatives there. All of it is linear in
/// the cage's positions and held as sparse rows.

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

enum class SubdivisionScheme { CatmullClark, Loop };
enum class SubdivisionBoundary {
    EdgeAndCorner, ///< boundaries are cubic B-spline curves through corners with one face
    EdgeOnly,      ///< boundaries are cubic B-spline curves, round at corners too
};

struct SubdivisionOptions {
    int level = 0; ///< 0 to kReferenceLevel
    SubdivisionScheme scheme = SubdivisionScheme::CatmullClark;
    SubdivisionBoundary boundary = SubdivisionBoundary::EdgeAndCorner;
    float creaseAngle = kPi; ///< radians: edges whose faces turn by more than this are infinitely sharp, beside the mesh's own
};

/// Weights of two limit tangents, counter-clockwise from outside, their lengths as they come: sparse rows, one a normal of the
/// refined mesh. Empty rows where there is no tangent plane: at non-manifold vertices, on the tip of a cone, where the cage has
/// collapsed.
struct TangentTable {
    std::vector<Index> offsets{0}; ///< [normals + 1]
    std::vector<Index> indices;    ///< into the control points
    std::vector<Vec2> weights;     ///< a row sums to (0, 0)
};

struct Subdivision {
    Mesh mesh;              ///< refined faces with limit positions, normals, uvs and materials; no file tangents
    StencilTable positions; ///< limit positions from the cage's positions: one row a vertex of `mesh`
    TangentTable tangents;  ///< empty at level 0
};

/// The finest level that scene files and plans may ask for.
inline constexpr int kMaxSubdivisionLevel = 5;
/// The finest that there is: what the error of the other is measured against.
inline constexpr int kReferenceLevel = kMaxSubdivisionLevel + 1;

/// Bytes that subdivide() takes at most while it works, before it is asked; 0 at level 0. Quadratic in the corners of a face and the faces
/// around a vertex, for so are the rows.
double subdivisionBytes(const Mesh &cage, int level);

/// Refines `cage` uniformly. Non-manifold edges and vertices are kept as infinitely sharp features. A crease or corner sharper
/// than `level` counts as infinitely sharp from there on. UVs are refined face-varying, their island boundaries smoothly but for
/// corners, where every corner has one; else they are left out. Normals are the limit surface's, one a smooth vertex, one for
/// each side of a crease.
/// A corner that repeats its neighbour's position is left out, and a face with fewer than three corners left.
/// Morphs and the skin stay with the cage: it is deformed first, then put through the stencils. File normals and tangents
/// are dropped. Level 0 returns the cage as it is, with identity rows (no limit projection).
/// Throws InputError naming the mesh where the level is out of range, the refined mesh would be too large, Loop meets a face that
/// is no triangle, or OpenSubdiv rejects the topology (a face that comes back to one of its positions).
Subdivision subdivide(const Mesh &cage, const SubdivisionOptions &options);

} // namespace taut
