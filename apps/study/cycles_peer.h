#pragma once
/// Cycles in Blender as a peer: a process that holds the scene and renders on request (apps/blender/cycles_bench.py), so that its
/// renders can take turns with ours.

#include "taut/render/render_scene.h"

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

namespace taut::chart {

/// Whether a `blender` is on the PATH.
bool hasBlender();

/// Writes the scene's meshes at all its frames, its environment and a description (scene.json) into a folder that exists. Reads
/// what the scenes of benchmark and charts use: untextured conductors of reflectance 1, dielectrics and diffuse surfaces, quad lights, an
/// environment, a fixed pinhole camera. Leaves `ready` at the last frame. Threads: as many as Cycles shall use.
void writeCyclesScene(RenderScene &ready, int threads, const std::filesystem::path &folder);

struct CyclesRequest {
    int frame = 0; ///< index into the scene's frames
    int spp = 1;
    int seed = 0;
    int width = 1, height = 1;
    std::filesystem::path output; ///< EXR; empty: nothing is kept
};

/// Red, green and blue of an image that Cycles wrote, rows from the top. Throws RunError where it has fewer channels.
std::vector<float> readCyclesImage(const std::filesystem::path &file);

struct CyclesTimes {
    double seconds = 0; ///< of the render: bringing its scene up to date, if it changed, and tracing
    double peakMb = 0;  ///< of the process so far
};

/// A running Blender. Ends with it. Throws RunError where Blender fails, naming its log beside the scene.
class CyclesPeer {
  public:
    /// `folder` was filled by writeCyclesScene().
    explicit CyclesPeer(const std::filesystem::path &folder);
    ~CyclesPeer();
    CyclesPeer(const CyclesPeer &) = delete;
    CyclesPeer &operator=(const CyclesPeer &) = delete;

    CyclesTimes render(const CyclesRequest &request);

  private:
    struct Process;
    std::unique_ptr<Process> process_;
};

} // namespace taut::chart
