#pragma once
/// Writes a mesh as OBJ: what the mesh generators and the tests use.

#include "taut/mesh/mesh.h"

#include <string>

namespace taut {

/// Positions, uvs and normals per corner, polygons, and the materials' names. Nine digits, so that every float comes back
/// as it was. Tangents, morphs and skin weights have no place in an OBJ. Throws RunError where the file cannot be written;
/// an existing file is replaced whole or not at all.
void writeObj(const Mesh &mesh, const std::string &path);

} // namespace taut
