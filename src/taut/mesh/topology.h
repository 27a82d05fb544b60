#pragma once
/// How the faces of a mesh hang together: what a modeller asks of a mesh before it is rendered, subdivided or exported.

#include "taut/mesh/mesh.h"

namespace taut {

struct Topology {
    std::size_t components = 0;    ///< sets of faces joined by edges
    std::size_t boundaryLoops = 0; ///< of edges with one face; loops that touch are one; 0: the mesh is closed
    std::size_t complexEdges = 0;  ///< edges of more than two faces
};

/// Takes polygons of any size and orientation: non-manifold edges and vertices, one-sided surfaces. A corner that repeats its
/// neighbour's position is left out, and a face with fewer than three corners left. `weld`: positions that coincide and move
/// alike are one (weld.h).
Topology topologyOf(const Mesh &mesh, bool weld);

/// The points among `positions`, places of the mesh's own positions, that a face has: others are never seen.
std::vector<Vec3> pointsOfFaces(const Mesh &mesh, const std::vector<Vec3> &positions);

} // namespace taut
