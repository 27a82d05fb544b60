#include "taut/scene/load_scene.h"

#include "taut/base/file_bytes.h"
#include "taut/formats/read_mesh.h"
#include "taut/mesh/winding.h"
#include "taut/scene/check_scene.h"
#include "taut/scene/emission_reach.h"
#include "taut/scene/load_context.h"
#include "taut/scene/memory_estimate.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <numeric>

namespace taut {

namespace {

TomlValue textValue(const std::string &text, const Location &where) {
    TomlValue value;
    value.kind = TomlValue::Kind::String;
    value.where = where;
    value.text = text;
    return value;
}

/// The scene file that a bare mesh or glTF stands for: one [[mesh]] with its file.
TomlValue bareScene(const std::string &path) {
    const Location where{path, 0, 0, -1};
    TomlValue mesh;
    mesh.where = where;
    mesh.entries.push_back({"file", where, textValue(std::filesystem::path(path).filename().string(), where)});
    TomlValue meshes;
    meshes.kind = TomlValue::Kind::Array;
    meshes.where = where;
    meshes.items.push_back(std::move(mesh));
    TomlValue root;
    root.where = where;
    root.entries.push_back({"mesh", where, std::move(meshes)});
    return root;
}

TomlValue readRoot(const std::string &path) {
    if (lowerExtension(path) == "toml") return readToml(path);
    if (isGltfPath(path) || isMeshPath(path)) return bareScene(path);
    failInput({path, 0, 0, -1}, "a file of unknown kind", "a scene .toml, a .glb or .gltf, or a mesh .obj, .ply, .off or .stl");
}

/// NormalsFollowWinding, once a mesh; subdivision makes its own normals.
void warnOfTurnedNormals(LoadContext &context) {
    std::set<const Mesh *> seen;
    for (const Object &object : context.scene.objects) {
        if (object.subdivision.level > 0 || !seen.insert(object.mesh.get()).second) continue;
        if (const std::size_t count = normalsAgainstWinding(*object.mesh); count > 0)
            context.warnings.add("mesh " + quoted(object.name) + ": " + std::to_string(count) + " of " +
                                 std::to_string(object.mesh->normals.size()) +
                                 " normals contradict the winding of their faces and are turned");
    }
}

/// TangentOfMaps, where a material asks for it.
void setMapTangents(Scene &scene) {
    for (Object &object : scene.objects)
        object.mapTangents = std::any_of(object.materials.begin(), object.materials.end(), [&](Index m) {
            const Material &material = scene.materials[m];
            return material.slopes.isGiven() || material.coatSlopes.isGiven();
        });
}

/// More frames than anyone renders.
constexpr double kMostClipFrames = 1e6;

bool isLit(const Scene &scene, bool meshLights) {
    return scene.environment || !scene.lights.empty() || meshLights || emissionLights(scene);
}

/// The frames of the longest clip that plays: as many as its seconds hold.
void setClipFrames(const TomlValue &asked, Scene &scene) {
    double seconds = -1;
    const auto lengthen = [&](const std::optional<RigMotion> &rig) {
        if (const Clip *clip = rig ? clipOf(*rig) : nullptr) seconds = std::max(seconds, static_cast<double>(clip->duration));
    };
    for (const Object &object : scene.objects) lengthen(object.rig);
    lengthen(scene.camera.rig);
    if (seconds < 0) failInput(asked.where, "'clip', but no clip plays", "frames such as 1-48");
    const double count = std::max(1.0, std::ceil(seconds * scene.render.fps - 1e-6));
    if (count > kMostClipFrames) failInput(asked.where, "a clip of " + formatNumber(seconds) + " s", "a shorter one");
    scene.render.frames.resize(static_cast<std::size_t>(count));
    std::iota(scene.render.frames.begin(), scene.render.frames.end(), 1);
}

/// `bare`: the tree stands for a mesh or glTF file alone.
Scene load(SceneTree tree, const std::vector<std::string> &overrides, Warnings &warnings, SceneCache &cache, bool environment, bool bare,
           std::shared_ptr<Budget> budget) {
    for (const std::string &text : overrides) applyOverride(tree.root, text);

    LoadContext context(warnings, cache);
    context.folder = std::move(tree.folder);
    context.given = std::move(tree.meshes);
    context.scene.path = tree.name;
    context.scene.render.ground = bare;
    context.scene.budget = cache.memory ? std::make_shared<Budget>(*cache.memory) : budget ? std::move(budget) : std::make_shared<Budget>();
    TableReader table(tree.root, "with the sections of a scene", {"render", "image", "camera", "environment", "light", "material", "mesh"});
    if (const TomlValue *section = table.find("render")) loadRender(context, *section);
    if (const TomlValue *section = table.find("image")) loadImage(context, *section);
    if (const TomlValue *section = table.find("material")) loadMaterials(context, *section);
    if (const TomlValue *section = table.find("mesh")) loadMeshes(context, *section);
    if (const TomlValue *section = table.find("light")) loadLights(context, *section);
    const TomlValue *sky = table.find("environment");
    if (!environment)
        context.scene.environment.emplace();
    else if (sky != nullptr)
        loadEnvironment(context, *sky);
    context.scene.unsaid.light = !isLit(context.scene, context.meshLights);
    if (context.scene.unsaid.light) context.scene.environment = studioEnvironment();
    loadCamera(context, table.find("camera"), isGltfPath(tree.name) ? tree.name : "");
    if (context.wholeClip != nullptr) setClipFrames(*context.wholeClip, context.scene);
    for (const Object &object : context.scene.objects)
        if (object.subdivision.level > 0 && !object.mesh->storedM.empty())
            context.warnings.add("mesh " + quoted(object.name) + ": its stored M is left out under subdivision");
    chargeScene(context.scene);
    warnOfTurnedNormals(context);
    setMapTangents(context.scene);
    check(context.scene);
    cache.memory = context.scene.budget->most();
    return std::move(context.scene);
}

} // namespace

TomlValue sceneTree(const std::string &path) {
    return readRoot(path);
}

std::shared_ptr<SceneCache> makeSceneCache() {
    return std::make_shared<SceneCache>();
}

Scene loadScene(const std::string &path, const std::vector<std::string> &overrides, Warnings &warnings, SceneCache &cache, bool environment,
                std::shared_ptr<Budget> budget) {
    SceneTree tree{readRoot(path), path, std::filesystem::path(path).parent_path().string(), {}};
    const bool bare = lowerExtension(path) != "toml";
    Scene scene = load(std::move(tree), overrides, warnings, cache, environment, bare, std::move(budget));
    if (!bare) scene.inputs.insert(path);
    return scene;
}

Scene loadScene(const std::string &path, const std::vector<std::string> &overrides, Warnings &warnings, std::shared_ptr<Budget> budget) {
    SceneCache cache;
    return loadScene(path, overrides, warnings, cache, true, std::move(budget));
}

Scene loadScene(SceneTree tree, const std::vector<std::string> &overrides, Warnings &warnings, std::shared_ptr<Budget> budget) {
    SceneCache cache;
    return load(std::move(tree), overrides, warnings, cache, true, false, std::move(budget));
}

} // namespace taut
