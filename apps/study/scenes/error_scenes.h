#pragma once
/// What rendering to an error is measured on: all that the other charts have, and what hurts.

#include "taut/scene/scene.h"

#include <functional>
#include <string>
#include <vector>

namespace taut::chart {

struct ErrorScene {
    std::string name;
    double frame = 1;
    std::function<Scene()> make;
};

/// The bench's scenes, those of the plan and of the demo, many lights, a far crowd, motion blur, glass before a map, and the files that
/// the environment variable TAUT_CHARACTERS names, separated by colons. Pictures `width` pixels wide; a scene has the one frame.
std::vector<ErrorScene> errorScenes(int width);

} // namespace taut::chart
