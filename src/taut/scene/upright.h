#pragma once
/// Which way is up in a mesh file that does not say: z, unless the mesh stands with y up and falls over with z up. Internal to `scene/`.

#include "taut/scene/scene.h"

namespace taut {

/// Turns a y-up file to z up: (x, y, z) -> (x, -z, y), a quarter turn about x.
inline const DMat4 kWorldFromYUp{1, 0, 0, 0, 0, 0, 1, 0, 0, -1, 0, 0, 0, 0, 0, 1};

/// How firmly an object stands at a frame: how far the middle of its surface is inside the convex hull of what is lowest, seen from above,
/// in radii of its box; negative outside, -1 where that is no area. Throws as motionAtFrame() does.
double firmness(const Object &object, double frame, double fps);

/// Whether an object whose file says nothing of up has y up.
bool standsWithYUp(const Object &object, double frame, double fps);

} // namespace taut
