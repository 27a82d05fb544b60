#pragma once
/// What the denoiser is measured on: the bench's scenes, the demo's, and a character.

#include "taut/scene/scene.h"

#include <functional>
#include <string>
#include <vector>

namespace taut::chart {

struct DenoiseScene {
    std::string name;
    double frame = 1;
    int width = 256; ///< of pictures, pixels; twice that where there is time
    std::function<Scene()> make;
};

/// Those of benchScenes() but for the largest, the demo's where this source tree still is, and the skinned character of the .glb file that
/// the environment variable TAUT_CHARACTER names, if it names one.
std::vector<DenoiseScene> denoiseScenes();
/// Animations of the demo, 24 frames each and more.
std::vector<DenoiseScene> movingScenes();
/// A small lamp's highlight on a brushed plate that is sheared and stretched: long one way and narrow the other, askew.
Scene highlightScene(int size);

/// The scene in a picture of another width, of the same shape.
Scene atWidth(Scene scene, int width);
/// A name without spaces.
std::string fileNameOf(std::string name);

} // namespace taut::chart
