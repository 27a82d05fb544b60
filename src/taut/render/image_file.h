#pragma once
/// Image files: scene-linear EXR, and PNG for displays, written beside their name and renamed when whole.

#include "taut/images/image_settings.h"
#include "taut/render/window.h"

#include <string>
#include <utility>
#include <vector>

namespace taut {

/// Metadata of an image: names as they appear in the file ("taut:spp"), values as text.
using Metadata = std::vector<std::pair<std::string, std::string>>;

/// Interleaved float image with channel names; `window` lies in a frame of width x height.
struct Image {
    Window window;
    int width = 0, height = 0;
    std::vector<std::string> channels;
    std::vector<float> values;
};

/// Writes by extension: .exr, all channels as they are, scene linear, or .png, the first three through the view of the settings, whose
/// metadata then says what was applied. Throws RunError; InputError where the settings can't be.
void writeImage(const std::string &path, const Image &image, const Metadata &metadata, const ImageSettings &settings);
/// With the default settings.
void writeImage(const std::string &path, const Image &image, const Metadata &metadata = {});

/// Reads an image, all channels as float. Throws InputError.
Image readImage(const std::string &path);

/// True where writeImage knows the extension.
bool isImagePath(const std::string &path);

/// Writes `text` to `path` beside its name first. Throws RunError.
void writeTextFile(const std::string &path, const std::string &text);

} // namespace taut
