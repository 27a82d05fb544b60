#pragma once
/// Tangents as the maps of normals are baked for: MikkTSpace (Mikkelsen 2008, "Simulation of Wrinkled Surfaces Revisited", 2.4), which glTF
/// asks for where a file has none.
///
/// Triangles of one UV orientation that hang together around a vertex, by edges that agree in position, normal and UV, make a group with
/// one tangent: the mean of their dP/du, each made perpendicular to the vertex's normal and unit, weighted by the triangle's angle there.
/// Quads are split along the diagonal that is shorter in UV space; larger polygons as triangulate() does.

#include "taut/mesh/mesh.h"

#include <span>

namespace taut {

struct TangentSpace {
    std::vector<Vec4> tangents; ///< [groups] unit, perpendicular to the normal; w = 1 or -1: bitangent = w cross(normal, tangent)
    std::vector<Index> corners; ///< [corners] -> group; kNone where there is none to be had (no UVs, or degenerate all around)
};

/// `positions` [mesh.positions] and `normals` [corners], unit, of one space, which the tangents are in.
TangentSpace tangentSpace(const Mesh &mesh, std::span<const Vec3> positions, std::span<const Vec3> normals);

} // namespace taut
