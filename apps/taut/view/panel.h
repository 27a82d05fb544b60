#pragma once
/// What a page can turn in a scene: made from the scene itself.

#include "scene_changes.h"

namespace taut::app {

/// An array of entries: "key" as after -D; "group" and "label"; "kind": number, numbers, bool or choice; "value" at the frame; "min", "max"
/// and "step" of its slider; "names" of a choice; "keyed": [[frame, value], ...], null where it is constant. A value that is a texture, or
/// comes from a glTF file, has no entry.
nlohmann::json panelOf(const SceneChanges &changes, int frame);

/// The camera at a frame: "position", "look_at", "up", "fov_deg" or "ortho_height", "aperture_radius", "focus_distance".
nlohmann::json cameraOf(const Scene &scene, int frame);

} // namespace taut::app
