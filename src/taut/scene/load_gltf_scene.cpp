/// A glTF file turned into objects, materials and lights of a scene. Space: the file's own (y up); the placement of the entry
/// turns it to the world's z up.

#include "taut/scene/load_context.h"

#include <algorithm>
#include <array>

namespace taut {

namespace {

/// Transmission above this makes a material a dielectric; the blend of the two that glTF allows is not modelled.
constexpr float kMostlyTransmissive = 0.5F;

Index gltfTexture(LoadContext &context, const GltfFile &file, const GltfTextureRef &ref, ColorSpace space, const std::string &material) {
    if (ref.image == kNone) return kNone;
    if (ref.texCoord != 0) {
        context.warnings.add(file.path + ": material " + quoted(material) + " uses TEXCOORD_" + std::to_string(ref.texCoord) +
                             " for a texture; only TEXCOORD_0 is read, the texture is left out");
        return kNone;
    }
    const std::string key = file.path + "#" + std::to_string(ref.image) + "|" + std::to_string(static_cast<int>(space)) +
                            (ref.repeatU ? "|repeat" : "|clamp") + (ref.repeatV ? "|repeat" : "|clamp");
    return addTexture(context, key, [&] {
        const GltfImage &image = file.images[ref.image];
        Texture texture = image.path.empty()
                              ? readTextureFromMemory(file.path + ": images[" + std::to_string(ref.image) + "]", image.bytes, space)
                              : readTexture(image.path, space);
        texture.repeatU = ref.repeatU;
        texture.repeatV = ref.repeatV;
        return texture;
    });
}

/// glTF 2.0, appendix B, with KHR_materials_anisotropy, _ior and _transmission.
Material toMaterial(LoadContext &context, const GltfFile &file, const GltfMaterial &from) {
    Material material;
    material.name = from.name;
    material.type = from.transmission > kMostlyTransmissive ? BsdfType::Dielectric : BsdfType::MetallicRoughness;
    material.color = {Vec3(from.baseColor), gltfTexture(context, file, from.baseColorTexture, ColorSpace::Srgb, from.name)};
    const Index metallicRoughness = gltfTexture(context, file, from.metallicRoughnessTexture, ColorSpace::Linear, from.name);
    material.alphaX = material.alphaY = {from.roughness, metallicRoughness, 1};
    material.alphaIsRoughness = true;
    material.metallic = {from.metallic, metallicRoughness, 2};
    material.rotation.value = from.anisotropyRotation;
    material.anisotropyStrength = from.anisotropyStrength;
    material.anisotropyTexture = gltfTexture(context, file, from.anisotropyTexture, ColorSpace::Linear, from.name);
    material.ior = from.ior;
    return material;
}

/// The scene material of a material of the file, made on first use. kNone is glTF's default material.
Index gltfMaterial(LoadContext &context, const GltfFile &file, Index index) {
    const auto key = std::make_pair(&file, index);
    const auto found = context.gltfMaterials.find(key);
    if (found != context.gltfMaterials.end()) return found->second;
    GltfMaterial standard;
    standard.name = "glTF default";
    Material material = toMaterial(context, file, index == kNone ? standard : file.materials[index]);
    context.scene.materials.push_back(std::move(material));
    return context.gltfMaterials[key] = static_cast<Index>(context.scene.materials.size() - 1);
}

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

Index toClip(const TomlValue &value, const GltfFile &file) {
    const std::vector<Clip> &clips = file.rig.clips;
    if (value.kind == TomlValue::Kind::Integer && !clips.empty())
        return static_cast<Index>(toInteger(value, {0, static_cast<std::int64_t>(clips.size()) - 1}));
    if (toText(value) == "none") return kNone;
    std::vector<std::string_view> names{"none"};
    for (Index i = 0; i < clips.size(); ++i) {
        if (clips[i].name == value.text) return i;
        names.push_back(clips[i].name);
    }
    failUnknownName(value.where, value.text, names);
}

} // namespace

RigMotion loadGltfMotion(TableReader &table, const std::shared_ptr<const GltfFile> &file) {
    RigMotion motion;
    motion.clip = file->rig.clips.empty() ? kNone : 0;
    table.read("clip", motion.clip, [&](const TomlValue &value) { return toClip(value, *file); });
    table.read("loop", motion.loop);
    motion.rig = {file, &file->rig}; // keeps the file alive
    return motion;
}

Index firstCameraNode(const GltfFile &file) {
    for (const Index node : file.sceneNodes)
        if (const Index camera = file.attached[node].camera; camera != kNone && file.cameras[camera].perspective) return node;
    return kNone;
}

void addGltfObjects(LoadContext &context, const Object &common, const std::shared_ptr<const GltfFile> &shared, const RigMotion &motion,
                    const TomlValue *material, const Location &where) {
    const GltfFile &file = *shared;
    checkMaterialTable(file, material);
    const std::string entryName = uniqueName(context.objectNames, common.name);
    const std::size_t before = context.scene.objects.size();
    for (const Index nodeIndex : file.sceneNodes) {
        const Node &node = file.rig.nodes[nodeIndex];
        const std::string nodeName = node.name.empty() ? "node" + std::to_string(nodeIndex) : node.name;
        for (const Index meshIndex : file.attached[nodeIndex].meshes) {
            Object object = common;
            object.name = uniqueName(context.objectNames, entryName + "/" + nodeName);
            object.mesh = {shared, &file.meshes[meshIndex]}; // keeps the file alive
            object.rig = motion;
            object.rig->node = nodeIndex;
            const Index own = file.meshMaterials[meshIndex];
            object.materials.assign(std::max<std::size_t>(1, object.mesh->materialNames.size()),
                                    chosenMaterial(context, file, own, material));
            if (own != kNone) {
                const GltfMaterial &from = file.materials[own];
                object.emission = {from.emissive, kNone};
                if (from.emissive != Vec3(0))
                    object.emission.texture = gltfTexture(context, file, from.emissiveTexture, ColorSpace::Srgb, from.name);
                object.emissionTwoSided = from.doubleSided;
            }
            context.scene.objects.push_back(std::move(object));
        }
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
