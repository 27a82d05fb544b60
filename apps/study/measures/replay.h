#pragma once
/// Recorded rays sent again through bare Embree calls, with nothing else around them: what traversal alone costs.

#include "taut/render/integrator.h"
#include "taut/render/render_scene.h"

namespace taut::chart {

/// The rays of the frame that `ready` is at, in the order in which one thread traces them.
RayRecord recordRays(const RenderScene &ready, int spp, std::uint32_t seed);

struct ReplayTimes {
    double camera = 0, scattered = 0, shadow = 0; ///< wall clock seconds, all threads
    [[nodiscard]] double total() const { return camera + scattered + shadow; }
};

/// Each kind of ray in the way that suits it: camera rays 16 wide, scattered rays 8 wide, shadow rays as ShadowRays; packets are
/// made beforehand and not timed. The least of `repetitions` runs.
ReplayTimes replayRays(const EmbreeScene &scene, const RayRecord &record, int repetitions);

} // namespace taut::chart
