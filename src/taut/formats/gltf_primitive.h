#pragma once
/// One primitive of a glTF mesh: its vertices and its triangles. glTF 2.0, section 3.7. Included by the glTF reader only.

#include "taut/formats/gltf_accessors.h"

namespace taut {

/// The only modes of glTF's 0 to 6 that make triangles.
inline constexpr long long kGltfTriangles = 4;
inline constexpr long long kGltfStrip = 5;
inline constexpr long long kGltfFan = 6;

/// One primitive while it is read.
struct GltfPrimitive {
    const GltfSource &source;
    GltfValue gltf;   ///< meshes[m].primitives[p]
    std::string name; ///< of its mesh
    Warnings &warnings;
    Tally &leftOut;
    GltfValue attributes = gltf["attributes"];
    long long mode = gltf["mode"].integer(kGltfTriangles);
};

/// The number of its vertices: the count of POSITION.
std::size_t gltfVertexCount(const GltfPrimitive &primitive);

/// The corners of its triangles, three each, into its vertices.
std::vector<Index> readGltfTriangles(const GltfPrimitive &primitive);

/// Those of its vertices that are `wanted`, increasing numbers, as a mesh without faces: arrays of one length, or empty where the
/// primitive lacks the attribute. With the names of the morph targets.
Mesh readGltfVertices(const GltfPrimitive &primitive, const std::vector<Index> &wanted, const std::vector<std::string> &targetNames);

} // namespace taut
