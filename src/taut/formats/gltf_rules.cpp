/// Which members the objects of a glTF file have, of which types, and which of them must be there: glTF 2.0 and its extensions, as three
/// tables.

#include "taut/formats/gltf_source.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <set>
#include <unordered_map>
#include <utility>

namespace taut {

namespace {

using nlohmann::json;

/// Where we are in the tree; written out only when something is wrong.
struct Step {
    const Step *parent = nullptr;
    std::string_view key;  ///< of a member
    std::size_t index = 0; ///< of an array's element, where `key` is empty
    [[nodiscard]] std::string text() const {
        if (parent == nullptr) return std::string(key);
        const std::string before = parent->text();
        if (key.empty()) return jsonPath(before, index);
        return before.empty() ? std::string(key) : before + "." + std::string(key);
    }
};

/// Extensions that are applied. Their members are checked; what stands in others is skipped.
constexpr auto kExtensions = std::to_array<std::string_view>(
    {"EXT_mesh_gpu_instancing", "EXT_texture_webp", "KHR_lights_punctual", "KHR_materials_anisotropy", "KHR_materials_clearcoat",
     "KHR_materials_emissive_strength", "KHR_materials_ior", "KHR_materials_iridescence", "KHR_materials_sheen", "KHR_materials_specular",
     "KHR_materials_transmission", "KHR_materials_unlit", "KHR_materials_variants", "KHR_materials_volume", "KHR_mesh_quantization",
     "KHR_texture_transform"});

bool isIndex(const json &value) {
    return value.is_number_unsigned() && value.get<std::uint64_t>() <= static_cast<std::uint64_t>(std::numeric_limits<int>::max());
}
bool isFiniteNumber(const json &value) {
    return value.is_number() && std::fabs(value.get<double>()) <= static_cast<double>(std::numeric_limits<float>::max());
}
template <class Container, class F> bool all(const Container &container, F is) {
    for (const auto &value : container)
        if (!is(value)) return false;
    return true;
}

template <auto is> bool arrayOf(const json &value) {
    return value.is_array() && all(value, is);
}
template <std::size_t size> bool numbers(const json &value) {
    return arrayOf<isFiniteNumber>(value) && value.size() == size;
}
bool isObject(const json &value) {
    return value.is_object();
}
bool isString(const json &value) {
    return value.is_string();
}
bool isAttributes(const json &value) {
    return value.is_object() && all(value, isIndex);
}

/// What members may be. Keys stand apart by blanks; "holder/key" is a member of objects that stand, alone or in an array, under
/// the key `holder` ("" for the file), where another rule holds than for that key elsewhere.
struct Kind {
    std::string_view words;
    bool (*is)(const json &);
    std::string_view keys;
};
constexpr auto kKinds = std::to_array<Kind>({
    {"an integer from 0 to 2147483647", isIndex,
     "scene buffer bufferView byteOffset byteLength byteStride componentType count indices primitives/indices material mode mesh skin "
     "camera "
     "light inverseBindMatrices skeleton sampler target node input output index texCoord source wrapS wrapT magFilter minFilter"},
    {"a multiple of 4 from 0 to 252", [](const json &v) { return isIndex(v) && v.get<int>() <= 252 && v.get<int>() % 4 == 0; },
     "bufferViews/byteStride"},
    {"an array of objects", arrayOf<isObject>,
     "scenes nodes /nodes meshes skins animations materials textures images samplers cameras lights accessors bufferViews buffers "
     "primitives "
     "channels mappings KHR_materials_variants/variants"},
    {"an array of integers from 0 to 2147483647", arrayOf<isIndex>, "nodes scenes/nodes children joints mappings/variants"},
    {"a finite number", isFiniteNumber,
     "rotation scale metallicFactor roughnessFactor alphaCutoff emissiveStrength anisotropyStrength anisotropyRotation ior "
     "transmissionFactor thicknessFactor attenuationDistance specularFactor clearcoatFactor clearcoatRoughnessFactor "
     "sheenRoughnessFactor iridescenceFactor iridescenceIor iridescenceThicknessMinimum iridescenceThicknessMaximum yfov aspectRatio xmag "
     "ymag znear zfar intensity range innerConeAngle outerConeAngle"},
    {"an array of finite numbers", arrayOf<isFiniteNumber>, "weights matrix translation rotation scale offset"},
    {"an array of 3 finite numbers", numbers<3>, "emissiveFactor color attenuationColor specularColorFactor sheenColorFactor"},
    {"an array of 4 finite numbers", numbers<4>, "baseColorFactor"},
    {"a string", isString, "name version minVersion uri mimeType type path interpolation alphaMode"},
    {"an array of strings", arrayOf<isString>, "extensionsUsed extensionsRequired"},
    {"true or false", [](const json &v) { return v.is_boolean(); }, "normalized doubleSided"},
    {"an object", isObject,
     "asset extensions sparse indices sparse/indices values target channels/target pbrMetallicRoughness baseColorTexture "
     "metallicRoughnessTexture emissiveTexture normalTexture occlusionTexture anisotropyTexture transmissionTexture thicknessTexture "
     "specularTexture specularColorTexture clearcoatTexture clearcoatRoughnessTexture clearcoatNormalTexture sheenColorTexture "
     "sheenRoughnessTexture iridescenceTexture iridescenceThicknessTexture perspective orthographic spot"},
    {"an object of accessor indices", isAttributes, "attributes"},
    {"an array of objects of accessor indices", arrayOf<isAttributes>, "targets"},
});

/// Keys of references to textures.
constexpr std::string_view kTextureKeys =
    "baseColorTexture metallicRoughnessTexture emissiveTexture normalTexture occlusionTexture anisotropyTexture transmissionTexture "
    "thicknessTexture specularTexture specularColorTexture clearcoatTexture clearcoatRoughnessTexture clearcoatNormalTexture "
    "sheenColorTexture sheenRoughnessTexture iridescenceTexture iridescenceThicknessTexture";

/// All members of the objects that stand under a key, beside `extensions` and `extras`. What else stands there is of a later version
/// or nobody's: it is passed over, whatever it is, and counted.
struct Members {
    std::string_view keys, members;
};
constexpr auto kMembers = std::to_array<Members>({
    {"", "extensionsUsed extensionsRequired accessors animations asset buffers bufferViews cameras images materials meshes nodes "
         "samplers scene scenes skins textures"},
    {"asset", "copyright generator version minVersion"},
    {"accessors", "bufferView byteOffset componentType normalized count type max min sparse name"},
    {"sparse", "count indices values"},
    {"indices", "bufferView byteOffset componentType"},
    {"values", "bufferView byteOffset"},
    {"animations", "channels samplers name"},
    {"channels", "sampler target"},
    {"target", "node path"},
    {"samplers", "input interpolation output magFilter minFilter wrapS wrapT name"},
    {"buffers", "uri byteLength name"},
    {"bufferViews", "buffer byteOffset byteLength byteStride target name"},
    {"cameras", "orthographic perspective type name"},
    {"perspective", "aspectRatio yfov zfar znear"},
    {"orthographic", "xmag ymag zfar znear"},
    {"images", "uri mimeType bufferView name"},
    {"materials", "pbrMetallicRoughness normalTexture occlusionTexture emissiveTexture emissiveFactor alphaMode alphaCutoff doubleSided "
                  "name"},
    {"pbrMetallicRoughness", "baseColorFactor baseColorTexture metallicFactor roughnessFactor metallicRoughnessTexture"},
    {kTextureKeys, "index texCoord scale strength"},
    {"meshes", "primitives weights name"},
    {"primitives", "attributes indices material mode targets"},
    {"nodes", "camera children skin matrix mesh rotation scale translation weights name"},
    {"scenes", "nodes name"},
    {"skins", "inverseBindMatrices skeleton joints name"},
    {"textures", "sampler source name"},
    {"KHR_texture_transform", "offset rotation scale texCoord"},
    {"KHR_lights_punctual", "lights light"},
    {"lights", "name color intensity type range spot"},
    {"spot", "innerConeAngle outerConeAngle"},
    {"EXT_texture_webp", "source"},
    {"EXT_mesh_gpu_instancing", "attributes"},
    {"KHR_materials_anisotropy", "anisotropyStrength anisotropyRotation anisotropyTexture"},
    {"KHR_materials_clearcoat", "clearcoatFactor clearcoatTexture clearcoatRoughnessFactor clearcoatRoughnessTexture "
                                "clearcoatNormalTexture"},
    {"KHR_materials_emissive_strength", "emissiveStrength"},
    {"KHR_materials_ior", "ior"},
    {"KHR_materials_iridescence", "iridescenceFactor iridescenceTexture iridescenceIor iridescenceThicknessMinimum "
                                  "iridescenceThicknessMaximum iridescenceThicknessTexture"},
    {"KHR_materials_sheen", "sheenColorFactor sheenColorTexture sheenRoughnessFactor sheenRoughnessTexture"},
    {"KHR_materials_specular", "specularFactor specularTexture specularColorFactor specularColorTexture"},
    {"KHR_materials_transmission", "transmissionFactor transmissionTexture"},
    {"KHR_materials_unlit", ""},
    {"KHR_materials_variants", "variants mappings"},
    {"mappings", "material variants name"},
    {"variants", "name"},
    {"KHR_materials_volume", "thicknessFactor thicknessTexture attenuationDistance attenuationColor"},
});

/// Members that an object must have, by the key under which it (or the array that holds it) stands.
struct Requirement {
    std::string_view keys, members;
};
constexpr auto kRequirements = std::to_array<Requirement>({
    {"accessors", "componentType count type"},
    {"bufferViews", "buffer byteLength"},
    {"buffers", "byteLength"},
    {"sparse", "count indices values"},
    {"indices", "bufferView componentType"},
    {"values", "bufferView"},
    {"meshes", "primitives"},
    {"primitives", "attributes"},
    {"skins", "joints"},
    {"channels", "sampler target"},
    {"target", "path"},
    {"animations/samplers", "input output"},
    {kTextureKeys, "index"},
    {"mappings", "material variants"},
    {"EXT_mesh_gpu_instancing", "attributes"},
    {"cameras lights", "type"},
    {"perspective", "yfov znear"},
    {"orthographic", "xmag ymag zfar znear"},
});

/// The rules of one key, by holder.
constexpr std::string_view kAnyHolder = "*";
struct KeyRules {
    std::vector<std::pair<std::string_view, const Kind *>> kinds;
    std::vector<std::pair<std::string_view, std::string_view>> required;
};

template <class F> void forEachWord(std::string_view words, const F &f) {
    while (!words.empty()) {
        const std::size_t end = std::min(words.find(' '), words.size());
        f(words.substr(0, end));
        words.remove_prefix(std::min(end + 1, words.size()));
    }
}

/// The members of objects by the key under which they stand.
std::unordered_map<std::string_view, std::set<std::string_view>> makeMembers() {
    std::unordered_map<std::string_view, std::set<std::string_view>> members;
    for (const Members &entry : kMembers) {
        std::set<std::string_view> names{"extensions", "extras"};
        forEachWord(entry.members, [&](std::string_view member) { names.insert(member); });
        if (entry.keys.empty()) members.emplace("", names);
        forEachWord(entry.keys, [&](std::string_view key) { members.emplace(key, names); });
    }
    return members;
}

std::unordered_map<std::string_view, KeyRules> makeRules() {
    std::unordered_map<std::string_view, KeyRules> rules;
    const auto forEachKey = [&](std::string_view keys, const auto &f) {
        forEachWord(keys, [&](std::string_view word) {
            const std::size_t slash = word.find('/');
            const bool held = slash != std::string_view::npos;
            f(held ? word.substr(0, slash) : kAnyHolder, rules[held ? word.substr(slash + 1) : word]);
        });
    };
    for (const Kind &kind : kKinds)
        forEachKey(kind.keys, [&](std::string_view holder, KeyRules &rule) { rule.kinds.emplace_back(holder, &kind); });
    for (const Requirement &requirement : kRequirements)
        forEachKey(requirement.keys, [&](std::string_view holder, KeyRules &rule) {
            forEachWord(requirement.members, [&](std::string_view member) { rule.required.emplace_back(holder, member); });
        });
    return rules;
}

/// A short picture of a value for an error.
std::string shortText(const json &value) {
    if (value.is_object()) return "an object";
    if (value.is_array() && value.size() > 4) return "an array of " + std::to_string(value.size()) + " elements";
    return taut::quoted(value.dump());
}

class JsonCheck {
  public:
    JsonCheck(const std::string &path, Tally &leftOut) : path_(path), leftOut_(leftOut) {}

    /// `key`: under which the object, or the array that holds it, stands.
    void object(const json &value, std::string_view key, const Step &step) const {
        const auto known = members_.find(key);
        for (const auto &[name, member] : value.items()) {
            if (name == "extras") continue;
            if (known != members_.end() && known->second.count(name) == 0) {
                leftOut_.add("member " + taut::quoted(name));
                continue;
            }
            const Step here{&step, name, 0};
            const KeyRules *rules = ruleOf(name);
            if (rules != nullptr) checkKind(*rules, key, member, here);
            if (name == "extensions" && member.is_object()) {
                for (const auto &[extension, content] : member.items()) {
                    if (!isKnownExtension(extension)) {
                        leftOut_.add("extension " + taut::quoted(extension));
                        continue;
                    }
                    const Step inside{&here, extension, 0};
                    if (!content.is_object()) failGltf(path_, inside.text(), shortText(content), "an object");
                    required(ruleOf(extension), name, content, inside);
                    object(content, extension, inside);
                }
            } else if (member.is_object()) {
                required(rules, key, member, here);
                object(member, name, here);
            } else if (member.is_array()) {
                for (std::size_t i = 0; i < member.size(); ++i) {
                    if (!member[i].is_object()) continue;
                    const Step element{&here, {}, i};
                    required(rules, key, member[i], element);
                    object(member[i], name, element);
                }
            }
        }
    }

  private:
    [[nodiscard]] const KeyRules *ruleOf(std::string_view name) const {
        const auto found = rules_.find(name);
        return found == rules_.end() ? nullptr : &found->second;
    }

    void checkKind(const KeyRules &rules, std::string_view holder, const json &value, const Step &here) const {
        const bool held = std::any_of(rules.kinds.begin(), rules.kinds.end(), [&](const auto &rule) { return rule.first == holder; });
        std::string expected;
        for (const auto &[ofHolder, kind] : rules.kinds) {
            if (ofHolder != (held ? holder : kAnyHolder)) continue;
            if (kind->is(value)) return;
            expected += (expected.empty() ? "" : " or ") + std::string(kind->words);
        }
        if (!expected.empty()) failGltf(path_, here.text(), shortText(value), expected);
    }

    void required(const KeyRules *rules, std::string_view holder, const json &value, const Step &here) const {
        if (rules == nullptr) return;
        for (const auto &[ofHolder, member] : rules->required) {
            if ((ofHolder != kAnyHolder && ofHolder != holder) || value.contains(std::string(member))) continue;
            std::vector<std::string_view> names;
            for (const auto &entry : value.get_ref<const json::object_t &>()) names.push_back(entry.first);
            const std::string_view nearest = nearestName(member, names);
            failGltf(path_, here.text(),
                     "no member " + taut::quoted(member) + (nearest.empty() ? "" : " (the nearest is " + taut::quoted(nearest) + ")"),
                     taut::quoted(member));
        }
    }

    const std::string &path_;
    Tally &leftOut_;
    const std::unordered_map<std::string_view, KeyRules> rules_ = makeRules();
    const std::unordered_map<std::string_view, std::set<std::string_view>> members_ = makeMembers();
};

/// Whether a version "major.minor" is one that this reader may read.
bool isUpTo20(const std::string &version) {
    return version.substr(0, 2) == "1." || version == "2.0";
}

} // namespace

bool isKnownExtension(std::string_view name) {
    return std::find(kExtensions.begin(), kExtensions.end(), name) != kExtensions.end();
}

std::span<const std::string_view> knownExtensions() {
    return kExtensions;
}

void checkGltfJson(const std::string &path, const json &file, Tally &leftOut) {
    if (!file.is_object()) failGltf(path, "the JSON", shortText(file), "an object");
    JsonCheck(path, leftOut).object(file, "", Step{});
    const auto ofAsset = [&](const char *key) { return file.contains("asset") ? file["asset"].value(key, "") : ""; };
    const std::string version = ofAsset("version");
    if (version.substr(0, 2) != "2.") failGltf(path, "asset.version", version.empty() ? "none" : taut::quoted(version), "'2.0'");
    if (const std::string least = ofAsset("minVersion"); !least.empty() && !isUpTo20(least))
        failGltf(path, "asset.minVersion", taut::quoted(least), "at most '2.0'");
    for (const json &extension : file.value("extensionsUsed", json::array())) {
        const std::string name = "extension " + taut::quoted(extension.get<std::string>());
        const bool counted = std::any_of(leftOut.counts.begin(), leftOut.counts.end(), [&](const auto &c) { return c.first == name; });
        if (!counted && !isKnownExtension(extension.get<std::string>())) leftOut.add(name);
    }
}

} // namespace taut
