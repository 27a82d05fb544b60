#pragma once
/// The same scene rendered by Blender's Cycles, where Blender is installed: through `taut export`'s files and apps/blender.

#include "taut/scene/scene.h"

#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace taut::chart {

/// Images and the seconds of their render calls, by samples per pixel.
struct CyclesRenders {
    struct Timed {
        std::vector<float> values; ///< R G B A, rows from the top
        double seconds = 0;
    };
    std::map<int, std::vector<Timed>> bySamples;
};

/// Empty where Cycles can be asked; else why not, in half a sentence.
std::string whyNoCycles();

/// Renders a frame of a scene whose camera stands still, with quad lights and a constant environment; every object is a metal of
/// reflectance 1 without multiple scattering. Writes what Blender reads and writes into `folder`. Throws RunError where Blender fails.
CyclesRenders renderWithCycles(const Scene &scene, double frame, const std::vector<int> &spp, int rounds,
                               const std::filesystem::path &folder);

} // namespace taut::chart
