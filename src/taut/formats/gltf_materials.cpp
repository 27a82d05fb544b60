/// glTF 2.0, section 3.9 and the KHR_materials_* extensions: materials and their images; cameras and lights.

#include "taut/formats/gltf_accessors.h"
#include "taut/formats/gltf_source.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace taut {

namespace {

/// `value` where it lies in [lower, upper].
float inRange(const GltfSource &source, const std::string &where, double value, double lower, double upper) {
    if (!(value >= lower && value <= upper)) {
        const std::string range =
            upper < 1e30 ? std::to_string(lower) + " to " + std::to_string(upper) : "at least " + std::to_string(lower);
        failGltf(source.path, where, std::to_string(value), range);
    }
    return static_cast<float>(value);
}

/// A factor whose length checkGltfJson has checked.
template <class V> V colour(const GltfSource &source, const std::string &where, const std::vector<double> &values, V otherwise) {
    if (values.empty()) return otherwise;
    V result;
    for (int c = 0; c < V::length(); ++c) result[c] = inRange(source, where, values[static_cast<std::size_t>(c)], 0, 1);
    return result;
}

/// A number of one of the extensions read; `otherwise` where the extension or the member is absent.
double extensionNumber(const tinygltf::ExtensionMap &extensions, const std::string &extension, const std::string &member,
                       double otherwise) {
    const auto found = extensions.find(extension);
    if (found == extensions.end() || !found->second.Has(member)) return otherwise;
    return found->second.Get(member).GetNumberAsDouble();
}

/// True where KHR_texture_transform would move the texture.
bool isTransformed(const tinygltf::ExtensionMap &extensions) {
    const auto found = extensions.find("KHR_texture_transform");
    if (found == extensions.end()) return false;
    const tinygltf::Value &transform = found->second;
    const auto differs = [&](const char *member, double identity) {
        if (!transform.Has(member)) return false;
        const tinygltf::Value &value = transform.Get(member);
        if (value.IsNumber()) return value.GetNumberAsDouble() != identity;
        for (std::size_t i = 0; i < value.ArrayLen(); ++i)
            if (value.Get(i).GetNumberAsDouble() != identity) return true;
        return false;
    };
    return differs("offset", 0) || differs("rotation", 0) || differs("scale", 1) || transform.Has("texCoord");
}

GltfTextureRef readTexture(const GltfSource &source, const GltfFile &file, const tinygltf::TextureInfo &info, const std::string &where,
                           Warnings &warnings) {
    GltfTextureRef ref;
    if (info.index < 0) return ref;
    const auto warn = [&](const std::string &what) { warnings.add(source.path + ": " + where + ": " + what); };
    const Index index = checkedIndex(source, where + ".index", info.index, source.model.textures.size(), "textures");
    const tinygltf::Texture &texture = source.model.textures[index];
    ref.texCoord = info.texCoord;
    if (texture.source >= 0)
        ref.image = checkedIndex(source, jsonPath("textures", index) + ".source", texture.source, file.images.size(), "images");
    else
        warn("the texture has no PNG or JPEG image and is left out");
    if (info.texCoord != 0) warn("uses TEXCOORD_" + std::to_string(info.texCoord) + ", of which only TEXCOORD_0 is read");
    if (isTransformed(info.extensions)) warn("KHR_texture_transform is not supported; the texture is not moved");
    if (texture.sampler < 0) return ref;
    const tinygltf::Sampler &sampler = source.model.samplers[checkedIndex(source, jsonPath("textures", index) + ".sampler", texture.sampler,
                                                                          source.model.samplers.size(), "samplers")];
    const auto repeats = [&](int wrap) {
        if (wrap == TINYGLTF_TEXTURE_WRAP_MIRRORED_REPEAT)
            warn("mirrored repeat is not supported; the texture repeats unmirrored");
        else if (wrap != TINYGLTF_TEXTURE_WRAP_REPEAT && wrap != TINYGLTF_TEXTURE_WRAP_CLAMP_TO_EDGE)
            failGltf(source.path, jsonPath("samplers", static_cast<std::size_t>(texture.sampler)), "wrap mode " + std::to_string(wrap),
                     "10497, 33071 or 33648");
        return wrap != TINYGLTF_TEXTURE_WRAP_CLAMP_TO_EDGE;
    };
    ref.repeatU = repeats(sampler.wrapS);
    ref.repeatV = repeats(sampler.wrapT);
    return ref;
}

/// KHR_materials_anisotropy's texture, which tinygltf knows as an untyped value only.
tinygltf::TextureInfo anisotropyTexture(const tinygltf::ExtensionMap &extensions) {
    tinygltf::TextureInfo info;
    const auto found = extensions.find("KHR_materials_anisotropy");
    if (found == extensions.end() || !found->second.Has("anisotropyTexture")) return info;
    const tinygltf::Value &texture = found->second.Get("anisotropyTexture");
    info.index = texture.Get("index").GetNumberAsInt();
    if (texture.Has("texCoord")) info.texCoord = texture.Get("texCoord").GetNumberAsInt();
    if (texture.Has("extensions") && texture.Get("extensions").Has("KHR_texture_transform"))
        info.extensions["KHR_texture_transform"] = texture.Get("extensions").Get("KHR_texture_transform");
    return info;
}

GltfMaterial readMaterial(const GltfSource &source, const GltfFile &file, std::size_t m, Warnings &warnings) {
    const tinygltf::Material &gltf = source.model.materials[m];
    const tinygltf::PbrMetallicRoughness &pbr = gltf.pbrMetallicRoughness;
    const std::string where = jsonPath("materials", m);
    const std::string pbrPath = where + ".pbrMetallicRoughness";
    const std::string extensions = where + ".extensions.";
    GltfMaterial material;
    material.name = nameOr(gltf.name, "material", m);
    material.baseColor = colour(source, pbrPath + ".baseColorFactor", pbr.baseColorFactor, Vec4(1));
    material.baseColorTexture = readTexture(source, file, pbr.baseColorTexture, pbrPath + ".baseColorTexture", warnings);
    material.metallic = inRange(source, pbrPath + ".metallicFactor", pbr.metallicFactor, 0, 1);
    material.roughness = inRange(source, pbrPath + ".roughnessFactor", pbr.roughnessFactor, 0, 1);
    material.metallicRoughnessTexture =
        readTexture(source, file, pbr.metallicRoughnessTexture, pbrPath + ".metallicRoughnessTexture", warnings);
    const double strength = extensionNumber(gltf.extensions, "KHR_materials_emissive_strength", "emissiveStrength", 1);
    material.emissive = colour(source, where + ".emissiveFactor", gltf.emissiveFactor, Vec3(0)) *
                        inRange(source, extensions + "KHR_materials_emissive_strength.emissiveStrength", strength, 0, 1e37);
    material.emissiveTexture = readTexture(source, file, gltf.emissiveTexture, where + ".emissiveTexture", warnings);
    const std::string anisotropy = "KHR_materials_anisotropy";
    material.anisotropyStrength = inRange(source, extensions + anisotropy + ".anisotropyStrength",
                                          extensionNumber(gltf.extensions, anisotropy, "anisotropyStrength", 0), 0, 1);
    material.anisotropyRotation = static_cast<float>(extensionNumber(gltf.extensions, anisotropy, "anisotropyRotation", 0));
    material.anisotropyTexture =
        readTexture(source, file, anisotropyTexture(gltf.extensions), extensions + anisotropy + ".anisotropyTexture", warnings);
    const double ior = extensionNumber(gltf.extensions, "KHR_materials_ior", "ior", 1.5);
    // 0 is the extension's word for "reflects everything".
    material.ior = ior == 0 ? 0.0F : inRange(source, extensions + "KHR_materials_ior.ior", ior, 1, 1e37);
    material.transmission = inRange(source, extensions + "KHR_materials_transmission.transmissionFactor",
                                    extensionNumber(gltf.extensions, "KHR_materials_transmission", "transmissionFactor", 0), 0, 1);
    material.doubleSided = gltf.doubleSided;
    return material;
}

GltfImage readImage(const GltfSource &source, std::size_t i) {
    const nlohmann::json &gltf = source.json["images"][i];
    const std::string where = jsonPath("images", i);
    GltfImage image;
    image.name = nameOr(gltf.value("name", std::string()), "image", i);
    if (gltf.contains("bufferView")) {
        const auto bytes = gltfBufferView(source, gltf["bufferView"].get<int>(), where + ".bufferView");
        image.bytes.assign(bytes.begin(), bytes.end());
    } else if (gltf.contains("uri")) {
        const auto uri = gltf["uri"].get<std::string>();
        if (uri.substr(0, 5) == "data:")
            image.bytes = readUri(source.path, where + ".uri", uri);
        else
            image.path = pathOfUri(source.path, where + ".uri", uri);
    } else {
        failGltf(source.path, where, "neither 'uri' nor 'bufferView'", "one of them");
    }
    return image;
}

GltfCamera readCamera(const GltfSource &source, std::size_t c) {
    const tinygltf::Camera &gltf = source.model.cameras[c];
    const std::string where = jsonPath("cameras", c);
    GltfCamera camera;
    camera.name = nameOr(gltf.name, "camera", c);
    camera.perspective = gltf.type == "perspective";
    if (camera.perspective) {
        camera.yFov = inRange(source, where + ".perspective.yfov", gltf.perspective.yfov, 1e-6, 3.141592);
        camera.aspectRatio = inRange(source, where + ".perspective.aspectRatio", gltf.perspective.aspectRatio, 0, 1e37);
    } else {
        camera.yMag = inRange(source, where + ".orthographic.ymag", std::fabs(gltf.orthographic.ymag), 1e-30, 1e37);
    }
    return camera;
}

GltfLight readLight(const GltfSource &source, std::size_t l) {
    constexpr std::array<std::string_view, 3> kTypes{"directional", "point", "spot"};
    const tinygltf::Light &gltf = source.model.lights[l];
    const std::string where = jsonPath("extensions.KHR_lights_punctual.lights", l);
    GltfLight light;
    light.name = nameOr(gltf.name, "light", l);
    if (std::find(kTypes.begin(), kTypes.end(), gltf.type) == kTypes.end())
        failUnknownName({source.path + ": " + where + ".type", 0, 0, -1}, gltf.type, kTypes);
    light.type = gltf.type;
    light.color = colour(source, where + ".color", gltf.color, Vec3(1));
    light.intensity = inRange(source, where + ".intensity", gltf.intensity, 0, 1e37);
    if (light.type != "spot") return light;
    light.outerConeAngle = inRange(source, where + ".spot.outerConeAngle", gltf.spot.outerConeAngle, 0, 1.5708);
    light.innerConeAngle = inRange(source, where + ".spot.innerConeAngle", gltf.spot.innerConeAngle, 0, gltf.spot.outerConeAngle);
    return light;
}

} // namespace

void readGltfMaterials(const GltfSource &source, GltfFile &file, Warnings &warnings) {
    const std::size_t images = source.json.contains("images") ? source.json["images"].size() : 0;
    for (std::size_t i = 0; i < images; ++i) file.images.push_back(readImage(source, i));
    for (std::size_t m = 0; m < source.model.materials.size(); ++m) file.materials.push_back(readMaterial(source, file, m, warnings));
    for (std::size_t c = 0; c < source.model.cameras.size(); ++c) file.cameras.push_back(readCamera(source, c));
    for (std::size_t l = 0; l < source.model.lights.size(); ++l) file.lights.push_back(readLight(source, l));
}

} // namespace taut
