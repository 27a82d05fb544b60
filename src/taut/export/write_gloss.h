#pragma once
/// Writers of GlossMesh, one frame a file. Each writes beside its path and renames (OutputFile), in blocks: no file is held in
/// memory as a whole. What every name means, and its unit, is in docs/export.md. All throw RunError where writing fails.

#include "taut/export/gloss_mesh.h"

namespace taut {

/// One vertex element with the columns of vertexColumns() as floats, one face element of triangles with `int material`.
void writeGlossPly(const std::string &path, const GlossMesh &mesh, bool ascii);

/// A header line with the names of vertexColumns(), then one line a vertex. No faces.
void writeGlossCsv(const std::string &path, const GlossMesh &mesh);

/// numpy arrays, stored uncompressed: P, N, st, tangent, bitangent, tangent_sign, Pref, M (n x 5: a b d p q), ds, dt, ..., phi
/// (all float32), faces and face_material (int32).
void writeGlossNpz(const std::string &path, const GlossMesh &mesh);

/// A .glb, or a .gltf with its .bin beside it: one mesh of each GlossMesh, a primitive for each of its materials. World space
/// is turned to glTF's y up by the root node, so every number in the file is as in the other formats.
/// `means`: meanGloss() of each mesh. Returns how many materials lay outside KHR_materials_anisotropy's limits.
std::size_t writeGlossGltf(const std::string &path, std::span<const GlossMesh> meshes, std::span<const std::vector<MeanGloss>> means);

} // namespace taut
