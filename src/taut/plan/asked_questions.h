#pragma once
/// What a plan's questions say of a value, all of its kind together.

#include "taut/plan/plan.h"

namespace taut {

/// Greatest error that the analysis predicts for a value, over all of a plan's questions of its kind; meshes and materials add in squares.
double predictedFor(const ScenePlan &plan, const ChoiceValue &value);

/// Whether any question of a plan has this among its choices.
bool isAsked(const ScenePlan &plan, const ChoiceValue &value);

} // namespace taut
