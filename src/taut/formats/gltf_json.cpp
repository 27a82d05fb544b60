#include "taut/formats/gltf_source.h"

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

/// What a member may be: i index or count, I array of them, n number, N array of numbers, 3 and 4 an array of so many, s string, S array of
/// strings, b boolean, o object, a array of objects, m object of indices (vertex attributes), M array of such.
struct MemberRule {
    std::string_view key;
    std::string_view kinds;
};
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
    std::array<std::string_view, 3> members;
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
    {"orthographic", false, {"xmag", "ymag"}},
    {"lights", false, {"type"}},
    {"KHR_lights_punctual", true, {}},
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

bool isOfKind(const json &value, char kind) {
    const auto isAttributes = [](const json &v) { return v.is_object() && all(v, isIndex); };
    switch (kind) {
    case 'i': return isIndex(value);
    case 'I': return value.is_array() && all(value, isIndex);
    case 'n': return isFiniteNumber(value);
    case 'N': return value.is_array() && all(value, isFiniteNumber);
    case '3': return isOfKind(value, 'N') && value.size() == 3;
    case '4': return isOfKind(value, 'N') && value.size() == 4;
    case 's': return value.is_string();
    case 'S': return value.is_array() && all(value, [](const json &v) { return v.is_string(); });
    case 'b': return value.is_boolean();
    case 'o': return value.is_object();
    case 'a': return value.is_array() && all(value, [](const json &v) { return v.is_object(); });
    case 'm': return isAttributes(value);
    default: return value.is_array() && all(value, isAttributes);
    }
}

std::string_view describe(char kind) {
    switch (kind) {
    case 'i': return "an integer from 0 to 2147483647";
    case 'I': return "an array of integers from 0 to 2147483647";
    case 'n': return "a finite number";
    case 'N': return "an array of finite numbers";
    case '3': return "an array of 3 finite numbers";
    case '4': return "an array of 4 finite numbers";
    case 's': return "a string";
    case 'S': return "an array of strings";
    case 'b': return "true or false";
    case 'o': return "an object";
    case 'a': return "an array of objects";
    case 'm': return "an object of accessor indices";
    default: return "an array of objects of accessor indices";
    }
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
        for (const MemberRule &rule : kMemberRules) {
            if (rule.key != key) continue;
            std::string expected;
            for (const char kind : rule.kinds) {
                if (isOfKind(value, kind)) return;
                expected += (expected.empty() ? "" : " or ") + std::string(describe(kind));
            }
            failGltf(path_, here.text(), shortText(value), expected);
        }
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
