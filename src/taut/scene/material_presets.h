#pragma once
/// Materials whose response to a deformation is known, as a scene file's `preset` starts from them.

#include "taut/scene/material.h"

#include <span>
#include <string_view>

namespace taut {

/// What of a preset is geometry, what is measured and what is a choice, stands beside each (docs/scene.md, "Presets, and what metal does").
struct MaterialPreset {
    std::string_view name;
    Material material;
};

/// rubber, skin, foil, annealed aluminium.
std::span<const MaterialPreset> materialPresets();

} // namespace taut
