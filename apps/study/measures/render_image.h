#pragma once
/// Rendered images for charts, and their times.

#include "study/chart.h"

#include "taut/plan/plan.h"
#include "taut/render/frame_render.h"

#include <functional>
#include <vector>

namespace taut::chart {

/// One frame of a scene under a plan.
struct RenderedImage {
    std::vector<float> values; ///< R G B, rows from the top
    double seconds = 0;        ///< all of it: topology, deformation, BVH, rendering
    double render = 0;         ///< the rendering alone
};
RenderedImage renderImage(const Scene &scene, ScenePlan plan, double frame, int spp, std::uint32_t seed);

/// A scene that is brought to its frame once and rendered from there: the rendering alone.
RenderedImage renderReady(const RenderScene &ready, int spp, std::uint32_t seed);

/// Whether two plans of a scene render it alike, whatever they do to BVHs.
bool sameModels(const ScenePlan &a, const ScenePlan &b);

/// Renders by seed, with random numbers that it names.
using ImageOf = std::function<std::vector<float>(std::uint32_t seed)>;
/// Relative RMS differences of ways to render from a reference, median over the seeds; the random numbers are the same in both.
std::vector<Measured> imageErrors(const std::vector<ImageOf> &ways, const ImageOf &reference, int seeds);

} // namespace taut::chart
