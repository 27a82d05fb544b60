#pragma once
/// What stands in front of OpenMesh's readers. OpenMesh 9 takes its input on trust: it believes counts and indices, reads
/// rubbish as zeros, and misreads valid files without a word: PLY headers with obj_info lines, PLY faces with properties
/// before vertex_indices, the normals and uvs of OFF files that come from a stream, STL solids whose name holds "outer".
/// So a guard reads the whole file strictly, is what names the line and column or the byte of a mistake, and hands
/// OpenMesh the checked content in the dialect that OpenMesh reads right: binary little-endian PLY or STL, header and all.

#include "taut/base/error.h"
#include "taut/base/vec.h"

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace taut {

/// A checked file, written anew for OpenMesh.
struct CheckedFile {
    std::string bytes;
    std::size_t faces = 0; ///< in the file, degenerate ones included
    bool hasNormals = false;
    bool hasUvs = false;
    std::vector<Vec3> storedM{}; ///< [vertices] of a .ply of `taut export`, with its tangents; else empty
    std::vector<Vec4> tangents{};
};

/// Each throws InputError at the first mistake. `warnings`: what is left over after the last element.
CheckedFile checkPly(std::string_view bytes, const std::string &path, Warnings &warnings);
CheckedFile checkOff(std::string_view bytes, const std::string &path, Warnings &warnings);
CheckedFile checkStl(std::string_view bytes, const std::string &path, Warnings &warnings);

} // namespace taut
