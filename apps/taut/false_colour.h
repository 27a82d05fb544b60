#pragma once
/// One channel of an image in colours that stay apart for every kind of sight.

#include "taut/base/vec.h"
#include "taut/render/aov.h"
#include "taut/render/image_file.h"

#include <string>

namespace taut::app {

/// The output variable that has a channel. Throws InputError with the nearest name.
Aov aovOfChannel(const std::string &channel);

/// Least and greatest value of a channel over the covered pixels of all images; (0, 1) where none is covered.
Vec2 channelRange(const std::vector<Image> &images, const std::string &channel);

/// The channel between range.x (dark blue) and range.y (yellow) as linear RGB with the image's A; black where nothing is.
Image falseColours(const Image &image, const std::string &channel, const Vec2 &range);

} // namespace taut::app
