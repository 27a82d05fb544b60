#pragma once
/// One function a format, each from the bytes of a file to a mesh that readMesh still has to tidy up (normals of unit
/// length, no degenerate faces). `path` is for errors only.

#include "taut/base/error.h"
#include "taut/mesh/mesh.h"

#include <string>
#include <string_view>

namespace taut {

Mesh readObj(std::string_view bytes, const std::string &path);

/// PLY, OFF and STL: checked by mesh_guard.h, then parsed by OpenMesh.
Mesh readPly(std::string_view bytes, const std::string &path, Warnings &warnings);
Mesh readOff(std::string_view bytes, const std::string &path, Warnings &warnings);
Mesh readStl(std::string_view bytes, const std::string &path, Warnings &warnings);

/// Removes the faces with fewer than three distinct positions, with a warning that says how many (`what` names the file
/// or the part of it).
void dropDegenerateFaces(Mesh &mesh, const std::string &what, Warnings &warnings);

/// Gives normals unit length. A corner whose normal is zero loses it (kNone).
void normaliseNormals(Mesh &mesh);

} // namespace taut
