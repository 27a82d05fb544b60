#pragma once
/// What a frame will take: for a scheduler that asks before it gives.

#include "taut/render/frame_render.h"

#include <chrono>

namespace taut::app {

struct Resources {
    double megabytes = 0;     ///< of the whole process, while it renders
    double frameSeconds = 0;  ///< of one thread that renders a frame; of n threads the n-th part, nearly
    double serialSeconds = 0; ///< of all threads, once for a process: reading and planning
    double updateSeconds = 0; ///< of all threads, once for a frame: deformation and BVH
};

/// Measures: the scene as it stands in memory, its first frame brought up, and patches of that picture at a few samples. `began`: when
/// the process set out to read the scene. For a noise level the samples are the upper bound.
Resources measureResources(RenderScene &scene, const FrameOptions &options, std::chrono::steady_clock::time_point began);

} // namespace taut::app
