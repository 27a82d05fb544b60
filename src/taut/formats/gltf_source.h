#pragma once
/// A glTF file taken apart: the container's chunks, the JSON, the buffers. Included by the glTF reader only.

#include "taut/formats/gltf.h"
#include "taut/formats/gltf_value.h"

#include <functional>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace taut {

struct GltfSource {
    std::string path;
    std::shared_ptr<const nlohmann::json> json; ///< checked by checkGltfJson
    std::vector<std::vector<unsigned char>> buffers;
    std::vector<std::string> bufferPaths; ///< of those that are files of their own
    std::size_t fileBytes = 0;            ///< of the file and its buffers
    Budget &budget;                       ///< parts may be shared by any number of users: it is their sum that must fit
    [[nodiscard]] GltfValue operator[](std::string_view key) const { return GltfValue(path, json.get())[key]; }
};

/// Opens and checks everything that lies before the meaning: container, JSON, extensions, buffers. Tells of extensions and members
/// that nothing reads.
GltfSource openGltf(const std::string &path, Budget &budget, Tally &leftOut, Warnings &warnings);

/// The bytes that a URI stands for: of a data: URI of any type, else of a file beside the .gltf.
std::vector<unsigned char> readUri(const std::string &gltfPath, const GltfValue &uri);
/// The path of a URI that is not a data: URI, beside the .gltf: as it stands where there is such a file, else percent-decoded.
/// Backslashes part folders too.
std::string pathOfUri(const std::string &gltfPath, const GltfValue &uri);
bool isDataUri(const GltfValue &uri);

/// `locate` makes a place of an offset into `text`.
std::shared_ptr<const nlohmann::json> parseGltfJson(std::string_view text, const std::string &path,
                                                    const std::function<Location(std::size_t)> &locate);
/// Checks the types of all members that the reader looks at, and the presence of the required ones. Unknown members are let through,
/// as glTF wants, and counted with the extensions that nothing reads.
void checkGltfJson(const std::string &path, const nlohmann::json &json, Tally &leftOut);
/// Whether an extension is applied.
bool isKnownExtension(std::string_view name);
/// All that are.
std::span<const std::string_view> knownExtensions();

// The parts, in the order in which they are read. Each takes what the earlier ones have put into `file`.
void readGltfMaterials(const GltfSource &source, GltfFile &file);
/// meshOf[m]: index into file.meshes of glTF mesh m; kNone where it has no triangles.
void readGltfMeshes(const GltfSource &source, GltfFile &file, std::vector<Index> &meshOf, Warnings &warnings);
/// nodeOf[n]: where glTF's node n went in file.nodes. Instances (EXT_mesh_gpu_instancing) become children of their node.
void readGltfNodes(const GltfSource &source, GltfFile &file, const std::vector<Index> &meshOf, std::vector<Index> &nodeOf);
void readGltfSkins(const GltfSource &source, GltfFile &file, const std::vector<Index> &nodeOf);
void readGltfClips(const GltfSource &source, GltfFile &file, const std::vector<Index> &nodeOf, Warnings &warnings);

/// The number of morph targets of a glTF mesh.
std::size_t gltfMorphCount(const GltfValue &mesh);
/// The mesh of a node, absent where it has none.
GltfValue gltfMeshOf(const GltfSource &source, const GltfValue &node);

} // namespace taut
