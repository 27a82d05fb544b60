#pragma once
/// The question about one material: what is done about light that meets several facets.

#include "taut/plan/costs.h"
#include "taut/plan/light_coverage.h"
#include "taut/plan/plan.h"

namespace taut {

/// Answered within a budget of error, for a material that is no rougher than this (deformed alphas). Nothing is asked where the material
/// says itself.
MultiscatterPlan planMultiscatter(const Material &material, const Vec2 &greatestAlpha, float budget, const PlanScales &scales,
                                  const PlanCosts &costs);

/// Goes back to single scattering where the light would bring more noise, at the scene's samples a pixel, than it takes error away.
/// Compensation and walk alike: both send light of several facets to about every direction, where few paths find a small light.
/// `lights` as they are at `frame`.
void weighNoise(const Scene &scene, Index material, const Vec2 &greatestAlpha, const SceneLights &lights, int frame,
                MultiscatterPlan &plan);

} // namespace taut
