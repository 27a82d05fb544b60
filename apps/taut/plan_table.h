#pragma once
/// The plan as a table of time: what each choice costs and saves, in seconds of the whole job and in error, and what the next step would buy.

#include "taut/plan/plan.h"
#include "taut/scene/scene.h"

#include <string>

namespace taut::app {

/// Lines of text, each with its end. Seconds are foreseen from counts (plan/costs.h), both cores of the machine that is named there.
std::string planTable(const Scene &scene, const ScenePlan &plan);

/// What pilots measured and how an error that is asked for is split; empty where there is neither.
std::string pilotLines(const ScenePlan &plan);

} // namespace taut::app
