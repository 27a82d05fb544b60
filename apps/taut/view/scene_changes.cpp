#include "scene_changes.h"

#include "taut/base/file_bytes.h"
#include "taut/base/frame_set.h"
#include "taut/formats/gltf.h"
#include "taut/images/view_transform.h"
#include "taut/scene/table_reader.h"
#include "taut/scene/toml_text.h"

#include <algorithm>
#include <charconv>
#include <filesystem>

namespace taut::app {

namespace {

constexpr std::size_t kMostChanges = 1000;
constexpr int kDeepest = 16;
constexpr std::size_t kLongestKey = 200;
constexpr std::size_t kLongestText = 20000;

bool isKey(const std::string &key) {
    return !key.empty() && key.size() <= kLongestKey && key.front() != '.' && key.back() != '.' &&
           std::all_of(key.begin(), key.end(), [](char c) {
               return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' || c == '-' || c == '.';
           });
}

std::vector<std::string> joined(const std::vector<std::string> &given, const std::vector<std::pair<std::string, std::string>> &changed) {
    std::vector<std::string> all = given;
    for (const auto &[key, text] : changed) all.push_back(key + "=" + text);
    return all;
}

/// Where a bare glTF is looked at through its own camera, a scene file must say so.
void nameCamera(TomlValue &root, const std::string &path, const Scene &scene) {
    if (!isGltfPath(path) || root.find("camera") != nullptr || !scene.camera.rig) return;
    TomlValue file;
    file.kind = TomlValue::Kind::String;
    file.text = std::filesystem::path(path).filename().string();
    TomlValue camera;
    camera.entries.push_back({"gltf", {}, std::move(file)});
    root.entries.push_back({"camera", {}, std::move(camera)});
}

/// A bare file stands on a ground; a scene file must say so.
void nameGround(TomlValue &root, const std::string &path, const Scene &scene) {
    if (lowerExtension(path) != "toml" && scene.render.ground) applyOverride(root, "render.ground=true");
}

} // namespace

const TomlValue *findKey(const TomlValue &tree, const std::string &key) {
    const TomlValue *at = &tree;
    for (std::size_t begin = 0; at != nullptr && begin <= key.size();) {
        const std::size_t dot = std::min(key.find('.', begin), key.size());
        const std::string part = key.substr(begin, dot - begin);
        begin = dot + 1;
        if (at->kind == TomlValue::Kind::Array) {
            std::size_t index = 0;
            const auto [end, error] = std::from_chars(part.data(), part.data() + part.size(), index);
            at = error == std::errc() && end == part.data() + part.size() && index < at->items.size() ? &at->items[index] : nullptr;
        } else {
            at = at->find(part);
        }
    }
    return at;
}

TomlValue withValueAt(const TomlValue *now, int frame, TomlValue value) {
    if (now == nullptr || !isKeyed(*now)) return value;
    TomlValue keys = *now;
    TomlValue number;
    number.kind = TomlValue::Kind::Integer;
    number.integer = frame;
    number.number = frame;
    TomlValue key;
    key.kind = TomlValue::Kind::Array;
    key.items = {number, std::move(value)};
    const auto place = std::find_if(keys.items.begin(), keys.items.end(), [&](const TomlValue &k) { return k.items[0].number >= frame; });
    if (place != keys.items.end() && place->items[0].number == frame)
        *place = std::move(key);
    else
        keys.items.insert(place, std::move(key));
    return keys;
}

TomlValue tomlOf(const nlohmann::json &value, const std::string &key, int depth) {
    TomlValue out;
    if (depth > kDeepest) failInput({key}, "values nested more than " + std::to_string(kDeepest) + " deep", "at most that");
    if (value.is_boolean()) {
        out.kind = TomlValue::Kind::Boolean;
        out.boolean = value.get<bool>();
    } else if (value.is_number_integer()) {
        out.kind = TomlValue::Kind::Integer;
        out.integer = value.get<std::int64_t>();
        out.number = static_cast<double>(out.integer);
    } else if (value.is_number()) {
        out.kind = TomlValue::Kind::Number;
        out.number = value.get<double>();
    } else if (value.is_string()) {
        out.kind = TomlValue::Kind::String;
        out.text = value.get<std::string>();
    } else if (value.is_array() && value.size() <= kMostChanges) {
        out.kind = TomlValue::Kind::Array;
        for (const nlohmann::json &item : value) out.items.push_back(tomlOf(item, key, depth + 1));
    } else if (value.is_object() && value.size() <= kMostChanges) {
        out.isInline = true;
        for (const auto &[name, item] : value.items()) out.entries.push_back({name, {}, tomlOf(item, key, depth + 1)});
    } else {
        failInput({key}, value.type_name(), "a number, a text, true or false, or an array or table of them");
    }
    return out;
}

SceneChanges::SceneChanges(SceneArguments arguments, Warnings &warnings) : arguments_(std::move(arguments)) {
    if (!arguments_.frames.empty()) {
        if (arguments_.frames != "clip") parseFrameSet(arguments_.frames, {"--frames"});
        arguments_.overrides.push_back("render.frames=\"" + arguments_.frames + "\"");
    }
    whole_ = loadScene(arguments_.scene, arguments_.overrides, warnings, *cache_, true, budgetOf(arguments_));
    ground_ = standOnGround(*whole_, warnings);
    // A camera that is said would lay it down again (ground.h).
    if (ground_ && ground_->yUp) changed_.emplace_back("mesh.0.up", "\"y\"");
    const std::vector<std::string> all = overrides();
    scene_ = loadScene(arguments_.scene, all, warnings, *cache_, false);
    if (ground_) standOn(*ground_, scene_);
    const ViewTransform trial(scene_.image.view);
    tree_ = treeWith(all);
    touched_.everything = true;
}

/// Where surfaces stay where they are, and the camera is not framed by them, all points need not be looked at again.
std::optional<Ground> SceneChanges::groundFor(const Scene &scene, const Touched &touched) const {
    if (!ground_ || touched.everything || touched.motion || (touched.camera && scene.unsaid.camera)) return groundOf(scene);
    std::optional<Ground> ground = ground_;
    widen(scene, *ground);
    return ground;
}

TomlValue SceneChanges::treeWith(const std::vector<std::string> &overrides) const {
    TomlValue tree = sceneTree(arguments_.scene);
    for (const std::string &text : overrides) applyOverride(tree, text);
    return tree;
}

std::vector<std::string> SceneChanges::overrides() const {
    return joined(arguments_.overrides, changed_);
}

/// The TOML of a change; none: it takes the override back.
std::optional<std::string> SceneChanges::textOf(const nlohmann::json &change, const std::string &key, const Overrides &so,
                                                int frame) const {
    const auto text = change.find("text");
    const auto value = change.find("value");
    if (text == change.end() && value == change.end()) failInput({key}, "neither value nor text", "one of them");
    const nlohmann::json &given = text != change.end() ? *text : *value;
    if (given.is_null()) return std::nullopt;
    if (text != change.end() && !given.is_string()) failInput({key}, given.type_name(), "a text");
    std::string toml;
    if (text != change.end()) {
        toml = given.get<std::string>();
    } else {
        TomlValue made = tomlOf(given, key);
        const auto atFrame = change.find("atFrame");
        if (atFrame != change.end() && !atFrame->is_boolean())
            failInput({key}, std::string("atFrame of ") + atFrame->type_name(), "true or false");
        if (atFrame != change.end() && atFrame->get<bool>()) {
            const TomlValue tree = treeWith(joined(arguments_.overrides, so));
            made = withValueAt(findKey(tree, key), frame, std::move(made));
        }
        toml = tomlInline(made);
    }
    const auto isControl = [](unsigned char c) { return c < 0x20; };
    if (std::any_of(toml.begin(), toml.end(), isControl)) failInput({key}, quoted(std::string_view(toml)), "one line");
    if (toml.size() > kLongestText) failInput({key}, "a value of " + std::to_string(toml.size()) + " bytes", "a shorter one");
    return toml;
}

nlohmann::json SceneChanges::apply(const nlohmann::json &changes, int frame) {
    if (!changes.is_array() || changes.size() > kMostChanges) failInput({"changes"}, changes.type_name(), "an array of changes");
    Overrides next = changed_;
    nlohmann::json undo = nlohmann::json::array();
    Touched touched;
    for (const nlohmann::json &change : changes) {
        if (!change.is_object() || !change.contains("key") || !change["key"].is_string())
            failInput({"changes"}, "one without a key", "{\"key\": ..., \"value\": ...}");
        const std::string key = change["key"].get<std::string>();
        if (!isKey(key)) failInput({"changes"}, quoted(key), "a dotted key such as material.brushed.alpha");
        const std::optional<std::string> text = textOf(change, key, next, frame);
        const auto known = std::find_if(next.begin(), next.end(), [&](const auto &entry) { return entry.first == key; });
        const std::optional<std::string> before = known != next.end() ? std::optional(known->second) : std::nullopt;
        if (text == before) continue;
        nlohmann::json back = nlohmann::json::object();
        back["key"] = key;
        back["text"] = before ? nlohmann::json(*before) : nlohmann::json();
        undo.insert(undo.begin(), std::move(back));
        touched.add(key);
        if (!text)
            next.erase(known);
        else if (before)
            known->second = *text;
        else
            next.emplace_back(key, *text);
    }
    if (next.size() > kMostChanges) failInput({"changes"}, std::to_string(next.size()) + " of them", "at most a thousand");
    const std::vector<std::string> all = joined(arguments_.overrides, next);
    if (!undo.empty()) whole_.reset();
    Warnings warnings;
    Scene scene = loadScene(arguments_.scene, all, warnings, *cache_, false);
    if (!(scene.image == scene_.image)) const ViewTransform trial(scene.image.view);
    ground_ = groundFor(scene, touched);
    if (ground_) standOn(*ground_, scene);
    tree_ = treeWith(all);
    scene_ = std::move(scene);
    changed_ = std::move(next);
    touched_ += touched;
    return undo;
}

Scene SceneChanges::load(const Touched &touched, bool follow) {
    if (follow && whole_) return *std::exchange(whole_, std::nullopt);
    whole_.reset();
    std::vector<std::string> all = overrides();
    if (const TomlValue *meshes = follow ? nullptr : tree_.find("mesh"))
        for (std::size_t i = 0; i < meshes->items.size(); ++i) all.push_back("mesh." + std::to_string(i) + ".follow=false");
    Warnings warnings;
    Scene scene = loadScene(arguments_.scene, all, warnings, *cache_, touched.everything || touched.environment || touched.lights);
    if (ground_) standOn(*ground_, scene);
    return scene;
}

std::string SceneChanges::sceneText() const {
    TomlValue root = tree_;
    nameCamera(root, arguments_.scene, scene_);
    nameGround(root, arguments_.scene, scene_);
    std::string text = "# Saved by taut view.\n";
    text += "\n" + tomlText(root);
    return text;
}

} // namespace taut::app
