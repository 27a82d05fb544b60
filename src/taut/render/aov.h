#pragma once
/// Values of the output variables at the first hit of a path, in world space where they are places or directions.

#include "taut/render/film.h"
#include "taut/render/shading.h"

#include <span>

namespace taut {

/// Writes the AOVs of one hit, in the film's order.
/// M.a, M.b, M.d are the upper triangular M in the frame whose x is the rotated tangent R t0 (polar decomposition A = V R) and
/// whose z is the shading normal on the viewer's side; AlphaPhi is measured there too.
void writeAovs(const RenderScene &scene, const SurfacePoint &point, std::span<const Aov> aovs, float *out);

} // namespace taut
