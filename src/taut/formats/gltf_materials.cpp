/// glTF 2.0, section 3.9 and the KHR_materials_* extensions: materials and their images; cameras and lights.

#include "taut/formats/gltf_accessors.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>

namespace taut {

namespace {

/// Farther outside its range than this, a factor is wrong; nearer, it was rounded on its way here.
constexpr double kRounding = 1e-5;

/// As few digits as tell the number from its neighbours, so that a message never prints 1 for what is above 1.
std::string shortest(double value) {
    std::array<char, 40> text{};
    const auto [end, error] = std::to_chars(text.data(), text.data() + text.size(), value);
    return error == std::errc() ? std::string(text.data(), end) : formatNumber(value);
}

/// `value`, which `place` gave, held at the ends of [lower, upper] where rounding put it outside; throws where it is farther off.
float inRange(const GltfValue &place, double value, double lower, double upper) {
    if (!(value >= lower - kRounding && value <= upper + kRounding)) {
        const std::string range = upper < 1e30 ? formatNumber(lower) + " to " + formatNumber(upper) : "at least " + formatNumber(lower);
        place.fail(shortest(value), range);
    }
    return static_cast<float>(std::clamp(value, lower, upper));
}
float numberIn(const GltfValue &number, double otherwise, double lower, double upper) {
    return inRange(number, number.number(otherwise), lower, upper);
}

/// A factor whose length checkGltfJson has checked.
template <class V> V colour(const GltfValue &factor, V otherwise, double greatest = 1) {
    const std::vector<double> values = factor.numbers();
    if (values.empty()) return otherwise;
    V result;
    for (int c = 0; c < V::length(); ++c) result[c] = inRange(factor, values[static_cast<std::size_t>(c)], 0, greatest);
    return result;
}

TextureWrap wrapOf(const GltfValue &sampler, std::string_view member) {
    constexpr long long kRepeat = 10497;
    switch (const long long wrap = sampler[member].integer(kRepeat)) {
    case kRepeat: return TextureWrap::Repeat;
    case 33648: return TextureWrap::Mirror;
    case 33071: return TextureWrap::Clamp;
    default: sampler.fail("wrap mode " + std::to_string(wrap), "10497, 33071 or 33648");
    }
}

Vec2 pairOf(const GltfValue &pair, const Vec2 &otherwise) {
    const std::vector<double> values = pair.numbers();
    if (!pair.present()) return otherwise;
    if (values.size() != 2) pair.fail("an array of " + std::to_string(values.size()) + " numbers", "2");
    return {static_cast<float>(values[0]), static_cast<float>(values[1])};
}

/// What the readers of materials share.
struct MaterialSource {
    const GltfSource &source;
    GltfFile &file;

    /// An image of the file that `member` names.
    [[nodiscard]] Index image(const GltfValue &member) const {
        return member.present() ? member.index(file.images.size(), "images") : kNone;
    }
    [[nodiscard]] GltfTextureRef texture(const GltfValue &info) const;
};

GltfTextureRef MaterialSource::texture(const GltfValue &info) const {
    constexpr long long kNearest = 9728;
    GltfTextureRef ref;
    if (!info.present()) return ref;
    ref.given = true;
    const GltfValue textures = source["textures"];
    const GltfValue texture = textures[info["index"].index(textures.size(), "textures")];
    ref.fallback = image(texture["source"]);
    ref.image = image(texture["extensions"]["EXT_texture_webp"]["source"]);
    if (ref.image == kNone) std::swap(ref.image, ref.fallback);
    const GltfValue transform = info["extensions"]["KHR_texture_transform"];
    ref.sampler.uvSet = static_cast<int>(transform["texCoord"].integer(info["texCoord"].integer(0)));
    setTextureTransform(ref.sampler, pairOf(transform["offset"], Vec2(0)), static_cast<float>(transform["rotation"].number(0)),
                        pairOf(transform["scale"], Vec2(1)));
    if (!texture.has("sampler")) return ref;
    const GltfValue samplers = source["samplers"];
    const GltfValue sampler = samplers[texture["sampler"].index(samplers.size(), "samplers")];
    ref.sampler.wrapU = wrapOf(sampler, "wrapS");
    ref.sampler.wrapV = wrapOf(sampler, "wrapT");
    ref.sampler.nearest = sampler["magFilter"].integer(0) == kNearest;
    return ref;
}

/// KHR_materials_transmission, _volume, _specular, _clearcoat, _sheen and _iridescence.
void readLobes(const MaterialSource &from, const GltfValue &extensions, GltfMaterial &m) {
    const auto textureOf = [&](const GltfValue &info) { return from.texture(info); };
    const GltfValue transmission = extensions["KHR_materials_transmission"];
    m.transmission = numberIn(transmission["transmissionFactor"], 0, 0, 1);
    m.transmissionTexture = textureOf(transmission["transmissionTexture"]);
    const GltfValue volume = extensions["KHR_materials_volume"];
    m.thickness = numberIn(volume["thicknessFactor"], 0, 0, 1e37);
    m.attenuationColor = colour(volume["attenuationColor"], Vec3(1));
    if (volume.has("attenuationDistance")) m.attenuationDistance = numberIn(volume["attenuationDistance"], 0, 0, 1e37);
    const GltfValue specular = extensions["KHR_materials_specular"];
    m.specular = numberIn(specular["specularFactor"], 1, 0, 1);
    m.specularTexture = textureOf(specular["specularTexture"]);
    m.specularColor = colour(specular["specularColorFactor"], Vec3(1), 1e37);
    m.specularColorTexture = textureOf(specular["specularColorTexture"]);
    const GltfValue coat = extensions["KHR_materials_clearcoat"];
    m.clearcoat = numberIn(coat["clearcoatFactor"], 0, 0, 1);
    m.clearcoatTexture = textureOf(coat["clearcoatTexture"]);
    m.clearcoatRoughness = numberIn(coat["clearcoatRoughnessFactor"], 0, 0, 1);
    m.clearcoatRoughnessTexture = textureOf(coat["clearcoatRoughnessTexture"]);
    m.clearcoatNormalTexture = textureOf(coat["clearcoatNormalTexture"]);
    m.clearcoatNormalScale = static_cast<float>(coat["clearcoatNormalTexture"]["scale"].number(1));
    const GltfValue sheen = extensions["KHR_materials_sheen"];
    m.sheenColor = colour(sheen["sheenColorFactor"], Vec3(0));
    m.sheenColorTexture = textureOf(sheen["sheenColorTexture"]);
    m.sheenRoughness = numberIn(sheen["sheenRoughnessFactor"], 0, 0, 1);
    m.sheenRoughnessTexture = textureOf(sheen["sheenRoughnessTexture"]);
    const GltfValue film = extensions["KHR_materials_iridescence"];
    m.iridescence = numberIn(film["iridescenceFactor"], 0, 0, 1);
    m.iridescenceTexture = textureOf(film["iridescenceTexture"]);
    m.iridescenceIor = numberIn(film["iridescenceIor"], 1.3, 1, 1e37);
    m.iridescenceMin = numberIn(film["iridescenceThicknessMinimum"], 100, 0, 1e37);
    m.iridescenceMax = numberIn(film["iridescenceThicknessMaximum"], 400, 0, 1e37);
    m.iridescenceThicknessTexture = textureOf(film["iridescenceThicknessTexture"]);
}

GltfMaterial readMaterial(const MaterialSource &from, const GltfValue &gltf, std::size_t number) {
    constexpr std::array<std::string_view, 3> kAlphaModes{"OPAQUE", "MASK", "BLEND"};
    const GltfValue pbr = gltf["pbrMetallicRoughness"];
    const GltfValue extensions = gltf["extensions"];
    const GltfValue anisotropy = extensions["KHR_materials_anisotropy"];
    const auto texture = [&](const GltfValue &info) { return from.texture(info); };
    GltfMaterial material;
    material.name = gltf.nameOr("material", number);
    material.baseColor = colour(pbr["baseColorFactor"], Vec4(1));
    material.baseColorTexture = texture(pbr["baseColorTexture"]);
    material.metallic = numberIn(pbr["metallicFactor"], 1, 0, 1);
    material.roughness = numberIn(pbr["roughnessFactor"], 1, 0, 1);
    material.metallicRoughnessTexture = texture(pbr["metallicRoughnessTexture"]);
    material.emissive =
        colour(gltf["emissiveFactor"], Vec3(0)) * numberIn(extensions["KHR_materials_emissive_strength"]["emissiveStrength"], 1, 0, 1e37);
    material.emissiveTexture = texture(gltf["emissiveTexture"]);
    material.anisotropyStrength = numberIn(anisotropy["anisotropyStrength"], 0, 0, 1);
    material.anisotropyRotation = static_cast<float>(anisotropy["anisotropyRotation"].number(0));
    material.anisotropyTexture = texture(anisotropy["anisotropyTexture"]);
    // 0 is the extension's word for "reflects everything".
    const GltfValue ior = extensions["KHR_materials_ior"]["ior"];
    material.ior = ior.number(1.5) == 0 ? 0.0F : numberIn(ior, 1.5, 1, 1e37);
    material.doubleSided = gltf["doubleSided"].isTrue();
    if (gltf.has("alphaMode")) material.alphaMode = kAlphaModes[gltf["alphaMode"].choice(kAlphaModes)];
    material.alphaCutoff = numberIn(gltf["alphaCutoff"], 0.5, 0, 1e37);
    material.unlit = extensions.has("KHR_materials_unlit");
    readLobes(from, extensions, material);
    material.normalTexture = texture(gltf["normalTexture"]);
    material.normalScale = static_cast<float>(gltf["normalTexture"]["scale"].number(1));
    if (gltf.has("occlusionTexture")) from.file.leftOut.add("occlusionTexture");
    return material;
}

GltfImage readImage(const GltfSource &source, const GltfValue &gltf, std::size_t number) {
    const GltfValue uri = gltf["uri"];
    GltfImage image;
    image.name = gltf.nameOr("image", number);
    if (gltf.has("bufferView")) {
        const auto bytes = gltfBufferView(source, gltf["bufferView"]);
        image.bytes.assign(bytes.begin(), bytes.end());
    } else if (!uri.present()) {
        gltf.fail("neither 'uri' nor 'bufferView'", "one of them");
    } else if (isDataUri(uri)) {
        image.bytes = readUri(source.path, uri);
    } else {
        image.path = pathOfUri(source.path, uri);
    }
    return image;
}

/// Member `name` of a camera or light of that type.
GltfValue required(const GltfValue &gltf, std::string_view name) {
    if (!gltf.has(name)) gltf.fail("no member " + taut::quoted(name), taut::quoted(name));
    return gltf[name];
}

GltfCamera readCamera(const GltfValue &gltf, std::size_t number) {
    constexpr std::array<std::string_view, 2> kTypes{"perspective", "orthographic"};
    GltfCamera camera;
    camera.name = gltf.nameOr("camera", number);
    const std::string_view type = kTypes[gltf["type"].choice(kTypes)];
    const GltfValue lens = required(gltf, type);
    camera.perspective = type == "perspective";
    if (camera.perspective)
        camera.yFov = numberIn(lens["yfov"], 0, 1e-6, 3.141592);
    else if (camera.yMag = static_cast<float>(std::fabs(lens["ymag"].number(0))); !(camera.yMag > 0))
        lens["ymag"].fail("0", "half the height that is seen");
    return camera;
}

GltfLight readLight(const GltfValue &gltf, std::size_t number) {
    constexpr std::array<std::string_view, 3> kTypes{"directional", "point", "spot"};
    GltfLight light;
    light.name = gltf.nameOr("light", number);
    light.type = kTypes[gltf["type"].choice(kTypes)];
    light.color = colour(gltf["color"], Vec3(1));
    light.intensity = numberIn(gltf["intensity"], 1, 0, 1e37);
    if (light.type != "spot") return light;
    const GltfValue spot = required(gltf, "spot");
    const GltfValue outer = spot["outerConeAngle"];
    light.outerConeAngle = numberIn(outer, 0.7853981634, 0, 1.5708);
    light.innerConeAngle = numberIn(spot["innerConeAngle"], 0, 0, outer.number(0.7853981634));
    return light;
}

/// Fills `out` from an array of the file.
template <class T, class F> void readAll(const GltfValue &array, std::vector<T> &out, const F &read) {
    for (std::size_t i = 0; i < array.size(); ++i) out.push_back(read(array[i], i));
}

} // namespace

void readGltfMaterials(const GltfSource &source, GltfFile &file) {
    readAll(source["images"], file.images, [&](const GltfValue &v, std::size_t i) { return readImage(source, v, i); });
    readAll(source["materials"], file.materials, [&](const GltfValue &v, std::size_t i) { return readMaterial({source, file}, v, i); });
    readAll(source["extensions"]["KHR_materials_variants"]["variants"], file.variants,
            [](const GltfValue &v, std::size_t i) { return v.nameOr("variant", i); });
    readAll(source["cameras"], file.cameras, readCamera);
    readAll(source["extensions"]["KHR_lights_punctual"]["lights"], file.lights, readLight);
}

} // namespace taut
