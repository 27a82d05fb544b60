/// Materials of a glTF file turned into materials, textures and emission of a scene: glTF 2.0, appendix B, and KHR_materials_*.

#include "taut/scene/load_gltf.h"

#include <algorithm>

namespace taut {

namespace {

/// An image of the file as texels; none where it can't be read, which is said once.
const std::optional<Texture> &imageOf(LoadContext &context, const GltfFile &file, Index number, ColorSpace space) {
    const std::string key = file.path + "#" + std::to_string(number) + "|" + std::to_string(static_cast<int>(space));
    const auto [found, isNew] = context.cache.gltfImages.try_emplace(key);
    const bool isFirst = context.gltfImages.insert(key).second;
    if (!isNew && isFirst && found->second) countTexels(context, *found->second);
    if (!isNew) return found->second;
    const GltfImage &image = file.images[number];
    const std::string name = file.path + ": images[" + std::to_string(number) + "]";
    try {
        found->second = image.path.empty() ? readTextureFromMemory(name, image.bytes, space, context.warnings, context.budget())
                                              : readTexture(image.path, space, context.warnings, context.budget());
    } catch (const LimitError &) { // the file's image is in order
        throw;
    } catch (const InputError &error) {
        context.warnings.add(image.path.empty() ? error.what() : name + ": " + error.what());
    }
    return found->second;
}

/// The scene's texture of an image under a sampler: those of one image share their texels.
Index textureOf(LoadContext &context, const Texture &image, const TextureSampler &sampler) {
    const std::vector<Texture> &textures = context.scene.textures;
    const auto same = std::find_if(textures.begin(), textures.end(), [&](const Texture &known) {
        return known.texels.begin() == image.texels.begin() && known.sampler == sampler;
    });
    if (same != textures.end()) return static_cast<Index>(same - textures.begin());
    context.scene.textures.push_back(image);
    context.scene.textures.back().sampler = sampler;
    return static_cast<Index>(textures.size() - 1);
}

/// What became of a reference to a texture.
struct FoundTexture {
    Index index = kNone;
    bool lost = false; ///< the file wants one, and it can't be shown
};

/// The textures of one material.
struct MaterialTextures {
    LoadContext &context;
    const GltfFile &file;
    const std::string &material;

    [[nodiscard]] FoundTexture find(const GltfTextureRef &ref, ColorSpace space) const {
        if (!ref.given) return {};
        std::string reason = "has no image that can be read";
        if (ref.sampler.uvSet > 1) {
            reason = "wants TEXCOORD_" + std::to_string(ref.sampler.uvSet) + ", where 0 and 1 are read,";
        } else {
            for (const Index image : {ref.image, ref.fallback})
                if (image != kNone)
                    if (const std::optional<Texture> &texels = imageOf(context, file, image, space))
                        return {textureOf(context, *texels, ref.sampler), false};
        }
        context.warnings.add(file.path + ": material " + quoted(material) + ": a texture " + reason + " and is left out");
        return {kNone, true};
    }
    [[nodiscard]] FloatParam number(float factor, const GltfTextureRef &ref, int channel) const {
        return {factor, find(ref, ColorSpace::Linear).index, channel};
    }
    [[nodiscard]] SlopeMap normals(float scale, const GltfTextureRef &ref) const {
        const Index texture = find(ref, ColorSpace::Linear).index;
        if (texture != kNone) warnOfSteepNormals(context, file.path + ": material " + quoted(material), texture);
        if (texture != kNone && ref.sampler.uvSet == 1)
            context.warnings.add(file.path + ": material " + quoted(material) +
                                 ": its map of normals reads TEXCOORD_1 in the tangents of TEXCOORD_0");
        return {SlopeMap::Kind::Normal, texture, scale};
    }
    [[nodiscard]] ColorParam color(const Vec3 &factor, const GltfTextureRef &ref) const {
        return {factor, find(ref, ColorSpace::Srgb).index};
    }
};

void setOpacity(const GltfMaterial &from, Material &material) {
    material.doubleSided = from.doubleSided;
    material.alphaMode = from.alphaMode == "MASK" ? AlphaMode::Mask : from.alphaMode == "BLEND" ? AlphaMode::Blend : AlphaMode::Opaque;
    material.alphaCutoff = from.alphaCutoff;
    if (material.alphaMode != AlphaMode::Opaque) material.opacity = {from.baseColor.w, material.color.texture, 3};
}

/// A factor of 0 needs no texture.
template <class Param> Param used(const Param &param) {
    return param.value == decltype(param.value)(0) ? Param{param.value} : param;
}

void setLobes(const MaterialTextures &textures, const GltfMaterial &from, Material &material) {
    material.specular = textures.number(from.specular, from.specularTexture, 3);
    material.specularColor = textures.color(from.specularColor, from.specularColorTexture);
    material.transmission = used(textures.number(from.transmission, from.transmissionTexture, 0));
    material.thinWalled = !(from.thickness > 0);
    material.attenuationColor = from.attenuationColor;
    if (from.attenuationDistance > 0) material.attenuationDistance = from.attenuationDistance;
    // Rays inside a volume meet its walls from behind, whichever side the file says is shown.
    if (from.transmission > 0 && !material.thinWalled) material.doubleSided = true;
    material.clearcoat = used(textures.number(from.clearcoat, from.clearcoatTexture, 0));
    material.clearcoatRoughness = textures.number(from.clearcoatRoughness, from.clearcoatRoughnessTexture, 1);
    if (material.clearcoat.value > 0) material.coatSlopes = textures.normals(from.clearcoatNormalScale, from.clearcoatNormalTexture);
    material.sheenColor = used(textures.color(from.sheenColor, from.sheenColorTexture));
    material.sheenRoughness = textures.number(from.sheenRoughness, from.sheenRoughnessTexture, 3);
    material.iridescence = used(textures.number(from.iridescence, from.iridescenceTexture, 0));
    material.iridescenceIor = from.iridescenceIor;
    material.iridescenceMin = from.iridescenceMin;
    material.iridescenceMax = from.iridescenceMax;
    material.thickness = textures.number(1, from.iridescenceThicknessTexture, 1);
}

Material toMaterial(LoadContext &context, const GltfFile &file, const GltfMaterial &from) {
    const MaterialTextures textures{context, file, from.name};
    Material material;
    material.name = from.name;
    material.type = BsdfType::MetallicRoughness;
    material.color = textures.color(Vec3(from.baseColor), from.baseColorTexture);
    const Index metallicRoughness = textures.find(from.metallicRoughnessTexture, ColorSpace::Linear).index;
    material.alphaX = material.alphaY = {from.roughness, metallicRoughness, 1};
    material.alphaIsRoughness = true;
    material.metallic = {from.metallic, metallicRoughness, 2};
    material.rotation.value = from.anisotropyRotation;
    material.anisotropyStrength = from.anisotropyStrength;
    material.anisotropyTexture = textures.find(from.anisotropyTexture, ColorSpace::Linear).index;
    material.ior = from.ior;
    material.unlit = from.unlit;
    material.slopes = textures.normals(from.normalScale, from.normalTexture);
    setOpacity(from, material);
    setLobes(textures, from, material);
    return material;
}

} // namespace

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

Emission gltfEmission(LoadContext &context, const GltfFile &file, Index index) {
    if (index == kNone || file.materials[index].emissive == Vec3(0)) return {};
    const GltfMaterial &from = file.materials[index];
    const FoundTexture texture = MaterialTextures{context, file, from.name}.find(from.emissiveTexture, ColorSpace::Srgb);
    // The factor scales a texture that says where the surface shines, mostly nowhere: without it, nothing is known to shine.
    if (texture.lost) return {};
    return {{from.emissive, texture.index}, from.doubleSided};
}

} // namespace taut
