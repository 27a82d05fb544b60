/// Which types the members of a glTF file may have, and which of them must be there: glTF 2.0, appendix B, as two tables.

#include "taut/formats/gltf_source.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

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

/// What a member may be: the letters of kKinds, any of which will do.
struct MemberRule {
    std::string_view key;
    std::string_view kinds;
};
/// Members whose kind depends on the key under which their object (or the array that holds it) stands: "" for the file.
struct HeldMemberRule {
    std::string_view holder;
    MemberRule member;
};
constexpr auto kHeldMemberRules = std::to_array<HeldMemberRule>({
    {"", {"nodes", "a"}},
    {"scenes", {"nodes", "I"}},
    {"bufferViews", {"byteStride", "t"}},
    {"primitives", {"indices", "i"}},
    {"sparse", {"indices", "o"}},
    {"channels", {"target", "o"}},
});
constexpr auto kMemberRules = std::to_array<MemberRule>({
    // the file
    {"asset", "o"},
    {"scene", "i"},
    {"scenes", "a"},
    {"nodes", "aI"},
    {"meshes", "a"},
    {"skins", "a"},
    {"animations", "a"},
    {"materials", "a"},
    {"textures", "a"},
    {"images", "a"},
    {"samplers", "a"},
    {"cameras", "a"},
    {"lights", "a"},
    {"accessors", "a"},
    {"bufferViews", "a"},
    {"buffers", "a"},
    {"extensionsUsed", "S"},
    {"extensionsRequired", "S"},
    {"extensions", "o"},
    {"name", "s"},
    {"version", "s"},
    // buffers and accessors
    {"buffer", "i"},
    {"bufferView", "i"},
    {"byteOffset", "i"},
    {"byteLength", "i"},
    {"byteStride", "i"},
    {"uri", "s"},
    {"mimeType", "s"},
    {"componentType", "i"},
    {"count", "i"},
    {"type", "s"},
    {"normalized", "b"},
    {"sparse", "o"},
    {"indices", "io"},
    {"values", "o"},
    // meshes
    {"primitives", "a"},
    {"attributes", "m"},
    {"targets", "M"},
    {"material", "i"},
    {"mode", "i"},
    {"weights", "N"},
    // nodes and skins
    {"children", "I"},
    {"mesh", "i"},
    {"skin", "i"},
    {"camera", "i"},
    {"light", "i"},
    {"matrix", "N"},
    {"translation", "N"},
    {"rotation", "nN"},
    {"scale", "nN"},
    {"joints", "I"},
    {"inverseBindMatrices", "i"},
    {"skeleton", "i"},
    // animations
    {"channels", "a"},
    {"sampler", "i"},
    {"target", "io"},
    {"node", "i"},
    {"path", "s"},
    {"input", "i"},
    {"output", "i"},
    {"interpolation", "s"},
    // materials and textures
    {"pbrMetallicRoughness", "o"},
    {"baseColorFactor", "4"},
    {"metallicFactor", "n"},
    {"roughnessFactor", "n"},
    {"emissiveFactor", "3"},
    {"baseColorTexture", "o"},
    {"metallicRoughnessTexture", "o"},
    {"emissiveTexture", "o"},
    {"normalTexture", "o"},
    {"occlusionTexture", "o"},
    {"anisotropyTexture", "o"},
    {"index", "i"},
    {"texCoord", "i"},
    {"doubleSided", "b"},
    {"alphaMode", "s"},
    {"alphaCutoff", "n"},
    {"source", "i"},
    {"wrapS", "i"},
    {"wrapT", "i"},
    {"magFilter", "i"},
    {"minFilter", "i"},
    {"emissiveStrength", "n"},
    {"anisotropyStrength", "n"},
    {"anisotropyRotation", "n"},
    {"ior", "n"},
    {"transmissionFactor", "n"},
    {"offset", "N"},
    // cameras and lights
    {"perspective", "o"},
    {"orthographic", "o"},
    {"yfov", "n"},
    {"aspectRatio", "n"},
    {"xmag", "n"},
    {"ymag", "n"},
    {"znear", "n"},
    {"zfar", "n"},
    {"color", "3"},
    {"intensity", "n"},
    {"range", "n"},
    {"spot", "o"},
    {"innerConeAngle", "n"},
    {"outerConeAngle", "n"},
});

/// Members that an object must have, by the key under which it (or the array that holds it) stands.
struct RequiredRule {
    std::string_view key;
    bool nestedOnly; ///< not for the key at the top of the file
    std::array<std::string_view, 4> members;
};
constexpr auto kRequiredRules = std::to_array<RequiredRule>({
    {"accessors", false, {"componentType", "count", "type"}},
    {"bufferViews", false, {"buffer", "byteLength"}},
    {"buffers", false, {"byteLength"}},
    {"sparse", false, {"count", "indices", "values"}},
    {"indices", false, {"bufferView", "componentType"}},
    {"values", false, {"bufferView"}},
    {"meshes", false, {"primitives"}},
    {"primitives", false, {"attributes"}},
    {"skins", false, {"joints"}},
    {"channels", false, {"sampler", "target"}},
    {"target", false, {"path"}},
    {"samplers", true, {"input", "output"}},
    {"baseColorTexture", false, {"index"}},
    {"metallicRoughnessTexture", false, {"index"}},
    {"emissiveTexture", false, {"index"}},
    {"normalTexture", false, {"index"}},
    {"occlusionTexture", false, {"index"}},
    {"anisotropyTexture", false, {"index"}},
    {"cameras", false, {"type"}},
    {"perspective", false, {"yfov", "znear"}},
    {"orthographic", false, {"xmag", "ymag", "zfar", "znear"}},
    {"lights", false, {"type"}},
});

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

/// The letters of the rules.
struct Kind {
    char letter;
    std::string_view words;
    bool (*is)(const json &);
};
constexpr auto kKinds = std::to_array<Kind>({
    {'i', "an integer from 0 to 2147483647", isIndex},
    {'I', "an array of integers from 0 to 2147483647", arrayOf<isIndex>},
    {'t', "a multiple of 4 from 0 to 252", [](const json &v) { return isIndex(v) && v.get<int>() <= 252 && v.get<int>() % 4 == 0; }},
    {'n', "a finite number", isFiniteNumber},
    {'N', "an array of finite numbers", arrayOf<isFiniteNumber>},
    {'3', "an array of 3 finite numbers", numbers<3>},
    {'4', "an array of 4 finite numbers", numbers<4>},
    {'s', "a string", isString},
    {'S', "an array of strings", arrayOf<isString>},
    {'b', "true or false", [](const json &v) { return v.is_boolean(); }},
    {'o', "an object", isObject},
    {'a', "an array of objects", arrayOf<isObject>},
    {'m', "an object of accessor indices", isAttributes},
    {'M', "an array of objects of accessor indices", arrayOf<isAttributes>},
});

/// A short picture of a value for an error.
std::string shortText(const json &value) {
    if (value.is_object()) return "an object";
    if (value.is_array() && value.size() > 4) return "an array of " + std::to_string(value.size()) + " elements";
    return taut::quoted(value.dump());
}

class JsonCheck {
  public:
    explicit JsonCheck(const std::string &path) : path_(path) {}

    void object(const json &value, const Step &step) const {
        for (const auto &[key, member] : value.items()) {
            const Step here{&step, key, 0};
            if (key == "extras") continue;
            checkMember(key, member, here);
            if (key == "extensions" && member.is_object()) {
                for (const std::string_view extension : kReadExtensions)
                    if (const auto found = member.find(std::string(extension)); found != member.end()) {
                        const Step inside{&here, extension, 0};
                        if (!found->is_object()) failGltf(path_, inside.text(), shortText(*found), "an object");
                        object(*found, inside);
                    }
            } else {
                descend(member, key, here);
            }
        }
    }

  private:
    void checkMember(std::string_view key, const json &value, const Step &here) const {
        for (const HeldMemberRule &rule : kHeldMemberRules)
            if (rule.member.key == key && rule.holder == holderOf(here).key) return checkKind(rule.member, value, here);
        for (const MemberRule &rule : kMemberRules)
            if (rule.key == key) checkKind(rule, value, here);
    }

    void checkKind(const MemberRule &rule, const json &value, const Step &here) const {
        std::string expected;
        for (const char letter : rule.kinds) {
            const Kind &kind = *std::find_if(kKinds.begin(), kKinds.end(), [&](const Kind &k) { return k.letter == letter; });
            if (kind.is(value)) return;
            expected += (expected.empty() ? "" : " or ") + std::string(kind.words);
        }
        failGltf(path_, here.text(), shortText(value), expected);
    }

    /// The key of the object that has the member `here`, or of the array that holds that object.
    static const Step &holderOf(const Step &here) {
        const Step &object = *here.parent;
        return object.key.empty() && object.parent != nullptr ? *object.parent : object;
    }

    void descend(const json &value, std::string_view key, const Step &here) const {
        if (value.is_object()) {
            require(value, key, here);
            object(value, here);
        } else if (value.is_array()) {
            for (std::size_t i = 0; i < value.size(); ++i)
                if (value[i].is_object()) {
                    const Step element{&here, {}, i};
                    require(value[i], key, element);
                    object(value[i], element);
                }
        }
    }

    void require(const json &value, std::string_view key, const Step &here) const {
        const Step *holder = here.key.empty() ? here.parent->parent : here.parent;
        for (const RequiredRule &rule : kRequiredRules) {
            if (rule.key != key || (rule.nestedOnly && holder->parent == nullptr)) continue;
            for (const std::string_view member : rule.members)
                if (!member.empty() && !value.contains(std::string(member))) {
                    std::vector<std::string> present;
                    for (const auto &[name, unused] : value.items()) present.push_back(name);
                    const std::vector<std::string_view> names(present.begin(), present.end());
                    const std::string_view nearest = nearestName(member, names);
                    failGltf(path_, here.text(),
                             "no member " + taut::quoted(member) +
                                 (nearest.empty() ? "" : " (the nearest is " + taut::quoted(nearest) + ")"),
                             taut::quoted(member));
                }
        }
    }

    const std::string &path_;
};

} // namespace

void checkGltfJson(const std::string &path, const json &file) {
    if (!file.is_object()) failGltf(path, "the JSON", shortText(file), "an object");
    JsonCheck(path).object(file, Step{});
    const std::string version = file.contains("asset") ? file["asset"].value("version", "") : "";
    if (version.substr(0, 2) != "2.") failGltf(path, "asset.version", version.empty() ? "none" : taut::quoted(version), "'2.0'");
}

} // namespace taut
