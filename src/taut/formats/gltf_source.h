#pragma once
/// A glTF file taken apart: the container's chunks, the JSON, the buffers, and tinygltf's view of the JSON. Included by
/// the glTF reader only. Errors are made here, so that they all name the file and the JSON path.

#include "taut/base/error.h"
#include "taut/formats/gltf.h"

#include <nlohmann/json.hpp>
#include <tiny_gltf.h>

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace taut {

struct GltfSource {
    std::string path;
    nlohmann::json json;   ///< checked by checkGltfJson
    tinygltf::Model model; ///< without buffers and images: those are read here
    std::vector<std::vector<unsigned char>> buffers;
    std::size_t fileBytes = 0;            ///< of the file and its buffers
    mutable std::size_t decodedBytes = 0; ///< by accessors so far, against decodedBudget
    [[nodiscard]] std::size_t decodedBudget() const { return (std::size_t{1} << 30) + 64 * fileBytes; }
};

/// Throws InputError("PATH: WHERE: found FOUND, expected EXPECTED"); `where` is a JSON path such as meshes[0].name.
[[noreturn]] void failGltf(const std::string &path, std::string_view where, std::string_view found, std::string_view expected);

/// "name[index]", the JSON path of an element.
std::string jsonPath(std::string_view name, std::size_t index);

/// `index` as an Index; throws unless it is one of `count` elements called `what`.
Index checkedIndex(const GltfSource &source, std::string_view where, long long index, std::size_t count, std::string_view what);

/// A name of the file, else `kind` and its number ("mesh0").
std::string nameOr(const std::string &name, std::string_view kind, std::size_t number);

/// Opens and checks everything that lies before the meaning: container, JSON, extensions, buffers.
GltfSource openGltf(const std::string &path, Warnings &warnings);

/// What a URI stands for: the bytes of a data: URI, else of a file beside the .gltf.
std::vector<unsigned char> readUri(const std::string &gltfPath, const std::string &where, const std::string &uri);
/// The path of a URI that is not a data: URI, percent-decoded, beside the .gltf.
std::string pathOfUri(const std::string &gltfPath, const std::string &where, const std::string &uri);

/// Checks the types of all members that the reader and tinygltf look at, and the presence of the required ones: tinygltf
/// cuts integers to 32 bits and ignores members of another type. Unknown members are let through, as glTF wants.
void checkGltfJson(const std::string &path, const nlohmann::json &json);

// The parts, in the order in which they are read. Each takes what the earlier ones have put into `file`.
void readGltfMaterials(const GltfSource &source, GltfFile &file, Warnings &warnings);
/// meshOfPrimitive[m][p]: index into file.meshes of primitive p of glTF mesh m; kNone where it is left out.
void readGltfMeshes(const GltfSource &source, GltfFile &file, std::vector<std::vector<Index>> &meshOfPrimitive, Warnings &warnings);
/// nodeOf[n]: where glTF's node n went in file.nodes.
void readGltfNodes(const GltfSource &source, GltfFile &file, const std::vector<std::vector<Index>> &meshOfPrimitive,
                   std::vector<Index> &nodeOf);
void readGltfSkins(const GltfSource &source, GltfFile &file, const std::vector<Index> &nodeOf);
void readGltfClips(const GltfSource &source, GltfFile &file, const std::vector<Index> &nodeOf, Warnings &warnings);

/// The number of morph targets of glTF's mesh `mesh`; 0 where it is -1.
std::size_t gltfMorphCount(const GltfSource &source, int mesh);

} // namespace taut
