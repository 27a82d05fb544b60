#pragma once
/// Measures one scene of the benchmark: our renderer, the same rays through bare Embree calls and Cycles take turns, round by round,
/// so that whatever else the machine does meets all of them.

#include "study/scenes/bench_scenes.h"

#include <nlohmann/json.hpp>

namespace taut::chart {

struct BenchOptions {
    int spp = 16;      ///< samples a pixel of a timed frame
    int recordSpp = 4; ///< recorded for the replay
    int rounds = 3;
    int threads = 1;
    bool cycles = false;
    bool equalError = false; ///< with cycles
    int errorSize = 128;     ///< width and height of the images whose error is measured
};

/// What the fields mean:
///   samples_per_s, seconds_per_frame  whole frames: deformation, gradient, BVH update and tracing
///   foreground                        share of the samples whose camera ray meets a surface; foreground_samples_per_s: those alone
///   rays_per_s, ratio_to_embree       tracing alone, as the replay is
///   ratio_to_cycles                   whole frames; a static scene is in memory in both
///   equal_error_time_ratio_to_cycles  the greatest of the three in equal_error: our time to reach the error that Cycles has after
///                                     16, 64 and 256 samples a pixel, over its time for them
///   peak_mb, cycles_peak_mb           of the process, before rays are recorded for the replay
/// Rates and ratios are medians of the rounds; "spread" holds them between their quartiles.
nlohmann::json measureBench(const BenchScene &bench, const BenchOptions &options);

/// In a process of its own, so that the peak memory is this scene's. The caller must not have started threads. Throws RunError.
nlohmann::json measureApart(const BenchScene &bench, const BenchOptions &options);

} // namespace taut::chart
