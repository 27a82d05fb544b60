#pragma once
/// The lobe of a BSDF over all light directions as a latitude-longitude picture: what `taut probe lobe` and the view show.

#include "taut/base/frame.h"
#include "taut/bsdf/bsdf.h"

#include <cstdint>
#include <vector>

namespace taut::app {

struct LobeQuestion {
    Vec3 view{0, 0, 1}; ///< unit; in the space of `frame`
    int width = 512;    ///< pixels; half as many high
    std::uint32_t samples = 16; ///< a pixel
    std::uint32_t seed = 1;
    bool pdf = false; ///< of the sampler, in the place of the BSDF times the cosine
};

struct LobePicture {
    int width = 0, height = 0;
    std::vector<float> values; ///< [height x width], row 0 towards the normal: column = phi / 360 * width, row = theta / 180 * height
    std::size_t peak = 0;      ///< of the greatest value
    double integral = 0;       ///< over solid angle
};

/// `frame`: of the microsurface, whose z is its normal.
LobePicture lobePicture(const Bsdf &bsdf, const Frame &frame, const LobeQuestion &question);

/// The direction at a place of the picture, in pixels.
Vec3 lobeDirection(double column, double row, int width);

} // namespace taut::app
