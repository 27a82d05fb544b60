#pragma once
/// Whether a map of slopes is looked up as it is or by its moments over each pixel's footprint.
///
/// Moments turn GGX convolved with the map's slopes into GGX again. What that fit is off by in total variation is known (momentsFitError), and
/// the slopes that a pixel of the scene's camera sees are known from the map's pyramid. Beside it stands what the map itself costs: the
/// samples that average it.

#include "taut/plan/plan.h"

namespace taut {

/// Total variation between GGX of this alpha convolved with Gaussian slopes of standard deviation sigma along each axis, and its best fit
/// by a GGX: 0.02, 0.06, 0.11, 0.15, 0.17 at sigma / alpha = 1/4, 1/2, 1, 2, 4; linear between.
float momentsFitError(float sigmaOverAlpha);

/// Of one material; `leastAlpha` over the frames. None where there is no map, or the material says itself.
std::optional<Question> detailQuestion(const Scene &scene, Index material, float leastAlpha, int frame);
/// Its answer within a budget.
DetailPlan planDetail(const Material &material, std::optional<Question> question, float budget);

} // namespace taut
