#pragma once
/// What the tracing of a frame is told.

#include "taut/render/ray_batch.h"
#include "taut/render/window.h"

#include <optional>

namespace taut {

struct LayerTables;
class FrameBefore;

/// Rays of a render in the order they were traced, for replay. Not thread safe: record with one thread.
struct RayRecord {
    std::vector<Ray> camera, scattered, shadow;
};

struct TraceSettings {
    int width = 1, height = 1; ///< of the whole frame
    int maxEvents = 8;
    bool boxFilter = false;
    std::uint32_t seed = 0; ///< of this frame
    RayRecord *record = nullptr;
    const LayerTables *layers = nullptr; ///< by what a film's layers are found; null: it has none with sums
    bool independent =
        false;             ///< no sample knows of the others of its pixel: noisier, and what statistics of independent samples are held to
    bool oneByOne = false; ///< shade no hits at once (hit_lanes.h): to measure, and to test that nothing changes
    const FrameBefore *before = nullptr; ///< of a film that is denoised over frames
    std::optional<Window> shared{};      ///< the pixels that share their samples (pixel_filter.h); none: each has its own
};

} // namespace taut
