#pragma once
/// Readers of single meshes: OBJ, PLY (ASCII and binary), OFF and STL (ASCII and binary).
///
/// PLY, OFF and STL are parsed by OpenMesh, through an importer that fills our own structure, so polygons of any size and
/// non-manifold meshes survive; a guard in front checks what OpenMesh takes on trust (header, counts against the file's
/// length, list sizes), is what names the line or byte of a malformed file, and hands on what it has checked in the
/// dialect that OpenMesh reads right (mesh_guard.h). OBJ is read here: OpenMesh's OBJ reader keeps no normal per corner and
/// reports no position.
///
/// Names: a position that no face uses is kept. A face with fewer than three distinct corners is dropped with a warning.
/// Not finite coordinates are errors. STL, which is a soup of triangles, is welded by exact position.

#include "taut/base/error.h"
#include "taut/mesh/mesh.h"

#include <string>

namespace taut {

/// Reads `path` by its extension (any case). Throws InputError (file:line:column or byte offset) where the file is
/// missing, malformed or holds no face.
Mesh readMesh(const std::string &path, Warnings &warnings);

/// True where readMesh knows the extension of `path`.
bool isMeshPath(const std::string &path);

/// Reads only the positions of `path` (a later frame of a sequence) and checks that its topology is that of `first`:
/// the same number of positions and the same faces. Throws InputError otherwise.
std::vector<Vec3> readSequencePositions(const std::string &path, const Mesh &first);

} // namespace taut
