#pragma once
/// Pictures of the report: renders side by side, written as PNG beside it.

#include "study/chart.h"

#include <cstddef>

namespace taut::chart {

/// What brings the brightest hundredth of an image to white.
float exposureOf(const Pixels &image);

/// The absolute difference, times `gain`.
Pixels difference(const Pixels &a, const Pixels &b, float gain);

/// Mean over blocks of size x size pixels; `width` is a multiple of size.
Pixels blockMeans(const Pixels &image, int width, int size);

/// Images of one size from left to right, all times `exposure`, each pixel drawn `zoom` pixels wide: DIRECTORY/NAME.png.
Picture writeStrip(const std::filesystem::path &directory, const std::string &name, const std::string &caption,
                   const std::vector<Pixels> &images, int width, float exposure, int zoom = 1);

} // namespace taut::chart
