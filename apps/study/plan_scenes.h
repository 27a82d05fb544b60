#pragma once
/// Scenes that hold plans to their word: each is rendered with `--model full` and under a plan, with the same random numbers.

#include "taut/plan/plan.h"
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

struct PlanOutcome {
    double predicted = 0;
    double error = 0; ///< RMS of the difference from full, over the RMS of full
    double seconds = 0, fullSeconds = 0;
};

/// The reference image of a scene and its time.
struct FullRender {
    std::vector<float> image;
    double seconds = 0;
};
FullRender renderFull(const PlanScene &scene, int spp);

PlanOutcome holdPlan(const PlanScene &scene, const FullRender &full, float tolerance, int spp);

} // namespace taut::chart
