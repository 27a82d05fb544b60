#pragma once
/// One frame, from a RenderScene to a Film: tiles in parallel, passes until the samples or the time are used up.

#include "taut/render/integrator.h"

#include <functional>
#include <optional>

namespace taut {

struct FrameOptions {
    int spp = 64;
    std::optional<double> seconds; ///< stop after the pass in which this much time is over; spp then is the upper bound
    std::optional<double> noise;   ///< adaptive sampling to this relative noise (adaptive.h); spp then is the upper bound
    Window window;                 ///< pixels to render; empty: the whole frame
    std::vector<Aov> aovs;
    std::uint32_t seed = 0; ///< of this frame, already decorrelated
    RayRecord *record = nullptr;
    bool oneByOne = false;                ///< as in TraceSettings
    std::function<void(double)> progress; ///< share done in [0, 1]; called from one thread at a time
};

struct FrameResult {
    Film film;
    StageTimes times; ///< rendering stages only
    RayCounts counts;
    double seconds = 0; ///< wall clock
};

/// Seed of a frame: decorrelated from its neighbours unless `fixed`.
std::uint32_t frameSeed(std::uint32_t seed, int frame, bool fixed);

FrameResult renderFrame(const RenderScene &scene, const FrameOptions &options);

} // namespace taut
