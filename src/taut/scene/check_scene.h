#pragma once
/// Whether a scene can be rendered as it stands: what the readers of scene files and meshes guarantee, asked of any scene.

#include "taut/scene/scene.h"

namespace taut {

/// Throws InputError at the first value out of its range (scene/ranges.h), index that leads nowhere or array of another length than
/// its mesh wants: "materials[2] 'foil'.alphaX: found -1, expected a number in [1e-4, 10]", after the scene's path where it has one.
/// One pass over every array, large ones in parallel. What only a frame can tell (points that a function gives) is checked there.
void check(const Scene &scene);

} // namespace taut
