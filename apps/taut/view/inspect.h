#pragma once
/// What the surface under a pixel is, for the page: numbers that `taut probe` can be asked about.

#include "taut/render/render_scene.h"

#include <nlohmann/json.hpp>

namespace taut::app {

/// The first surface behind a place of the picture (pixels from the upper left; fractions count), at the frame that the scene is at, and
/// through the middle of the lens. Null where there is none. Of one with a microsurface: "m" [a, b, 0, d, p, q] in the frame of the rotated
/// tangent, "alpha_max", "alpha_min", "alpha_rotation" and the view's "theta" and "phi" in degrees, as `taut probe` takes them; "probe" is
/// that command; "ellipse" the half axes of alpha on the surface as seen, in pixels, the longer 1 where it is seen from the front;
/// "lobe" its picture. "stretch" has the singular values of A and the direction of the greater as seen.
nlohmann::json inspectPixel(const RenderScene &scene, double x, double y);

} // namespace taut::app
