/// glTF 2.0, section 3.9 and the KHR_materials_* extensions: materials and their images; cameras and lights.

#include "taut/formats/gltf_accessors.h"

#include <array>
#include <cmath>

namespace taut {

namespace {

/// `value`, which `place` gave; throws unless it lies in [lower, upper].
float inRange(const GltfValue &place, double value, double lower, double upper) {
    if (!(value >= lower && value <= upper)) {
        const std::string range =
            upper < 1e30 ? std::to_string(lower) + " to " + std::to_string(upper) : "at least " + std::to_string(lower);
        place.fail(std::to_string(value), range);
    }
    return static_cast<float>(value);
}
float numberIn(const GltfValue &number, double otherwise, double lower, double upper) {
    return inRange(number, number.number(otherwise), lower, upper);
}

/// A factor whose length checkGltfJson has checked.
template <class V> V colour(const GltfValue &factor, V otherwise) {
    const std::vector<double> values = factor.numbers();
    if (values.empty()) return otherwise;
    V result;
    for (int c = 0; c < V::length(); ++c) result[c] = inRange(factor, values[static_cast<std::size_t>(c)], 0, 1);
    return result;
}

/// True where KHR_texture_transform would move the texture.
bool isTransformed(const GltfValue &transform) {
    const auto differs = [&](std::string_view member, double identity) {
        const GltfValue value = transform[member];
        if (value.number(identity) != identity) return true;
        for (const double component : value.numbers())
            if (component != identity) return true;
        return false;
    };
    return differs("offset", 0) || differs("rotation", 0) || differs("scale", 1) || transform.has("texCoord");
}

/// Whether a texture repeats beyond its edge.
bool repeats(const GltfValue &sampler, std::string_view member, const std::string &use, Warnings &warnings) {
    constexpr long long kRepeat = 10497;
    constexpr long long kMirrored = 33648;
    constexpr long long kClamp = 33071;
    const long long wrap = sampler[member].integer(kRepeat);
    if (wrap == kMirrored)
        warnings.add(use + ": mirrored repeat is not supported; the texture repeats unmirrored");
    else if (wrap != kRepeat && wrap != kClamp)
        sampler.fail("wrap mode " + std::to_string(wrap), "10497, 33071 or 33648");
    return wrap != kClamp;
}

GltfTextureRef readTexture(const GltfSource &source, const GltfFile &file, const GltfValue &info, Warnings &warnings) {
    GltfTextureRef ref;
    if (!info.present()) return ref;
    const GltfValue textures = source["textures"];
    const GltfValue texture = textures[info["index"].index(textures.size(), "textures")];
    ref.texCoord = static_cast<int>(info["texCoord"].integer(0));
    if (texture.has("source"))
        ref.image = texture["source"].index(file.images.size(), "images");
    else
        warnings.add(info.place() + ": the texture has no PNG or JPEG image and is left out");
    if (ref.texCoord != 0)
        warnings.add(info.place() + ": uses TEXCOORD_" + std::to_string(ref.texCoord) + ", of which only TEXCOORD_0 is read");
    if (isTransformed(info["extensions"]["KHR_texture_transform"]))
        warnings.add(info.place() + ": KHR_texture_transform is not supported; the texture is not moved");
    if (!texture.has("sampler")) return ref;
    const GltfValue samplers = source["samplers"];
    const GltfValue sampler = samplers[texture["sampler"].index(samplers.size(), "samplers")];
    ref.repeatU = repeats(sampler, "wrapS", info.place(), warnings);
    ref.repeatV = repeats(sampler, "wrapT", info.place(), warnings);
    return ref;
}

GltfMaterial readMaterial(const GltfSource &source, const GltfFile &file, const GltfValue &gltf, std::size_t number, Warnings &warnings) {
    const GltfValue pbr = gltf["pbrMetallicRoughness"];
    const GltfValue extensions = gltf["extensions"];
    const GltfValue anisotropy = extensions["KHR_materials_anisotropy"];
    const auto texture = [&](const GltfValue &info) { return readTexture(source, file, info, warnings); };
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
    material.transmission = numberIn(extensions["KHR_materials_transmission"]["transmissionFactor"], 0, 0, 1);
    material.doubleSided = gltf["doubleSided"].isTrue();
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
    if (camera.perspective) camera.yFov = numberIn(lens["yfov"], 0, 1e-6, 3.141592);
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

void readGltfMaterials(const GltfSource &source, GltfFile &file, Warnings &warnings) {
    readAll(source["images"], file.images, [&](const GltfValue &v, std::size_t i) { return readImage(source, v, i); });
    readAll(source["materials"], file.materials,
            [&](const GltfValue &v, std::size_t i) { return readMaterial(source, file, v, i, warnings); });
    readAll(source["cameras"], file.cameras, readCamera);
    readAll(source["extensions"]["KHR_lights_punctual"]["lights"], file.lights, readLight);
}

} // namespace taut
