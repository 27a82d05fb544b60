#pragma once
/// Whether what shines in a scene is a lamp or an ornament.

#include "taut/scene/scene.h"

namespace taut {

/// Whether the meshes that emit light those that do not, at the first frame: whether a quarter of the surface that does not shine would,
/// if it were white, be seen by their light. Unoccluded, by a few hundred samples; the same scene gives the same answer.
bool emissionLights(const Scene &scene);

} // namespace taut
