#pragma once
/// A glTF file taken apart: the container's chunks, the JSON, the buffers. Included by the glTF reader only.

#include "taut/formats/gltf.h"
#include "taut/formats/gltf_value.h"

#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

namespace taut {

struct GltfSource {
    std::string path;
    std::shared_ptr<const nlohmann::json> json; ///< checked by checkGltfJson
    std::vector<std::vector<unsigned char>> buffers;
    std::size_t fileBytes = 0;            ///< of the file and its buffers
    mutable std::size_t decodedBytes = 0; ///< by accessors so far, against decodedBudget
    [[nodiscard]] std::size_t decodedBudget() const { return (std::size_t{1} << 30) + 64 * fileBytes; }
    [[nodiscard]] GltfValue operator[](std::string_view key) const { return GltfValue(path, json.get())[key]; }
};

/// Opens and checks everything that lies before the meaning: container, JSON, extensions, buffers.
GltfSource openGltf(const std::string &path, Warnings &warnings);

/// The bytes that a URI stands for: of a data: URI, else of a file beside the .gltf.
std::vector<unsigned char> readUri(const std::string &gltfPath, const GltfValue &uri);
/// The path of a URI that is not a data: URI, percent-decoded, beside the .gltf.
std::string pathOfUri(const std::string &gltfPath, const GltfValue &uri);
bool isDataUri(const GltfValue &uri);

/// `locate` makes a place of an offset into `text`.
std::shared_ptr<const nlohmann::json> parseGltfJson(std::string_view text, const std::string &path,
                                                    const std::function<Location(std::size_t)> &locate);
/// Checks the types of all members that the reader looks at, and the presence of the required ones. Unknown members are let
/// through, as glTF wants.
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

/// The number of morph targets of a glTF mesh.
std::size_t gltfMorphCount(const GltfValue &mesh);
/// The mesh of a node, absent where it has none.
GltfValue gltfMeshOf(const GltfSource &source, const GltfValue &node);

} // namespace taut
