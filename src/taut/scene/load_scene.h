#pragma once
/// From a path to a Scene: a scene TOML, a .glb / .gltf, or a bare mesh. Every key is documented in docs/scene.md.

#include "taut/base/error.h"
#include "taut/scene/scene.h"
#include "taut/scene/toml_value.h"

#include <map>
#include <memory>
#include <string>
#include <vector>

namespace taut {

/// Reads a scene. `overrides` are "key.path=value" (TOML values, e.g. render.width=320, mesh.0.follow=false,
/// material.brushed.alpha=[0.1,0.3]) applied on top of the file. A .glb/.gltf or a mesh is read as a scene whose only entry
/// is that [[mesh]]: its own camera and lights where it has them, else a framed camera and the built-in studio.
/// Throws InputError for anything malformed: unknown keys (with the nearest valid one), wrong types, values out of range,
/// missing files, in the TOML or in any file that it names.
/// What they ask for is counted together and must stay within `budget`, which goes on with the scene (null: the default one).
Scene loadScene(const std::string &path, const std::vector<std::string> &overrides, Warnings &warnings,
                std::shared_ptr<Budget> budget = nullptr);

/// What has been read for a scene, kept for its next loading with other overrides: meshes, glTF files and textures are not read again,
/// whatever became of their files, and what was said of them is not said again.
struct SceneCache;
std::shared_ptr<SceneCache> makeSceneCache();
/// `environment` false: that of the scene is not looked at, a white one stands for it. `budget`: of the first loading with a cache, whose
/// limit the others keep.
Scene loadScene(const std::string &path, const std::vector<std::string> &overrides, Warnings &warnings, SceneCache &cache,
                bool environment = true, std::shared_ptr<Budget> budget = nullptr);

/// The tree of keys that a scene's path stands for: a scene file's, or that of one [[mesh]]. Throws InputError.
TomlValue sceneTree(const std::string &path);

/// A mesh that a program brings along instead of a file.
struct GivenMesh {
    std::shared_ptr<const Mesh> mesh;
    std::shared_ptr<const PointSource> points; ///< null: it does not move by itself
};

/// A scene file that a program made: a tree of keys, in which `file` of a [[mesh]] may name a given mesh.
struct SceneTree {
    TomlValue root;                          ///< places of its values are what errors name
    std::string name;                        ///< what Scene::path is
    std::string folder;                      ///< relative paths start here
    std::map<std::string, GivenMesh> meshes; ///< by the text of `file`
};
Scene loadScene(SceneTree tree, const std::vector<std::string> &overrides, Warnings &warnings, std::shared_ptr<Budget> budget = nullptr);

/// Image settings with what a table says that is written as a scene file's [image]. Throws InputError. `folder`: its relative paths' start.
ImageSettings readImageSettings(const TomlValue &section, ImageSettings settings, const std::string &folder);

} // namespace taut
