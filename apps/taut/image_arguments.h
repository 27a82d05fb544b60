#pragma once
/// How pictures are seen and stored, as the command line says it.

#include "taut/images/image_settings.h"

#include <CLI/CLI.hpp>

#include <optional>
#include <string>
#include <vector>

namespace taut::app {

/// All empty: as the scene says.
struct ImageArguments {
    std::optional<double> exposure;
    std::string view, display, look, config, space;
    std::vector<std::string> bits;
    std::string compression;
};

/// --exposure, --view, --look, --ocio, --ocio-display and --ocio-space: what a display is sent.
void addViewArguments(CLI::App &command, ImageArguments &arguments);
/// These, --bits and --compression.
void addImageArguments(CLI::App &command, ImageArguments &arguments);

/// The settings with what the command line says about them. Throws InputError where that can't be done to any of `outputs`, or a view can't
/// be made: before the work, not after it.
ImageSettings imageSettingsOf(const ImageArguments &arguments, ImageSettings settings, const std::vector<std::string> &outputs);

/// The words that say it again: for tasks of a farm.
std::vector<std::string> imageWords(const ImageArguments &arguments);

} // namespace taut::app
