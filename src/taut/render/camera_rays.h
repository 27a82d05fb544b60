#pragma once
/// Camera rays of many samples at once, structure of arrays.

#include "taut/base/instructions.h"
#include "taut/base/lanes.h"
#include "taut/render/render_scene.h"
#include "taut/render/sample_dimensions.h"
#include "taut/render/trace_settings.h"

namespace taut {

struct alignas(64) CameraLanes {
    static constexpr int kSize = 64;
    int count = 0;
    bool centred = false; ///< through the middle of the pixel, wherever the filter would have it
    // Given.
    int x[kSize], y[kSize];      ///< pixel
    std::uint32_t sample[kSize]; ///< of the pixel
    // Answered.
    std::uint32_t seed[kSize];       ///< of the pixel's sample sequence
    float filterU[kSize], filterV[kSize]; ///< place within the pixel's filter, 0 to 1
    float time[kSize];               ///< within the shutter, 0 to 1
    Lanes3<kSize> origin, direction; ///< render space; unit
    // Between.
    float u[kSize], v[kSize]; ///< place on the plane at distance one
};

/// Rays through the pixels of `settings`, as the reconstruction filter spreads them; with lens and camera motion.
void cameraRays(const RenderScene &scene, const TraceSettings &settings, CameraLanes &lanes, Instructions instructions = widest());

} // namespace taut
