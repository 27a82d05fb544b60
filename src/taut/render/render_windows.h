#pragma once
/// Parts of a frame for those who only want to know what is in them: no film is kept.

#include "taut/render/integrator.h"

#include <span>
#include <vector>

namespace taut {

struct WindowSettings {
    int samples = 4; ///< a pixel
    int maxEvents = 8;
    std::uint32_t seed = 0; ///< of the frame
};

struct RenderedWindows {
    std::vector<std::vector<double>> means; ///< [windows][pixels x 3] of R, G, B, row by row
    RayCounts counts;
};

/// Renders windows of the frame that the scene stands at, each at most 16 x 16 pixels, on all threads. The same bits for any number of
/// them.
RenderedWindows renderWindows(const RenderScene &scene, std::span<const Window> windows, const WindowSettings &settings);

} // namespace taut
