/// A glTF file turned into objects, materials and lights of a scene. Space: the file's own (y up); the placement of the entry
/// turns it to the world's z up.

#include "taut/scene/load_gltf.h"

#include "taut/scene/memory_estimate.h"

#include <algorithm>
#include <array>

namespace taut {

namespace {

/// The entry's `material`: one name for all, or scene materials by the file's names; else the file's own.
Index chosenMaterial(LoadContext &context, const GltfFile &file, Index index, const TomlValue *material) {
    if (material == nullptr) return gltfMaterial(context, file, index);
    if (material->kind != TomlValue::Kind::Table) return namedMaterial(context, *material);
    const TomlValue *chosen = index == kNone ? nullptr : material->find(file.materials[index].name);
    return chosen != nullptr ? namedMaterial(context, *chosen) : gltfMaterial(context, file, index);
}

void checkMaterialTable(const GltfFile &file, const TomlValue *material) {
    if (material == nullptr || material->kind != TomlValue::Kind::Table) return;
    std::vector<std::string_view> names;
    for (const GltfMaterial &known : file.materials) names.push_back(known.name);
    for (const TomlEntry &entry : material->entries) {
        if (names.empty()) failInput(entry.where, quoted(entry.key), "a material of " + file.path + ", but it has none");
        if (std::find(names.begin(), names.end(), entry.key) == names.end()) failUnknownName(entry.where, entry.key, names);
    }
}

bool isAnimated(const RigMotion &motion, Index node) {
    constexpr std::array kPlaces{ChannelPath::Translation, ChannelPath::Rotation, ChannelPath::Scale};
    return std::any_of(kPlaces.begin(), kPlaces.end(),
                       [&](ChannelPath path) { return motion.poses->isMoved(motion.rig, clipOf(motion), node, path); });
}

/// The words for a light's keys (load_lights.cpp), read from a glTF light and its node, which know no others.
struct GltfLightKeys {
    const GltfLight &from;
    const DMat4 &worldFromNode;
    Light &light;

    void brightness(std::string_view /*key*/) { light.radiance = from.color * from.intensity; }
    void vector(std::string_view /*key*/, DVec3 &target) { target = DVec3(worldFromNode[3]); }
    void direction(std::string_view /*key*/, DVec3 &target) {
        const DVec3 forward = -DVec3(worldFromNode[2]);
        if (glm::length(forward) > 0) target = glm::normalize(forward);
    }
    void coneAngle(std::string_view key, double &target) { target = key == "inner_deg" ? from.innerConeAngle : from.outerConeAngle; }
    void cameraVisible() {}
    void length(std::string_view /*key*/, double & /*target*/) {}
    void flag(std::string_view /*key*/, bool & /*target*/) {}
};

Light toLight(const GltfLight &from, const DMat4 &worldFromNode) {
    Light light;
    forEachLightShape([&](auto shape) {
        GltfLightKeys keys{from, worldFromNode, light};
        if (from.type != shape.kName) return;
        shape.read(keys);
        light.shape = shape;
    });
    return light;
}

/// The place in a list that a key gives, by name or by number from 0; kNone for "none".
Index toPlace(const TomlValue &value, const std::vector<std::string> &listed) {
    if (value.kind == TomlValue::Kind::Integer && !listed.empty())
        return static_cast<Index>(toInteger(value, {0, static_cast<std::int64_t>(listed.size()) - 1}));
    if (toText(value) == "none") return kNone;
    std::vector<std::string_view> names{"none"};
    for (Index i = 0; i < listed.size(); ++i) {
        if (listed[i] == value.text) return i;
        names.push_back(listed[i]);
    }
    failUnknownName(value.where, value.text, names);
}

Index toClip(const TomlValue &value, const GltfFile &file) {
    std::vector<std::string> names;
    for (const Clip &clip : file.rig.clips) names.push_back(clip.name);
    return toPlace(value, names);
}

} // namespace

RigMotion loadGltfMotion(LoadContext &context, TableReader &table, const std::shared_ptr<const GltfFile> &file) {
    RigMotion motion;
    if (const TomlValue *clip = table.find("clip")) {
        motion.clip = toClip(*clip, *file);
    } else {
        motion.together = clipsTogether(*file, context.warnings);
        motion.clip = file->rig.clips.empty() || motion.together ? kNone : 0;
    }
    table.read("loop", motion.loop);
    motion.rig = {file, &file->rig}; // keeps the file alive
    return motion;
}

Index firstCameraNode(const GltfFile &file) {
    for (const Index node : file.sceneNodes)
        if (file.attached[node].camera != kNone) return node;
    return kNone;
}

namespace {

/// [nodes] how many there are from a root to each.
std::vector<Index> depthsOf(const Rig &rig) {
    std::vector<Index> depths;
    for (const Node &node : rig.nodes) depths.push_back(node.parent == kNone ? 1 : depths[node.parent] + 1); // parents come first
    return depths;
}

/// Materials and emission of an object's slots. `chosen`: the entry's `material`, may be null.
void setSlots(LoadContext &context, const GltfFile &file, Index mesh, Index variant, const TomlValue *chosen, Object &object) {
    object.materials.clear();
    for (const GltfSlot &slot : file.slots[mesh]) {
        const Index own = variant != kNone && !slot.variants.empty() ? slot.variants[variant] : slot.material;
        const Index material = chosenMaterial(context, file, own, chosen);
        const auto made = context.gltfMaterials.find({&file, own});
        const bool isOwn = made != context.gltfMaterials.end() && made->second == material;
        if (isOwn && !object.mesh->colors.empty()) context.scene.materials[material].vertexColors = true;
        object.materials.push_back(material);
        object.slotEmission.push_back(gltfEmission(context, file, own));
    }
    if (object.slotEmission.size() == 1) {
        object.emission = object.slotEmission.front().radiance;
        object.emissionTwoSided = object.slotEmission.front().twoSided;
    }
    if (object.slotEmission.size() == 1 || !emits(object)) object.slotEmission.clear();
}

} // namespace

void addGltfObjects(LoadContext &context, const Object &common, const std::shared_ptr<const GltfFile> &shared, const RigMotion &motion,
                    TableReader &table, const Location &where) {
    const GltfFile &file = *shared;
    const TomlValue *material = table.find("material");
    checkMaterialTable(file, material);
    Index variant = kNone;
    table.read("variant", variant, [&](const TomlValue &value) { return toPlace(value, file.variants); });
    const bool smoothAsked = table.find("smooth") != nullptr;
    const std::string entryName = uniqueName(context.objectNames, common.name);
    const std::size_t before = context.scene.objects.size();
    constexpr double kSecondsPerAncestor = 3e-6; // of all that asks what moves an object
    const std::vector<Index> depths = depthsOf(file.rig);
    for (const Index nodeIndex : file.sceneNodes) {
        const Index mesh = file.attached[nodeIndex].mesh;
        if (mesh == kNone) continue;
        const Node &node = file.rig.nodes[nodeIndex];
        const std::string nodeName = node.name.empty() ? "node" + std::to_string(nodeIndex) : node.name;
        context.budget()->work(kSecondsPerAncestor * depths[nodeIndex], file.path, "meshes of nodes within " + std::to_string(depths[nodeIndex]) + " others");
        Object object = common;
        object.name = uniqueName(context.objectNames, entryName + "/" + nodeName);
        object.mesh = {shared, &file.meshes[mesh]}; // keeps the file alive
        object.rig = motion;
        object.rig->node = nodeIndex;
        // glTF 2.0, section 3.7.2.1: without normals, faces are flat. Under subdivision the limit surface has normals of its own.
        if (!smoothAsked && file.flat[mesh] != 0) object.smooth = false;
        chargeObject(*context.budget(), object, context.scene.render);
        setSlots(context, file, mesh, variant, material, object);
        context.scene.objects.push_back(std::move(object));
    }
    if (context.scene.objects.size() == before) failInput(where, "no triangles in " + file.path, "a scene with a mesh");
}

void addGltfLights(LoadContext &context, const GltfFile &file, const RigMotion &motion, const Placement &placement) {
    const double frame = firstFrame(context.scene);
    const std::shared_ptr<const Pose> pose = poseAtFrame(motion, frame, context.scene.render.fps);
    const DMat4 worldFromFile = placementAt(placement, frame);
    for (const Index node : file.sceneNodes) {
        const Index light = file.attached[node].light;
        if (light == kNone) continue;
        context.scene.lights.push_back(toLight(file.lights[light], worldFromFile * pose->worldFromNode[node]));
        if (isAnimated(motion, node))
            context.warnings.add(file.path + ": light " + quoted(file.lights[light].name) +
                                 " is animated; it stays where it is at the first frame");
    }
}

} // namespace taut
