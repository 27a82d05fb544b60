#pragma once
/// The scenes that the renderer is measured on: brushed tori under the light that peers are measured with, and characters.

#include "taut/scene/scene.h"

#include <functional>
#include <string>
#include <vector>

namespace taut::chart {

/// A scene by name; made where it is measured, in a process of its own.
struct BenchScene {
    std::string name;
    int frames = 1; ///< 1 to this; more than one: the mesh deforms
    std::function<Scene()> make;
};

/// Metals of reflectance 1, masking as in Cycles 3.4 (separable), single scattering; 512 x 512 pixels, box filter.
const std::vector<BenchScene> &benchScenes();

/// A glTF file in the pose of its 13th frame, as its default camera sees it: under a constant sky, a lamp and the studio. Its materials
/// have separable masking and single scattering, as Cycles shows them.
std::vector<BenchScene> characterScenes(const std::string &file);

} // namespace taut::chart
