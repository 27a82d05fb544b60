#pragma once
/// The reconstruction filter. Importance sampled (Ernst, Stamminger & Greiner 2006) every sample counts for its own pixel alone. Shared, a
/// pixel's samples fall evenly within it and count for the eight around it too, each by the filter there: the same picture in the mean,
/// and with as many samples less than half of its variance.

#include "taut/base/vec.h"
#include "taut/render/window.h"

#include <array>

namespace taut {

/// Offset of a sample from its pixel's centre, pixels: a box of one pixel, or Blackman-Harris of radius 1.5 pixels.
Vec2 sampleFilter(bool box, const Vec2 &u);

/// A shared sample of Blackman-Harris.
struct SharedSample {
    Vec2 offset; ///< from its pixel's centre, pixels
    /// Of the pixel before, its own and the next along an axis: the filter over the density of samples, 0 where there is no pixel. What the
    /// sample weighs in a pixel is the product of both.
    std::array<float, 3> across, down;
};

/// Of pixel (x, y) of a window whose pixels share their samples. Those at its edge sample what the filter reaches beyond it, too.
Vec2 sharedOffset(const Window &window, int x, int y, const Vec2 &u);
SharedSample sharedSample(const Window &window, int x, int y, const Vec2 &u);

/// Variance of a pixel that shares over that of one that does not, as many samples in each: where light is alike around, the integral of
/// the squared filter.
inline constexpr double kSharedVariance = 0.446;

} // namespace taut
