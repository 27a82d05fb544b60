#pragma once
/// OpenColorIO for the module of images. Internal to it.

#include "taut/images/colour_config.h"

namespace taut {

std::unique_ptr<const ColourConfig> openColourConfig(const std::string &path);
std::unique_ptr<const ColourTransform> makeAcesView(const std::string &display);
std::vector<std::string> namesOfAcesDisplays();
std::string versionOfOpenColorIo();

} // namespace taut
