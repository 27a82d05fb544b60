#pragma once
/// Scenes that hold plans to their word: each is rendered with `--model full` and under a plan, with the same random numbers.

#include "taut/scene/scene.h"

#include <string>
#include <vector>

namespace taut::chart {

struct PlanScene {
    std::string name;
    Scene scene;
    double frame = 1; ///< the one that is rendered
};

/// Rigid, uniform, smooth and strongly varying stretch; skew, twist, bend, waves; rough, smooth and anisotropic conductors,
/// dielectric, coated and diffuse; leaning; subdivided.
std::vector<PlanScene> planScenes(int size);

} // namespace taut::chart
