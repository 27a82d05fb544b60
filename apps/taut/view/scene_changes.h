#pragma once
/// What a page has changed of a scene: -D overrides by key, in the order in which keys were first changed, and the scene that they make.

#include "live_scene.h"

#include "taut/scene/ground.h"
#include "taut/scene/load_scene.h"

#include <nlohmann/json.hpp>

#include <string>
#include <utility>
#include <vector>

namespace taut::app {

class SceneChanges {
  public:
    using Overrides = std::vector<std::pair<std::string, std::string>>; ///< key, TOML

    /// Reads the scene and stands it on its ground; where that turns it, it does so by an override. Throws InputError.
    SceneChanges(SceneArguments arguments, Warnings &warnings);

    /// Takes changes in, all or none: an array of {"key": "material.brushed.alpha", "value": JSON}, or "text": TOML as after -D key=; null
    /// in either takes the override back. With "atFrame" a keyed value changes at that frame alone. Returns an array that undoes them.
    /// Throws InputError where the result is no scene.
    nlohmann::json apply(const nlohmann::json &changes, int frame);

    /// The scene as it stands, without its environment but where `touched` wants it; `follow` false: roughness held fixed everywhere.
    Scene load(const Touched &touched, bool follow);
    /// What apply() touched since the last call.
    Touched takeTouched() { return std::exchange(touched_, {}); }

    /// As it stood after the last apply(), without its environment.
    [[nodiscard]] const Scene &scene() const { return scene_; }
    /// The tree of its keys.
    [[nodiscard]] const TomlValue &tree() const { return tree_; }
    /// All overrides, those of the command line first: KEY=TOML.
    [[nodiscard]] std::vector<std::string> overrides() const;
    /// The page's alone.
    [[nodiscard]] const Overrides &changed() const { return changed_; }
    [[nodiscard]] const SceneArguments &arguments() const { return arguments_; }

    /// A scene file that renders the same picture, for the folder of the scene.
    [[nodiscard]] std::string sceneText() const;

  private:
    [[nodiscard]] std::optional<std::string> textOf(const nlohmann::json &change, const std::string &key, const Overrides &so,
                                                    int frame) const;
    [[nodiscard]] std::optional<Ground> groundFor(const Scene &scene, const Touched &touched) const;
    [[nodiscard]] TomlValue treeWith(const std::vector<std::string> &overrides) const;

    SceneArguments arguments_;
    std::shared_ptr<SceneCache> cache_ = makeSceneCache();
    Overrides changed_;
    std::optional<Ground> ground_; ///< of scene_
    std::optional<Scene> whole_;   ///< as it was first read, with its environment, until somebody wants it
    Scene scene_;
    TomlValue tree_;
    Touched touched_;
};

/// The value of a dotted key; null where there is none.
const TomlValue *findKey(const TomlValue &tree, const std::string &key);

/// [[frame, value], ...] with the value at one frame replaced, or put in; of a constant: the value alone.
TomlValue withValueAt(const TomlValue *now, int frame, TomlValue value);

/// Numbers, texts, booleans, and arrays and tables of them, not nested deeper than a scene's values are. Throws InputError for others.
TomlValue tomlOf(const nlohmann::json &value, const std::string &key, int depth = 0);

} // namespace taut::app
