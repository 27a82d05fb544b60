#pragma once
/// The reconstruction filter, importance sampled (Ernst, Stamminger & Greiner 2006): every sample counts for its own pixel alone.

#include "taut/base/vec.h"

namespace taut {

/// Offset of a sample from its pixel's centre, pixels: a box of one pixel, or Blackman-Harris of radius 1.5 pixels.
Vec2 sampleFilter(bool box, const Vec2 &u);

} // namespace taut
