#include "mutate.h"

#include <nlohmann/json.hpp>

#include <array>
#include <cstring>

namespace taut::fuzz {

namespace {

using nlohmann::json;

/// Members that glTF files have and the reader looks at.
constexpr std::array kKeys{
    "accessors",  "bufferViews", "buffers",   "meshes",     "nodes",      "scenes",     "scene",       "skins",     "animations", "materials",
    "textures",   "samplers",    "images",    "cameras",    "extensions", "extras",     "extensionsUsed", "extensionsRequired", "asset", "minVersion",
    "bufferView", "byteOffset",  "byteLength", "byteStride", "componentType", "count",  "type",        "normalized", "sparse",    "indices",
    "values",     "uri",         "mimeType",  "primitives", "attributes", "POSITION",   "NORMAL",      "TANGENT",   "TEXCOORD_0", "TEXCOORD_1",
    "COLOR_0",    "JOINTS_0",    "WEIGHTS_0", "JOINTS_1",   "WEIGHTS_1",  "_TAUT_M",    "_TAUT_LEAN",  "mode",      "material",   "targets",
    "weights",    "mesh",        "skin",      "camera",     "children",   "matrix",     "translation", "rotation",  "scale",      "joints",
    "skeleton",   "inverseBindMatrices", "channels", "sampler", "target", "node",       "path",        "input",     "output",     "interpolation",
    "pbrMetallicRoughness", "baseColorFactor", "baseColorTexture", "metallicFactor", "roughnessFactor", "metallicRoughnessTexture",
    "normalTexture", "occlusionTexture", "emissiveTexture", "emissiveFactor", "alphaMode", "alphaCutoff", "doubleSided", "index", "texCoord",
    "source", "wrapS", "wrapT", "magFilter", "minFilter", "perspective", "orthographic", "yfov", "aspectRatio", "znear", "zfar", "xmag", "ymag",
    "KHR_lights_punctual", "lights", "light", "color", "intensity", "range", "spot", "innerConeAngle", "outerConeAngle",
    "KHR_materials_variants", "variants", "mappings", "EXT_mesh_gpu_instancing", "TRANSLATION", "ROTATION", "SCALE", "KHR_texture_transform",
    "offset", "KHR_materials_ior", "ior", "KHR_materials_specular", "KHR_materials_transmission", "KHR_materials_volume",
    "KHR_materials_clearcoat", "KHR_materials_sheen", "KHR_materials_iridescence", "KHR_materials_anisotropy", "KHR_materials_unlit",
    "KHR_materials_emissive_strength", "KHR_mesh_quantization", "EXT_texture_webp", "targetNames", "name", "version"};

constexpr std::array kTexts{"SCALAR", "VEC2", "VEC3", "VEC4", "MAT4", "LINEAR", "STEP", "CUBICSPLINE", "translation", "rotation", "scale",
                            "weights", "perspective", "orthographic", "OPAQUE", "MASK", "BLEND", "point", "spot", "directional", "image/png",
                            "data:,", "data:;base64,AAAA", "%00", "a%20b.png", "../x", "2.0", "", "KHR_materials_unlit", "no_such"};

json oddValue(Dice &dice) {
    static constexpr std::array kIntegers{0LL, 1LL, 2LL, 3LL, 4LL, 5LL, 6LL, -1LL, 255LL, 5120LL, 5121LL, 5122LL, 5123LL, 5125LL, 5126LL,
                                          65535LL, 65536LL, 2147483647LL, 2147483648LL, 4294967295LL, 4294967296LL, 1LL << 53, -(1LL << 62)};
    static constexpr std::array kNumbers{0.0, -0.0, 0.5, 1.0, -1.0, 1e-30, 1e30, 3e38, 1e300, -1e-300};
    switch (dice.below(7)) {
    case 0: return kNumbers[dice.below(kNumbers.size())];
    case 1: return kTexts[dice.below(kTexts.size())];
    case 2: return dice.chance(50);
    case 3: return nullptr;
    case 4: return dice.chance(50) ? json::array() : json::object();
    default: return kIntegers[dice.below(kIntegers.size())];
    }
}

/// All values of the tree, its root first.
void collect(json &value, std::vector<json *> &all) {
    all.push_back(&value);
    if (value.is_structured())
        for (json &child : value) collect(child, all);
}

void changeTree(json &root, Dice &dice) {
    std::vector<json *> all;
    collect(root, all);
    json &value = *all[dice.below(all.size())];
    const json other = *all[dice.below(all.size())];
    switch (dice.below(8)) {
    case 0: value = oddValue(dice); return;
    case 1: value = other; return;
    case 2:
        if (value.is_object()) value[kKeys[dice.below(kKeys.size())]] = dice.chance(50) ? other : oddValue(dice);
        if (value.is_array()) value.push_back(dice.chance(50) ? other : oddValue(dice));
        return;
    case 3:
        if (value.is_object() && !value.empty()) value.erase(std::next(value.begin(), static_cast<std::ptrdiff_t>(dice.below(value.size()))));
        if (value.is_array() && !value.empty()) value.erase(dice.below(value.size()));
        return;
    case 4:
        if (value.is_array() && !value.empty() && value.size() < 4096) {
            const json element = value[dice.below(value.size())];
            for (std::size_t i = 1U << dice.below(8); i > 0; --i) value.push_back(element);
        }
        return;
    case 5:
        if (value.is_number_integer()) value = value.get<long long>() + static_cast<long long>(dice.below(9)) - 4;
        else if (value.is_number()) value = value.get<double>() * (dice.chance(50) ? -1 : 1e3);
        return;
    case 6:
        if (value.is_string()) value = kTexts[dice.below(kTexts.size())];
        return;
    default:
        if (value.is_structured() && value.size() > 1) {
            const auto at = [&] { return std::next(value.begin(), static_cast<std::ptrdiff_t>(dice.below(value.size()))); };
            std::swap(*at(), *at());
        }
    }
}

std::string dumped(const json &root) {
    return root.dump(-1, ' ', false, json::error_handler_t::replace);
}

std::uint32_t wordAt(std::string_view bytes, std::size_t at) {
    std::uint32_t word = 0;
    if (at + 4 <= bytes.size()) std::memcpy(&word, bytes.data() + at, 4);
    return word;
}

void appendWord(std::string &out, std::size_t value) {
    const auto word = static_cast<std::uint32_t>(value);
    char raw[4];
    std::memcpy(raw, &word, 4);
    out.append(raw, 4);
}

} // namespace

std::string mutatedJson(std::string_view text, Dice &dice) {
    json root = json::parse(text, nullptr, false);
    if (root.is_discarded()) return {};
    for (std::size_t i = 1 + dice.below(4); i > 0; --i) changeTree(root, dice);
    return dumped(root);
}

std::string mutatedGlb(std::string_view bytes, Dice &dice, const ChangeBytes &change) {
    const std::size_t length = wordAt(bytes, 12);
    if (bytes.size() < 20 || length > bytes.size() - 20) return {};
    std::string text(bytes.substr(20, length));
    std::string data(bytes.size() > 28 + length ? bytes.substr(28 + length) : "");
    if (dice.chance(70) || data.empty()) {
        const std::string other = mutatedJson(text, dice);
        if (other.empty()) return {};
        text = other;
    } else {
        data = change(data);
    }
    text.resize((text.size() + 3) / 4 * 4, ' ');
    data.resize((data.size() + 3) / 4 * 4, '\0');
    std::string out("glTF\2\0\0\0", 8);
    appendWord(out, 12 + 8 + text.size() + (data.empty() ? 0 : 8 + data.size()));
    appendWord(out, text.size());
    out += "JSON" + text;
    if (data.empty()) return out;
    appendWord(out, data.size());
    return out + std::string("BIN\0", 4) + data;
}

} // namespace taut::fuzz
