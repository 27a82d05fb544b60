#pragma once
/// One function a format, each from the bytes of a file to a mesh that readMesh still has to tidy up (normals of unit
/// length, no degenerate faces). `path` is for errors only.

#include "taut/base/error.h"
#include "taut/mesh/mesh.h"

#include <cstdint>
#include <string>
#include <string_view>

namespace taut {

/// `warnings`: what the file holds and the mesh does not.
Mesh readObj(std::string_view bytes, const std::string &path, Warnings &warnings);
Mesh readPly(std::string_view bytes, const std::string &path, Warnings &warnings);
Mesh readOff(std::string_view bytes, const std::string &path, Warnings &warnings);
Mesh readStl(std::string_view bytes, const std::string &path, Warnings &warnings);

/// What PLY and OFF check alike: "found a face of 2 corners, expected at least 3 corners" and the like.
void checkCornerCount(std::int64_t corners, const Location &where);
/// `index` as one of `vertices`.
Index checkedVertex(std::int64_t index, std::size_t vertices, const Location &where);
/// Fails unless `count` elements of at least `bytesEach` bytes fit into `bytesLeft`.
void checkCount(std::int64_t count, std::size_t bytesEach, std::size_t bytesLeft, const std::string &what, const Location &where);

/// Removes the faces with fewer than three distinct positions, with a warning that says how many (`what` names the file
/// or the part of it).
void dropDegenerateFaces(Mesh &mesh, const std::string &what, Warnings &warnings);

/// Normals and texture coordinates that are not finite count as missing: their corners become kNone, with a warning that counts them
/// (`what` as above). An attribute that no corner has any more is left out.
void dropNotFinite(Mesh &mesh, const std::string &what, Warnings &warnings);

/// Gives normals unit length. A corner whose normal is zero loses it (kNone).
void normaliseNormals(Mesh &mesh);

} // namespace taut
