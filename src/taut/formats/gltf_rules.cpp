/// Which types the members of a glTF file may have, and which of them must be there: glTF 2.0, appendix B, as two tables.

#include "taut/formats/gltf_source.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
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

/// Extensions whose members are checked; what stands in others is skipped.
constexpr auto kReadExtensions =
    std::to_array<std::string_view>({"KHR_lights_punctual", "KHR_materials_anisotropy", "KHR_materials_ior", "KHR_materials_transmission",
                                     "KHR_materials_emissive_strength", "KHR_texture_transform"});

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
     "channels"},
    {"an array of integers from 0 to 2147483647", arrayOf<isIndex>, "nodes scenes/nodes children joints"},
    {"a finite number", isFiniteNumber,
     "rotation scale metallicFactor roughnessFactor alphaCutoff emissiveStrength anisotropyStrength anisotropyRotation ior "
     "transmissionFactor yfov aspectRatio xmag ymag znear zfar intensity range innerConeAngle outerConeAngle"},
    {"an array of finite numbers", arrayOf<isFiniteNumber>, "weights matrix translation rotation scale offset"},
    {"an array of 3 finite numbers", numbers<3>, "emissiveFactor color"},
    {"an array of 4 finite numbers", numbers<4>, "baseColorFactor"},
    {"a string", isString, "name version uri mimeType type path interpolation alphaMode"},
    {"an array of strings", arrayOf<isString>, "extensionsUsed extensionsRequired"},
    {"true or false", [](const json &v) { return v.is_boolean(); }, "normalized doubleSided"},
    {"an object", isObject,
     "asset extensions sparse indices sparse/indices values target channels/target pbrMetallicRoughness baseColorTexture "
     "metallicRoughnessTexture emissiveTexture normalTexture occlusionTexture anisotropyTexture perspective orthographic spot"},
    {"an object of accessor indices", isAttributes, "attributes"},
    {"an array of objects of accessor indices", arrayOf<isAttributes>, "targets"},
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
    {"baseColorTexture metallicRoughnessTexture emissiveTexture normalTexture occlusionTexture anisotropyTexture", "index"},
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
    explicit JsonCheck(const std::string &path) : path_(path) {}

    /// `key`: under which the object, or the array that holds it, stands.
    void object(const json &value, std::string_view key, const Step &step) const {
        for (const auto &[name, member] : value.items()) {
            if (name == "extras") continue;
            const Step here{&step, name, 0};
            const auto found = rules_.find(name);
            const KeyRules *rules = found == rules_.end() ? nullptr : &found->second;
            if (rules != nullptr) checkKind(*rules, key, member, here);
            if (name == "extensions" && member.is_object()) {
                for (const std::string_view extension : kReadExtensions)
                    if (const auto read = member.find(std::string(extension)); read != member.end()) {
                        const Step inside{&here, extension, 0};
                        if (!read->is_object()) failGltf(path_, inside.text(), shortText(*read), "an object");
                        object(*read, extension, inside);
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
    const std::unordered_map<std::string_view, KeyRules> rules_ = makeRules();
};

} // namespace

void checkGltfJson(const std::string &path, const json &file) {
    if (!file.is_object()) failGltf(path, "the JSON", shortText(file), "an object");
    JsonCheck(path).object(file, "", Step{});
    const std::string version = file.contains("asset") ? file["asset"].value("version", "") : "";
    if (version.substr(0, 2) != "2.") failGltf(path, "asset.version", version.empty() ? "none" : taut::quoted(version), "'2.0'");
}

} // namespace taut
