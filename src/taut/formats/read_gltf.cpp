#include "taut/formats/gltf.h"

#include "taut/base/file_bytes.h"
#include "taut/formats/gltf_source.h"

namespace taut {

GltfFile readGltf(const std::string &path, Warnings &warnings) {
    const GltfSource source = openGltf(path, warnings);
    GltfFile file;
    file.path = path;
    std::vector<std::vector<Index>> meshOfPrimitive;
    std::vector<Index> nodeOf;
    readGltfMaterials(source, file, warnings);
    readGltfMeshes(source, file, meshOfPrimitive, warnings);
    readGltfNodes(source, file, meshOfPrimitive, nodeOf);
    readGltfSkins(source, file, nodeOf);
    readGltfClips(source, file, nodeOf, warnings);
    return file;
}

bool isGltfPath(const std::string &path) {
    const std::string extension = lowerExtension(path);
    return extension == "gltf" || extension == "glb";
}

} // namespace taut
