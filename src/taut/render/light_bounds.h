#pragma once
/// What a light can send where, for the tree that chooses between lights.

#include "taut/render/lights.h"

namespace taut {

/// Bounds of a light that is somewhere (of one triangle of a mesh emitter) while the shutter is open.
LightBounds boundsOf(const LightEntry &entry, Index triangle);

} // namespace taut
