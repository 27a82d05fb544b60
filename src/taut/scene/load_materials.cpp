#include "taut/bsdf/metals.h"
#include "taut/scene/load_context.h"
#include "taut/scene/material_presets.h"
#include "taut/scene/slope_texture.h"

namespace taut {

namespace {

bool isTexture(const TomlValue &value) {
    return value.kind == TomlValue::Kind::Table;
}

/// One number, or two along u and v.
DVec2 toTiles(const TomlValue &value) {
    if (value.kind != TomlValue::Kind::Array) return DVec2(toNumber(value, kPositive));
    const auto &pair = toArray(value, 2, "a number above 0 or a pair of them");
    return {toNumber(pair[0], kPositive), toNumber(pair[1], kPositive)};
}

struct TextureUse {
    Index texture = kNone;
    int channel = 0;
    DVec3 scale{1};
};

/// What becomes of an image beside its decoding: `name` tells it from others.
struct TextureMaking {
    std::string name{};
    Texture (*make)(const Texture &image, int channel) = nullptr;
};

/// { file, channel, color_space, scale, repeat, tile }. `automatic` is what color_space = "auto" means here: a colour's 8-bit image
/// is sRGB, a number's is not.
TextureUse loadTexture(LoadContext &context, const TomlValue &value, ColorSpace automatic, double defaultScale,
                       const TextureMaking &making = {}) {
    TableReader table(value, "of a texture", {"file", "channel", "color_space", "scale", "repeat", "tile"});
    TextureUse use;
    use.scale = DVec3(defaultScale);
    ColorSpace space = automatic;
    bool repeat = true;
    DVec2 tile(1);
    table.read("channel", use.channel, oneOf<int>({{"r", 0}, {"g", 1}, {"b", 2}, {"a", 3}}));
    table.read("color_space", space, oneOf<ColorSpace>({{"auto", automatic}, {"srgb", ColorSpace::Srgb}, {"linear", ColorSpace::Linear}}));
    table.read("scale", use.scale, tripleIn(kAnyNumber));
    table.read("repeat", repeat);
    table.read("tile", tile, toTiles);
    const std::string path = filePath(context, table.required("file", "file = \"image.png\""));
    const std::string key = path + "|" + std::to_string(static_cast<int>(space)) + (repeat ? "|repeat" : "|clamp") + "|" +
                            formatNumber(tile.x) + "|" + formatNumber(tile.y) +
                            (making.make != nullptr ? "|" + making.name + std::to_string(use.channel) : "");
    use.texture = addTexture(context, key, [&] {
        Texture texture = readTexture(path, space, context.warnings, context.budget());
        if (!repeat) texture.sampler.wrapU = texture.sampler.wrapV = TextureWrap::Clamp;
        if (tile != DVec2(1)) setTextureTransform(texture.sampler, {0, 1 - static_cast<float>(tile.y)}, 0, Vec2(tile));
        return making.make != nullptr ? making.make(texture, use.channel) : texture;
    });
    return use;
}

/// Texels of a colour that its texture says is above 1 in some channel, of how many.
std::pair<std::size_t, std::size_t> countAboveOne(const Texture &texture, const Vec3 &scale) {
    constexpr float kRounding = 1e-5F;
    const auto channels = static_cast<std::size_t>(texture.channels);
    const std::size_t texels = texture.texels.size() / channels;
    std::size_t above = 0;
    for (std::size_t i = 0; i < texels; ++i) {
        const float *texel = &texture.texels[i * channels];
        const Vec3 color = scale * (channels < 3 ? Vec3(texel[0]) : Vec3(texel[0], texel[1], texel[2]));
        above += maxComponent(color) > 1 + kRounding ? 1 : 0;
    }
    return {above, texels};
}

/// A colour by which light is reflected or passes. More than all of it there cannot be: numbers and texels above 1 are held there, and
/// said to be.
ColorParam toReflectance(LoadContext &context, const TomlValue &value) {
    ColorParam param = toColorParam(context, value, kNotNegative);
    const std::string where = value.where.text() + ": ";
    if (param.texture == kNone) {
        if (maxComponent(param.value) > 1) context.warnings.add(where + "found a colour above 1, which is held at 1");
        param.value = glm::min(param.value, Vec3(1));
        return param;
    }
    const auto [above, texels] = countAboveOne(context.scene.textures[param.texture], param.value);
    if (above > 0)
        context.warnings.add(where + "found a colour above 1 in " + std::to_string(above) + " of " + std::to_string(texels) +
                             " texels, which is held at 1");
    return param;
}

void loadAlpha(LoadContext &context, const TomlValue &value, Material &material) {
    if (value.kind == TomlValue::Kind::Array) {
        const auto &pair = toArray(value, 2, describe(kAlpha) + ", a pair of them, or a texture");
        material.alphaX = toFloatParam(context, pair[0], kAlpha);
        material.alphaY = toFloatParam(context, pair[1], kAlpha);
    } else {
        material.alphaX = material.alphaY = toFloatParam(context, value, kAlpha);
    }
}

void loadMetal(const TomlValue &value, Material &material) {
    std::vector<std::string_view> names;
    for (const Metal &metal : metals()) {
        names.push_back(metal.name);
        if (metal.name != toText(value)) continue;
        material.type = BsdfType::Metal;
        material.conductorEta = metal.eta;
        material.conductorK = metal.k;
        return;
    }
    failUnknownName(value.where, value.text, names);
}

/// `material` has its type and masking already.
Multiscatter toMultiscatter(const TomlValue &value, Material material) {
    material.multiscatter = toChoice<Multiscatter>(value, {{"auto", Multiscatter::Auto},
                                                           {"off", Multiscatter::Off},
                                                           {"compensation", Multiscatter::Compensation},
                                                           {"walk", Multiscatter::Walk}});
    failOn(value.where, mistakeInMultiscatter(material));
    return material.multiscatter;
}

Texture bumpSlopes(const Texture &heights, int channel) {
    return slopesFromHeights(heights, channel, SlopeMap::Kind::Bump);
}
Texture heightSlopes(const Texture &heights, int channel) {
    return slopesFromHeights(heights, channel, SlopeMap::Kind::Height);
}

SlopeMap toSlopeMap(LoadContext &context, const TomlValue &value, SlopeMap::Kind kind) {
    if (!isTexture(value)) failInput(value.where, describe(value), "a texture { file = \"image.png\" }");
    TextureMaking making;
    if (kind == SlopeMap::Kind::Bump) making = {"bump", bumpSlopes};
    if (kind == SlopeMap::Kind::Height) making = {"height", heightSlopes};
    const TextureUse use = loadTexture(context, value, ColorSpace::Linear, 1, making);
    if (use.scale.x != use.scale.y || use.scale.x != use.scale.z) failInput(value.find("scale")->where, "three scales", "one number here");
    if (kind != SlopeMap::Kind::Normal) return {kind, use.texture, static_cast<float>(use.scale.x)};
    if (const TomlValue *channel = value.find("channel"))
        failInput(channel->where, "a channel of a normal map", "a texture without 'channel' here");
    warnOfSteepNormals(context, value.where.text(), use.texture);
    return {kind, use.texture, static_cast<float>(use.scale.x)};
}

/// Keys of the mesostructure.
void readSlopes(LoadContext &context, TableReader &table, Material &material) {
    table.exclusive("normal", "bump");
    table.exclusive("normal", "height");
    table.exclusive("bump", "height");
    const auto map = [&](SlopeMap::Kind kind) { return [&context, kind](const TomlValue &v) { return toSlopeMap(context, v, kind); }; };
    table.read("normal", material.slopes, map(SlopeMap::Kind::Normal));
    table.read("bump", material.slopes, map(SlopeMap::Kind::Bump));
    table.read("height", material.slopes, map(SlopeMap::Kind::Height));
    table.read("detail", material.detail,
               oneOf<TextureDetail>({{"auto", TextureDetail::Auto}, {"map", TextureDetail::Map}, {"moments", TextureDetail::Moments}}));
    table.read("facets", material.facets, oneOf<FacetModel>({{"lean", FacetModel::Leans}, {"bend", FacetModel::Bends}}));
}

/// Keys of what has a microsurface.
void readMicrosurface(LoadContext &context, TableReader &table, Material &material) {
    if (const TomlValue *alpha = table.find("alpha")) loadAlpha(context, *alpha, material);
    table.read("rotation_deg", material.rotation, [&](const TomlValue &v) { return toFloatParam(context, v, kDegrees, radians(1), 360); });
    table.read("masking", material.masking, oneOf<Masking>({{"correlated", Masking::Correlated}, {"separable", Masking::Separable}}));
    table.read("multiscatter", material.multiscatter, [&](const TomlValue &v) { return toMultiscatter(v, material); });
    table.read("poisson", material.poisson, numberIn(kPoisson));
    table.read("roughening", material.roughening, numberIn(kNotNegative));
    table.read("yield", material.yield, numberIn(kNotNegative));
}

void readMetallicRoughness(LoadContext &context, TableReader &table, Material &material) {
    table.exclusive("alpha", "roughness");
    table.read("metallic", material.metallic, [&](const TomlValue &v) { return toFloatParam(context, v, kUnitInterval); });
    if (const TomlValue *roughness = table.find("roughness")) {
        material.alphaX = material.alphaY = toFloatParam(context, *roughness, kUnitInterval);
        material.alphaIsRoughness = true;
    }
    const TomlValue *anisotropy = table.find("anisotropy");
    if (anisotropy == nullptr) return;
    const FloatParam strength = toFloatParam(context, *anisotropy, kUnitInterval);
    material.anisotropyStrength = strength.value;
    material.anisotropyTexture = strength.texture;
}

/// The layers that glTF's extensions of metallic-roughness add, each by the extension's name (docs/scene.md).
void readLayers(LoadContext &context, TableReader &table, Material &material) {
    const auto share = [&](const TomlValue &v) { return toFloatParam(context, v, kUnitInterval); };
    const auto color = [&](const TomlValue &v) { return toReflectance(context, v); };
    table.read("specular", material.specular, share);
    table.read("specular_color", material.specularColor, [&](const TomlValue &v) { return toColorParam(context, v, kNotNegative); });
    table.read("transmission", material.transmission, share);
    table.read("thin_walled", material.thinWalled);
    table.read("attenuation_color", material.attenuationColor, tripleIn(kUnitInterval));
    table.read("attenuation_distance", material.attenuationDistance, numberIn(kPositive));
    table.read("clearcoat", material.clearcoat, share);
    table.read("clearcoat_roughness", material.clearcoatRoughness, share);
    table.read("clearcoat_normal", material.coatSlopes, [&](const TomlValue &v) { return toSlopeMap(context, v, SlopeMap::Kind::Normal); });
    table.read("sheen_color", material.sheenColor, color);
    table.read("sheen_roughness", material.sheenRoughness, share);
    table.read("iridescence", material.iridescence, share);
    table.read("iridescence_ior", material.iridescenceIor, numberIn(kFilmIor));
    if (const TomlValue *thickness = table.find("iridescence_thickness"))
        material.iridescenceMin = material.iridescenceMax = static_cast<float>(toNumber(*thickness, kNotNegative));
}

/// What is there of the surface, and from which sides. An opacity without a mode is meant to be seen.
void readPresence(LoadContext &context, TableReader &table, Material &material) {
    if (const TomlValue *opacity = table.find("opacity")) {
        material.opacity = toFloatParam(context, *opacity, kUnitInterval);
        material.alphaMode = AlphaMode::Blend;
    }
    table.read("alpha_mode", material.alphaMode,
               oneOf<AlphaMode>({{"opaque", AlphaMode::Opaque}, {"mask", AlphaMode::Mask}, {"blend", AlphaMode::Blend}}));
    table.read("alpha_cutoff", material.alphaCutoff, numberIn(kNotNegative));
    table.read("double_sided", material.doubleSided);
    table.read("unlit", material.unlit);
}

Material toPreset(const TomlValue &value) {
    std::vector<std::string_view> names;
    for (const MaterialPreset &preset : materialPresets()) {
        names.push_back(preset.name);
        if (preset.name == toText(value)) return preset.material;
    }
    failUnknownName(value.where, value.text, names);
}

/// Of kinds of one name the first.
BsdfType toBsdfType(const TomlValue &value) {
    Names<BsdfType> names;
    for (const BsdfInfo &kind : kBsdfs)
        if (names.empty() || names.back().first != kind.name) names.emplace_back(kind.name, kind.type);
    return toChoice(value, names);
}

Material loadMaterial(LoadContext &context, const std::string &name, const TomlValue &value) {
    TableReader table(value, "[material." + name + "]",
                      {"preset",
                       "type",
                       "metal",
                       "f0",
                       "color",
                       "alpha",
                       "rotation_deg",
                       "ior",
                       "metallic",
                       "roughness",
                       "anisotropy",
                       "poisson",
                       "masking",
                       "multiscatter",
                       "normal",
                       "bump",
                       "height",
                       "detail",
                       "facets",
                       "roughening",
                       "yield",
                       "opacity",
                       "alpha_mode",
                       "alpha_cutoff",
                       "double_sided",
                       "unlit",
                       "specular",
                       "specular_color",
                       "transmission",
                       "thin_walled",
                       "attenuation_color",
                       "attenuation_distance",
                       "clearcoat",
                       "clearcoat_roughness",
                       "clearcoat_normal",
                       "sheen_color",
                       "sheen_roughness",
                       "iridescence",
                       "iridescence_ior",
                       "iridescence_thickness"});
    Material material;
    if (const TomlValue *preset = table.find("preset")) material = toPreset(*preset);
    material.name = name;
    table.read("type", material.type, toBsdfType);
    const BsdfInfo &kind = bsdfInfo(material.type);
    const auto color = [&](const TomlValue &v) { return toReflectance(context, v); };
    if (kind.reads(kF0Key)) {
        table.exclusive("metal", "f0");
        if (const TomlValue *metal = table.find("metal")) loadMetal(*metal, material);
        if (table.find("f0") != nullptr) material.type = BsdfType::Conductor;
        table.read("f0", material.color, color);
    } else {
        table.read("color", material.color, color);
    }
    if (kind.reads(kIorKey)) table.read("ior", material.ior, numberIn(kIor));
    if (kind.microsurface) readMicrosurface(context, table, material);
    if (kind.reads(kMetallicKey)) {
        readMetallicRoughness(context, table, material);
        readLayers(context, table, material);
    }
    readSlopes(context, table, material);
    readPresence(context, table, material);
    table.finish();
    return material;
}

} // namespace

FloatParam toFloatParam(LoadContext &context, const TomlValue &value, const Range &range, double unit, double textureScale) {
    FloatParam param;
    if (isTexture(value)) {
        const TextureUse use = loadTexture(context, value, ColorSpace::Linear, textureScale);
        param = {static_cast<float>(use.scale.x * unit), use.texture, use.channel};
        if (use.scale.x != use.scale.y || use.scale.x != use.scale.z)
            failInput(value.find("scale")->where, "three scales", "one number here");
    } else {
        param.value = static_cast<float>(toNumber(value, range) * unit);
    }
    return param;
}

ColorParam toColorParam(LoadContext &context, const TomlValue &value, const Range &range) {
    ColorParam param;
    if (isTexture(value)) {
        const TextureUse use = loadTexture(context, value, ColorSpace::Auto, 1);
        if (const TomlValue *channel = value.find("channel"))
            failInput(channel->where, "a channel of a colour", "a texture without 'channel' here");
        param = {Vec3(use.scale), use.texture};
    } else {
        param.value = Vec3(toTriple(value, range));
    }
    return param;
}

void warnOfSteepNormals(LoadContext &context, const std::string &where, Index texture) {
    const Texture &normals = context.scene.textures[texture];
    if (const std::size_t count = countTooSteep(normals); count > 0)
        context.warnings.add(where + ": " + std::to_string(count) + " of " +
                             std::to_string(normals.texels.size() / static_cast<std::size_t>(normals.channels)) +
                             " normals are steeper than 84 degrees, or no normals, and are held there");
}

void loadMaterials(LoadContext &context, const TomlValue &section) {
    if (section.kind != TomlValue::Kind::Table) failInput(section.where, describe(section), "tables [material.NAME]");
    for (const TomlEntry &entry : section.entries) {
        context.scene.materials.push_back(loadMaterial(context, entry.key, entry.value));
        context.materials.emplace(entry.key, static_cast<Index>(context.scene.materials.size() - 1));
    }
}

Index defaultMaterial(LoadContext &context) {
    if (context.defaultMaterial != kNone) return context.defaultMaterial;
    Material steel;
    steel.name = "default";
    for (const Metal &metal : metals()) {
        if (metal.name != "Fe") continue;
        steel.type = BsdfType::Metal;
        steel.conductorEta = metal.eta;
        steel.conductorK = metal.k;
    }
    steel.alphaX.value = 0.08F;
    steel.alphaY.value = 0.3F;
    context.scene.materials.push_back(steel);
    return context.defaultMaterial = static_cast<Index>(context.scene.materials.size() - 1);
}

Index namedMaterial(const LoadContext &context, const TomlValue &value) {
    const auto found = context.materials.find(toText(value));
    if (found != context.materials.end()) return found->second;
    if (context.materials.empty()) failInput(value.where, quoted(value.text), "the name of a material, but there is no [material.NAME]");
    std::vector<std::string_view> names;
    for (const auto &[name, index] : context.materials) names.push_back(name);
    failUnknownName(value.where, value.text, names);
}

} // namespace taut
