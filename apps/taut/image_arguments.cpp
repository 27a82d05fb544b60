#include "image_arguments.h"

#include "movie.h"

#include "taut/base/error.h"
#include "taut/base/file_bytes.h"
#include "taut/images/view_transform.h"
#include "taut/scene/ranges.h"

#include <fmt/format.h>

#include <algorithm>

namespace taut::app {

namespace {

/// A value of --bits must be for a kind of file that is written.
void checkBits(const std::string &bits, const std::vector<std::string> &outputs) {
    const bool ofPng = bits == "8" || bits == "16";
    const bool isFor = std::any_of(outputs.begin(), outputs.end(),
                                   [&](const std::string &path) { return ofPng == (lowerExtension(path) == "png") && !isMoviePath(path); });
    if (!isFor)
        failInput({"--bits"}, bits + ", but no ." + (ofPng ? "png" : "exr") + " among the outputs",
                  "8 or 16 for .png, half or float for .exr");
}

} // namespace

void addViewArguments(CLI::App &command, ImageArguments &arguments) {
    command.add_option("--exposure", arguments.exposure, "Stops by which PNG and movies are brightened; EXR stays as it is")
        ->check(CLI::Range(kStops.lower, kStops.upper));
    command.add_option(
        "--view", arguments.view,
        "View transform of PNG and movies: standard, filmic, aces, or a view of the OpenColorIO configuration (default: standard)");
    command.add_option("--ocio", arguments.config, "OpenColorIO configuration (default: $OCIO, where a view is asked for)");
    command.add_option("--ocio-display", arguments.display, "Display of the configuration (default: its own)");
    command.add_option("--ocio-space", arguments.space, "The configuration's name of linear Rec. 709 (default: found)");
    command.add_option("--look", arguments.look, "Look of the configuration, in the place of the view's own");
}

void addImageArguments(CLI::App &command, ImageArguments &arguments) {
    addViewArguments(command, arguments);
    command.add_option("--bits", arguments.bits, "8 or 16 for PNG, half or float for EXR (default: 8, float)")
        ->delimiter(',')
        ->allow_extra_args(false);
    command.add_option("--compression", arguments.compression,
                       "Of EXR: none, rle, zips, zip, piz, pxr24, b44, b44a, dwaa, dwab, dwaa:LEVEL (default: zip)");
}

ImageSettings imageSettingsOf(const ImageArguments &arguments, ImageSettings settings, const std::vector<std::string> &outputs) {
    ViewSettings &view = settings.view;
    const auto take = [](const std::string &given, std::string &target) {
        if (!given.empty()) target = given;
    };
    if (arguments.exposure) view.exposure = *arguments.exposure;
    take(arguments.view, view.view);
    take(arguments.display, view.display);
    take(arguments.look, view.look);
    take(arguments.config, view.config);
    take(arguments.space, view.space);
    for (const std::string &bits : arguments.bits) {
        setBits(bits, {"--bits"}, settings);
        checkBits(bits, outputs);
    }
    if (!arguments.compression.empty()) {
        checkCompression(arguments.compression, {"--compression"});
        settings.exrCompression = arguments.compression;
    }
    const bool isDisplayed =
        std::any_of(outputs.begin(), outputs.end(), [](const std::string &path) { return lowerExtension(path) != "exr"; });
    if (isDisplayed) const ViewTransform trial(view);
    return settings;
}

std::vector<std::string> imageWords(const ImageArguments &arguments) {
    std::vector<std::string> words;
    const auto add = [&](const char *option, const std::string &value) {
        if (!value.empty()) words.insert(words.end(), {option, value});
    };
    if (arguments.exposure) add("--exposure", fmt::format("{}", *arguments.exposure));
    add("--view", arguments.view);
    add("--ocio", arguments.config);
    add("--ocio-display", arguments.display);
    add("--ocio-space", arguments.space);
    add("--look", arguments.look);
    for (const std::string &bits : arguments.bits) add("--bits", bits);
    add("--compression", arguments.compression);
    return words;
}

} // namespace taut::app
