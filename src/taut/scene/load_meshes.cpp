/// [[mesh]] entries: single meshes, numbered sequences and glTF files.

#include "taut/base/frame_set.h"
#include "taut/deform/estimators.h"
#include "taut/formats/point_cache.h"
#include "taut/formats/point_files.h"
#include "taut/formats/read_mesh.h"
#include "taut/scene/load_context.h"
#include "taut/scene/memory_estimate.h"
#include "taut/scene/upright.h"

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <unordered_map>
#include <unordered_set>

namespace taut {

namespace {

namespace fs = std::filesystem;

/// "bind" or "frame N".
RestState toRest(const TomlValue &value) {
    constexpr std::string_view kFrame = "frame ";
    const std::string &text = toText(value);
    if (text == "bind") return {};
    RestState rest{false, 0};
    const char *end = text.data() + text.size();
    const bool hasNumber = text.compare(0, kFrame.size(), kFrame) == 0;
    const auto [stop, error] = hasNumber ? std::from_chars(text.data() + kFrame.size(), end, rest.frame)
                                         : std::from_chars_result{end, std::errc::invalid_argument};
    if (error != std::errc() || stop != end || !(std::fabs(rest.frame) <= 1e9)) failInput(value.where, quoted(text), "'bind' or 'frame N'");
    return rest;
}

/// Frame numbers of the files on disk that a pattern names, increasing.
std::vector<int> framesOnDisk(const std::string &pattern) {
    const std::string name = fs::path(pattern).filename().string();
    const fs::path folder = fs::path(pattern).parent_path();
    std::vector<int> frames;
    std::error_code error;
    for (fs::directory_iterator it(folder.empty() ? fs::path(".") : folder, error), end; !error && it != end; it.increment(error)) {
        if (const std::optional<int> frame = frameOfPath(name, it->path().filename().string())) frames.push_back(*frame);
    }
    std::sort(frames.begin(), frames.end());
    return frames;
}

/// A name with a frame pattern is that of a sequence unless there is a file of that very name.
bool isSequence(const LoadContext &context, const std::string &path) {
    std::error_code ignored;
    return hasFramePattern(path) && !fs::is_regular_file(resolvedPath(context, path), ignored);
}

/// The name of an entry that has none: the file's stem, of a sequence without its number.
std::string stemOf(const LoadContext &context, const std::string &file) {
    const bool sequence = isSequence(context, file);
    const std::string path = resolvedPath(context, file);
    std::string stem = fs::path(sequence ? pathOfFrame(path, 0) : path).stem().string();
    if (sequence) stem = stem.substr(0, stem.find_last_not_of("0123456789") + 1);
    while (stem.size() > 1 && (stem.back() == '.' || stem.back() == '_' || stem.back() == '-')) stem.pop_back();
    return stem.empty() ? "mesh" : stem;
}

/// Scene materials by the file's material slots.
std::vector<Index> slotMaterials(LoadContext &context, const Mesh &mesh, const std::string &name, const TomlValue *material) {
    const std::size_t count = std::max<std::size_t>(1, mesh.materialNames.size());
    if (material == nullptr) return std::vector<Index>(count, defaultMaterial(context));
    if (material->kind != TomlValue::Kind::Table) return std::vector<Index>(count, namedMaterial(context, *material));
    const std::vector<std::string_view> slots(mesh.materialNames.begin(), mesh.materialNames.end());
    const std::unordered_set<std::string_view> known(slots.begin(), slots.end());
    std::unordered_map<std::string_view, const TomlValue *> given;
    for (const TomlEntry &entry : material->entries) given.emplace(entry.key, &entry.value);
    if (slots.empty()) failInput(material->where, "a table of materials for a file that names none", "the name of one material");
    for (const TomlEntry &entry : material->entries)
        if (!known.contains(entry.key)) failUnknownName(entry.where, entry.key, slots);
    std::vector<Index> materials;
    for (const std::string &slot : mesh.materialNames) {
        const auto found = given.find(slot);
        const TomlValue *chosen = found != given.end() ? found->second : nullptr;
        if (chosen == nullptr)
            context.warnings.add("mesh " + quoted(name) + ": no material is given for " + quoted(slot) + "; the default is used");
        materials.push_back(chosen != nullptr ? namedMaterial(context, *chosen) : defaultMaterial(context));
    }
    return materials;
}

/// The names of a table with "auto", which leaves the choice to the plan.
template <class E, std::size_t N> Names<std::optional<E>> orAuto(const std::array<Named<E>, N> &table) {
    Names<std::optional<E>> names{{"auto", std::nullopt}};
    for (const auto &[value, name] : table) names.emplace_back(name, value);
    return names;
}

/// The keys about how a mesh becomes a surface.
void loadSurfaceModel(TableReader &table, Object &object) {
    if (const TomlValue *value = table.find("subdivision")) {
        object.planLevel = value->kind == TomlValue::Kind::String;
        object.subdivision.level =
            object.planLevel ? toChoice<int>(*value, {{"auto", kUnplannedLevel}}) : static_cast<int>(toInteger(*value, kSubdivisionLevel));
    }
    table.read("scheme", object.subdivision.scheme,
               oneOf<SubdivisionScheme>({{"catmull-clark", SubdivisionScheme::CatmullClark}, {"loop", SubdivisionScheme::Loop}}));
    table.read(
        "boundary", object.subdivision.boundary,
        oneOf<SubdivisionBoundary>({{"edge-and-corner", SubdivisionBoundary::EdgeAndCorner}, {"edge", SubdivisionBoundary::EdgeOnly}}));
    table.read("crease_deg", object.subdivision.creaseAngle, numberIn(kCreaseAngle, radians(1)));
    table.read("lean", object.lean);
    table.read("gradient", object.gradient, oneOf(orAuto(kEstimators)));
    if (object.gradient) failOn(table.find("gradient")->where, mistakeInGradient(object));
    if (object.lean) failOn(table.find("lean")->where, mistakeInLean(object));
    table.read("interpolation", object.interpolation, oneOf(orAuto(kInterpolations)));
}

void addGltf(LoadContext &context, TableReader &table, const TomlValue &file, Object common) {
    const std::shared_ptr<const GltfFile> gltf = gltfFile(context, filePath(context, file));
    const RigMotion motion = loadGltfMotion(context, table, gltf);
    bool lights = true;
    table.read("lights", lights);
    const std::size_t before = context.scene.lights.size();
    if (lights) addGltfLights(context, *gltf, motion, common.placement);
    for (std::size_t i = before; i < context.scene.lights.size(); ++i) context.scene.lights[i].group = common.emissionGroup;
    addGltfObjects(context, common, gltf, motion, table, file.where);
    table.finish();
}

/// A point cache that fits the mesh.
std::shared_ptr<const PointSource> pointCache(LoadContext &context, const TomlValue &value, const Mesh &mesh, bool isSequence) {
    if (!isPointCachePath(toText(value))) failInput(value.where, quoted(value.text), "a file ending in .pc2 or .mdd");
    if (isSequence) failInput(value.where, "a cache for a numbered sequence", "one of the two");
    std::shared_ptr<const PointSource> cache = cachePoints(filePath(context, value));
    if (cache->points() != mesh.positions.size())
        failInput(value.where, quoted(value.text) + " with " + std::to_string(cache->points()) + " points",
                  "as many as the mesh has positions, " + std::to_string(mesh.positions.size()));
    return cache;
}

/// What an entry says of a single mesh's looks, once its mesh is known.
void finishMesh(LoadContext &context, const TomlValue *material, const TomlValue *scheme, const std::string &from, Object object) {
    if (std::optional<Mistake> mistake = mistakeInScheme(object)) {
        mistake->found += " in " + from;
        failOn(scheme->where, mistake);
    }
    object.name = uniqueName(context.objectNames, object.name);
    chargeObject(*context.budget(), object, context.scene.render);
    object.materials = slotMaterials(context, *object.mesh, object.name, material);
    context.scene.objects.push_back(std::move(object));
}

void addGiven(LoadContext &context, TableReader &table, const GivenMesh &given, Object object) {
    const TomlValue *material = table.find("material");
    const TomlValue *scheme = table.find("scheme");
    table.finish();
    object.mesh = given.mesh;
    object.points = given.points;
    context.scene.budget->addInput(sizeof(Vec3) * given.mesh->positions.size() + sizeof(Index) * given.mesh->cornerCount());
    finishMesh(context, material, scheme, "this mesh", std::move(object));
}

void addMesh(LoadContext &context, TableReader &table, const TomlValue &file, Object object) {
    if (!isMeshPath(file.text)) failInput(file.where, quoted(file.text), "a file ending in .obj, .ply, .off, .stl, .glb or .gltf");
    std::string path;
    std::string pattern;
    std::vector<int> frames;
    if (isSequence(context, file.text)) {
        pattern = resolvedPath(context, file.text);
        frames = framesOnDisk(pattern);
        if (frames.empty())
            failInput(file.where, quoted(file.text) + ", but there is no such file as " + pathOfFrame(pattern, 1),
                      "a numbered sequence of meshes");
        path = pathOfFrame(pattern, frames.front());
        for (const int frame : frames) context.scene.inputs.insert(pathOfFrame(pattern, frame));
    } else {
        path = filePath(context, file);
    }
    const TomlValue *material = table.find("material");
    const TomlValue *cache = table.find("cache");
    const TomlValue *scheme = table.find("scheme");
    table.finish();
    object.mesh = meshFile(context, path);
    if (cache != nullptr) object.points = pointCache(context, *cache, *object.mesh, !frames.empty());
    if (!frames.empty()) object.points = sequencePoints(std::move(pattern), std::move(frames), object.mesh);
    finishMesh(context, material, scheme, path, std::move(object));
}

} // namespace

Placement loadPlacement(TableReader &table, bool yUpByDefault) {
    Placement placement;
    table.read("translate", placement.translation, keyedVec3In());
    table.read("rotate_deg", placement.rotation, keyedVec3In(kDegrees, radians(1)));
    if (const TomlValue *scale = table.find("scale")) placement.scale = toKeyedTriple(*scale, kAnyNumber);
    bool yUp = yUpByDefault;
    table.read("up", yUp, oneOf<bool>({{"z", false}, {"y", true}}));
    if (yUp) placement.worldFromUp = kWorldFromYUp;
    return placement;
}

void loadMeshes(LoadContext &context, const TomlValue &section) {
    if (section.kind != TomlValue::Kind::Array) failInput(section.where, describe(section), "tables [[mesh]]");
    for (const TomlValue &entry : section.items) {
        TableReader table(entry, "[[mesh]]",
                          {"file",       "name",       "material", "subdivision",   "smooth", "follow", "rest",   "translate",
                           "rotate_deg", "scale",      "up",       "clip",          "loop",   "lights", "deform", "scheme",
                           "boundary",   "crease_deg", "gradient", "interpolation", "lean",   "cache",  "variant", "group"});
        const TomlValue &file = table.required("file", "file = \"mesh.obj\"");
        const auto given = context.given.find(toText(file));
        Object object;
        object.name = given != context.given.end() ? "mesh" : stemOf(context, file.text);
        table.read("name", object.name);
        loadSurfaceModel(table, object);
        table.read("smooth", object.smooth);
        table.read("follow", object.follow);
        if (const TomlValue *group = table.find("group")) object.emissionGroup = lightGroup(context, *group);
        table.read("rest", object.rest, toRest);
        if (const TomlValue *deform = table.find("deform")) object.deformers = loadDeformers(*context.budget(), *deform);
        object.placement = loadPlacement(table, isGltfPath(file.text));
        context.scene.unsaid.up = !isGltfPath(file.text) && table.find("up") == nullptr && table.find("rotate_deg") == nullptr;
        if (given != context.given.end())
            addGiven(context, table, given->second, std::move(object));
        else if (isGltfPath(file.text))
            addGltf(context, table, file, std::move(object));
        else
            addMesh(context, table, file, std::move(object));
    }
}

} // namespace taut
