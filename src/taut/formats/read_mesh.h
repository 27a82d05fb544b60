#pragma once
/// Readers of single meshes: OBJ, PLY (ASCII and binary), OFF and STL (ASCII and binary).
///
/// Each format is read once, strictly: header, counts against the file's length, list sizes, indices; a mistake is named with
/// its line and column or its byte. Polygons of any size, non-manifold edges and isolated vertices survive.
///
/// Text may begin with a byte order mark, and its lines end in LF, CR LF or CR. What a file holds and a mesh does not is named in one
/// warning: keywords of OBJ, properties and elements of PLY, bytes behind the end.
///
/// Names: a position that no face uses is kept. A face with fewer than three distinct corners is dropped with a warning.
/// Not finite positions are errors; normals and texture coordinates that are not finite count as missing, with a warning. STL, which is a
/// soup of triangles, is welded by exact position.

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
