#pragma once
/// How much of what a surface sees is bright: whether light that few paths look for is found by enough of them.

#include "taut/mesh/mesh.h"
#include "taut/scene/scene.h"

#include <span>

namespace taut {

/// A light as a point of a surface sees it.
struct SeenLight {
    float irradiance = 0; ///< radiance times solid angle, luminance
    float solidAngle = 0; ///< sr, at most a hemisphere's; 0: a point or a direction
};

/// Share of the hemisphere that lights fill: with radiances L_i, solid angles W_i and E_i = L_i W_i
///     (sum E_i)^2 / (2 pi sum E_i L_i),
/// the squared mean of the radiance that a random direction meets over the mean of its square. In (0, 1]; 1 for even light and where
/// there is none. `blur`: solid angle that a lobe spreads every light over at least, sr.
float coverageOf(std::span<const SeenLight> lights, float blur);

struct PlacedLight {
    LightOutline outline;
    float radiance = 0; ///< luminance; radiant intensity of a point
};

/// A scene's lights at one frame, world space. A mesh that shines counts as the ball around it.
struct SceneLights {
    std::vector<PlacedLight> placed; ///< those with an outline
    std::vector<SeenLight> distant;  ///< environment and directions
};
SceneLights lightsOf(const Scene &scene, double frame);

/// Coverage from inside a box: at its middle and at its points nearest to each light, the greatest. Nothing hides a light.
float lightCoverage(const SceneLights &lights, const Bounds &box, float blur);

/// Share of the samples of reflections that may be lost to the horizon (ReflectionSampler). Losing a share w of them makes of a relative
/// variance V, of the light that they meet, (V + w) / (1 - w); not losing them takes r times as long. So it pays off from
/// w = (r - 1) V / (1 + V) on, where V / (1 + V) = 1 - coverage: under an even sky nearly always, under a lamp from kBearableWaste on.
/// Asked under a sky alone.
float bearableWasteUnder(const Scene &scene);

/// An object's control points at a frame, world space.
Bounds worldBounds(const Object &object, double frame, double fps);

} // namespace taut
