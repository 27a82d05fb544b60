#pragma once
/// Explicit micro-geometry: a heightfield of real facets whose normals follow GGX with alpha = 1, to be deformed like any mesh and
/// counted. It shows without a formula what M does to a distribution of normals.
///
/// Counted by projected area, the unit normals (n.x, n.y) of GGX with alpha = 1 fill the unit disk evenly: D n.z = n.z / pi per solid
/// angle. The heightfield does that pit by pit. A round patch of the plane is cut into triangles, each raised or sunk as the
/// pyramid-like roof whose level lines are scaled copies of the triangle about its incentre. In a roof,
///     the area inside the level line of scale t is t^2 of the triangle, and
///     the slope is that of the profile over the inradius, the same on all three sides,
/// so a profile of K steps of equal area with slopes sqrt(u / (1 - u)), u drawn from each of K strata, has |n.xy|^2 = u: even in area.
/// The azimuths are those of the triangles' edges; concentric strips of triangles between regular polygons, each turned at random, spread
/// them evenly too. All roofs stand on height 0, so the heightfield is continuous. Ogaki 2023 counts normals the same way.

#include "taut/deform/deformer.h"
#include "taut/mesh/mesh.h"
#include "taut/microsurface/transform.h"

#include <span>

namespace taut {

/// A round patch of radius 1 in the plane z = 0 (mean height 0), facing +z, of `facets` triangles or a few more; positions only.
Mesh makeGgxHeightfield(std::size_t facets, std::uint32_t seed);

/// Moves every position through the deformers in order.
void deformPositions(Mesh &mesh, std::span<const Deformer> deformers);

/// The deformers (stretch and shears) whose Jacobian is [a b p; 0 d q; 0 0 1].
std::vector<Deformer> deformersOf(const MicroTransform &m);

/// Share of the macro-surface's area below the facets of each direction: bins x bins cells over the square (n.x, n.y) in [-1, 1]^2,
/// x fastest, from n.y = -1. Normals that face down (an overhang) are left out. Sums to 1 for a heightfield.
struct NormalHistogram {
    int bins = 0;
    std::vector<double> share;
};

/// Counts the triangles of a mesh by projected area.
NormalHistogram countNormals(const Mesh &mesh, int bins);

/// The histogram that M predicts: D_M n.z in closed form, each cell by quadrature.
NormalHistogram expectedNormals(const MicroTransform &m, int bins);

/// Half the sum of absolute differences: 0 for equal histograms, 1 for disjoint ones.
double totalVariation(const NormalHistogram &a, const NormalHistogram &b);

/// The histogram as the talk draws it: density on the disk, counted to the left, D_M n.z to the right, rows from the top.
struct NormalImage {
    int width = 0, height = 0; ///< 2 size, size
    float scale = 1;           ///< of densities; the greatest expected one becomes 0.6
    std::vector<float> rgb;    ///< interleaved, linear
};
NormalImage paintNormals(const Mesh &mesh, const MicroTransform &m, int size);

} // namespace taut
