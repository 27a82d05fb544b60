#pragma once
/// Which part and which channels of an image file are its picture. OpenEXR files may hold several parts and any channels (Technical
/// Introduction to OpenEXR, "Multi-Part Files", "Channel Names"); in other formats the place of a channel says what it is.

#include "taut/base/error.h"
#include "taut/images/image_codec.h"

#include <vector>

namespace taut {

/// Where a picture stands in a file.
struct ImageChannels {
    int number = 0;
    ImagePart part;
    std::vector<int> indices; ///< of 1 (grey), 2 (grey, alpha), 3 (RGB) or 4 (RGBA) channels; -1: zero everywhere
};

/// The picture of `input`. Of an OpenEXR file: R, G and B of the first part that has them; else its luminance Y; else the first layer
/// NAME.R, .G, .B; else what there is, in order. What is left out is named in one warning. Fails on luminance with chroma.
ImageChannels pictureOf(ImageDecoder &input, bool isExr, const Location &where, Warnings &warnings);

} // namespace taut
