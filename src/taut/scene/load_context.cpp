#include "taut/scene/load_gltf.h"

#include "taut/formats/read_mesh.h"

#include <algorithm>
#include <filesystem>
#include <fstream>

namespace taut {

namespace fs = std::filesystem;

std::string resolvedPath(const LoadContext &context, const std::string &path) {
    const fs::path folder(context.folder);
    std::string forward = path;
    std::replace(forward.begin(), forward.end(), '\\', '/');
    std::error_code error;
    const bool asWritten = forward == path || fs::exists(folder / path, error) || !fs::exists((folder / forward).parent_path(), error);
    return (folder / (asWritten ? path : forward)).lexically_normal().string();
}

std::string filePath(LoadContext &context, const TomlValue &value) {
    const std::string path = resolvedPath(context, toText(value));
    const bool sane = value.text.find('\0') == std::string::npos && !value.text.empty();
    std::error_code error;
    const fs::file_status status = sane ? fs::status(path, error) : fs::file_status(fs::file_type::not_found);
    if (!fs::exists(status))
        failInput(value.where, quoted(value.text) + ", but there is no file " + (sane ? path : "of that name"), "an existing file");
    if (!fs::is_regular_file(status)) failInput(value.where, quoted(value.text) + ", but " + path + " is not a file", "a file");
    if (!std::ifstream(path, std::ios::binary))
        failInput(value.where, quoted(value.text) + ", but " + path + " can't be opened", "a readable file");
    context.scene.inputs.insert(path);
    return path;
}

std::shared_ptr<const GltfFile> gltfFile(LoadContext &context, const std::string &path) {
    auto &file = context.cache.gltfFiles[fs::path(path).lexically_normal().string()];
    if (!file) file = std::make_shared<const GltfFile>(readGltf(path, context.warnings, context.budget()));
    if (context.gltfFiles.insert(file.get()).second) {
        context.scene.files.push_back(summaryOf(*file));
        context.scene.inputs.insert(file->bufferPaths.begin(), file->bufferPaths.end());
        for (const GltfImage &image : file->images)
            if (!image.path.empty()) context.scene.inputs.insert(image.path);
    }
    return file;
}

std::shared_ptr<const Mesh> meshFile(LoadContext &context, const std::string &path) {
    auto &mesh = context.cache.meshes[path];
    if (!mesh) {
        mesh = std::make_shared<const Mesh>(readMesh(path, context.warnings));
        std::error_code error;
        const std::uintmax_t size = fs::file_size(path, error);
        if (!error) context.scene.budget->addInput(size);
    }
    return mesh;
}

void countTexels(LoadContext &context, const Texture &texture) {
    context.budget()->take(sizeof(float) * static_cast<double>(texture.texels.size()), texture.name, "its texels");
}

void failOn(const Location &where, const std::optional<Mistake> &mistake) {
    if (mistake) failInput(where, mistake->found, mistake->expected);
}

std::string uniqueName(UniqueNames &names, const std::string &name) {
    if (names.taken.insert(name).second) return name;
    int &number = names.next.try_emplace(name, 1).first->second;
    while (true) { // a name that is taken stays so
        std::string candidate = name + "_" + std::to_string(++number);
        if (names.taken.insert(candidate).second) return candidate;
    }
}

double firstFrame(const Scene &scene) {
    return scene.render.frames.front();
}

} // namespace taut
