#pragma once
/// What the parts of the scene loader share: the scene being built, and what has already been read. Internal to `scene/`.

#include "taut/formats/gltf.h"
#include "taut/scene/load_scene.h"
#include "taut/scene/rules.h"
#include "taut/scene/scene.h"
#include "taut/scene/table_reader.h"

#include <map>
#include <memory>
#include <set>
#include <string>

namespace taut {

/// Names that are taken, and where to look on for a free one after each.
struct UniqueNames {
    std::set<std::string> taken{};
    std::map<std::string, int> next{}; ///< number that name_2, name_3 ... have reached
    [[nodiscard]] auto begin() const { return taken.begin(); }
    [[nodiscard]] auto end() const { return taken.end(); }
};

struct SceneCache {
    std::map<std::string, std::shared_ptr<const GltfFile>> gltfFiles{};
    std::map<std::string, std::shared_ptr<const Mesh>> meshes{};
    std::map<std::string, Texture> textures{};                  ///< by path and decoding
    std::map<std::string, std::optional<Texture>> gltfImages{}; ///< by file, number and decoding; none: it can't be read
    std::optional<double> memory{};                             ///< bytes that the scene may ask for, by the files that were read
};

struct LoadContext {
    LoadContext(Warnings &warnings_, SceneCache &cache_) : warnings(warnings_), cache(cache_) {}

    [[nodiscard]] Budget *budget() const { return scene.budget.get(); }

    Scene scene;
    Warnings &warnings;
    SceneCache &cache;                        ///< every file is read once
    std::string folder;                       ///< relative paths start here
    std::map<std::string, GivenMesh> given{}; ///< SceneTree::meshes

    std::set<const GltfFile *> gltfFiles{};   ///< that the scene has
    std::set<std::string> gltfImages{};       ///< likewise, by their keys in the cache
    std::map<std::string, Index> textures{};  ///< by path and decoding
    std::map<std::string, Index> materials{}; ///< [material.NAME] by name
    std::map<std::pair<const GltfFile *, Index>, Index> gltfMaterials{};
    UniqueNames objectNames{}; ///< of objects, and of glTF entries, whose objects are named entry/node
    Index defaultMaterial = kNone;
    bool meshLights = false;              ///< [[light]] makes a mesh shine
    const TomlValue *wholeClip = nullptr; ///< frames = "clip"
};

/// The path a key names, relative to the scene file, which is one of its inputs. Throws at the key where that is no readable file.
std::string filePath(LoadContext &context, const TomlValue &value);
/// A path relative to the scene file, whether it is there or not: for patterns. Backslashes, which are separators where many files were
/// made, count as slashes unless there is a file of that very name, or no folder of the other.
std::string resolvedPath(const LoadContext &context, const std::string &path);

std::shared_ptr<const GltfFile> gltfFile(LoadContext &context, const std::string &path);
std::shared_ptr<const Mesh> meshFile(LoadContext &context, const std::string &path);

/// Throws where there is a mistake.
void failOn(const Location &where, const std::optional<Mistake> &mistake);

/// `name`, or name_2, name_3 ... where it is taken.
std::string uniqueName(UniqueNames &names, const std::string &name);

double firstFrame(const Scene &scene);

// --- sections of a scene file ----------------------------------------------------------------------------------------
void loadRender(LoadContext &context, const TomlValue &section);
void loadImage(LoadContext &context, const TomlValue &section);
/// [[light]]: appends a light, or makes objects emit.
void loadLights(LoadContext &context, const TomlValue &section);
/// The group of lights that a `group` names, new or known.
Index lightGroup(LoadContext &context, const TomlValue &value);
void loadEnvironment(LoadContext &context, const TomlValue &section);
/// [camera]; null: all defaults. Where it gives no position, look_at or gltf, the camera is `fallback`'s, else framed.
void loadCamera(LoadContext &context, const TomlValue *section, const std::string &fallbackGltf);

void loadMaterials(LoadContext &context, const TomlValue &section);
/// Says how many texels of a normal map are none (slope_texture.h).
void warnOfSteepNormals(LoadContext &context, const std::string &where, Index texture);
/// Brushed steel, for what has no material.
Index defaultMaterial(LoadContext &context);
/// The scene material that a key names.
Index namedMaterial(const LoadContext &context, const TomlValue &value);

/// A number or texture. `unit` multiplies it (degrees to radians); a texture's scale defaults to `textureScale`.
FloatParam toFloatParam(LoadContext &context, const TomlValue &value, const Range &range, double unit = 1, double textureScale = 1);
/// A colour (three numbers or one grey) or texture.
ColorParam toColorParam(LoadContext &context, const TomlValue &value, const Range &range);
/// For a texture that another loading has read.
void countTexels(LoadContext &context, const Texture &texture);
/// Adds a texture, or finds it where it was added before. `key` tells decodings apart.
template <class Read> Index addTexture(LoadContext &context, const std::string &key, const Read &read) {
    const auto found = context.textures.find(key);
    if (found != context.textures.end()) return found->second;
    const auto known = context.cache.textures.find(key);
    if (known == context.cache.textures.end()) {
        context.scene.textures.push_back(context.cache.textures.emplace(key, read()).first->second);
    } else {
        countTexels(context, known->second);
        context.scene.textures.push_back(known->second);
    }
    const Index index = static_cast<Index>(context.scene.textures.size() - 1);
    context.textures.emplace(key, index);
    return index;
}

/// [[mesh]]: appends its objects.
void loadMeshes(LoadContext &context, const TomlValue &section);
std::vector<DeformerKeys> loadDeformers(Budget &budget, const TomlValue &section);
/// translate, rotate_deg and scale of a [[mesh]] or [camera], and `up` for files that may be y up.
Placement loadPlacement(TableReader &table, bool yUpByDefault);

// --- glTF ------------------------------------------------------------------------------------------------------------
/// Motion of a node: `clip` and `loop` of the table. Without a clip, all that move different channels play together.
RigMotion loadGltfMotion(LoadContext &context, TableReader &table, const std::shared_ptr<const GltfFile> &file);
/// Objects of every node with a mesh of the file's scene, copies of `common` with their own name, mesh, materials and emission. Reads
/// `material`, `variant` and whether `smooth` is given. Throws at `where` where the file's scene holds no mesh.
void addGltfObjects(LoadContext &context, const Object &common, const std::shared_ptr<const GltfFile> &file, const RigMotion &motion,
                    TableReader &table, const Location &where);
/// KHR_lights_punctual lights where they are at the first frame.
void addGltfLights(LoadContext &context, const GltfFile &file, const RigMotion &motion, const Placement &placement);
/// The first camera node of the file's scene; kNone where there is none.
Index firstCameraNode(const GltfFile &file);

/// A view from the front, a little to the right and above, of everything at the first frame.
void frameCamera(const Scene &scene, Camera &camera);

} // namespace taut
