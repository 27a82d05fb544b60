#include "taut/formats/gltf.h"

#include "taut/base/file_bytes.h"
#include "taut/formats/gltf_source.h"

#include <algorithm>
#include <optional>

namespace taut {

void Tally::add(const std::string &name, std::size_t count) {
    const auto known = std::find_if(counts.begin(), counts.end(), [&](const auto &entry) { return entry.first == name; });
    if (known != counts.end())
        known->second += count;
    else
        counts.emplace_back(name, count);
}

std::string Tally::text() const {
    std::string text;
    for (const auto &[name, count] : counts) text += (text.empty() ? "" : ", ") + name + " (" + std::to_string(count) + ")";
    return text;
}

GltfFile readGltf(const std::string &path, Warnings &warnings, Budget *budget) {
    std::optional<Budget> own;
    GltfFile file;
    file.path = path;
    const GltfSource source = openGltf(path, budget != nullptr ? *budget : own.emplace(), file.leftOut, warnings);
    file.bufferPaths = source.bufferPaths;
    std::vector<Index> meshOf;
    std::vector<Index> nodeOf;
    readGltfMaterials(source, file);
    readGltfMeshes(source, file, meshOf, warnings);
    readGltfNodes(source, file, meshOf, nodeOf);
    readGltfSkins(source, file, nodeOf);
    readGltfClips(source, file, nodeOf, warnings);
    if (!file.leftOut.counts.empty()) warnings.add(path + ": used, but not shown in the picture: " + file.leftOut.text());
    return file;
}

bool isGltfPath(const std::string &path) {
    const std::string extension = lowerExtension(path);
    return extension == "gltf" || extension == "glb";
}

} // namespace taut
