#pragma once
/// Cycles in Blender as a peer: a process that holds the scene and renders on request (apps/blender/cycles.py), so that its
/// renders can take turns with ours.

#include "taut/render/render_scene.h"

#include <memory>
#include <vector>

namespace taut::chart {

/// Whether a `blender` is on the PATH.
bool hasBlender();

struct CyclesRequest {
    int frame = 0; ///< index into the scene's frames
    int spp = 1;
    int seed = 0;
    int width = 1, height = 1;
    bool image = false; ///< is wanted, not the times alone
};

struct CyclesRender {
    double seconds = 0;       ///< of the render: bringing its scene up to date, if it changed, and tracing
    double peakMb = 0;        ///< of the process so far
    std::vector<float> image; ///< R G B, rows from the top, where asked for
};

/// A running Blender with a scene, its files in a folder of their own. Ends with it. Throws RunError where Blender fails, with what its
/// log says.
class CyclesPeer {
  public:
    /// The scene's meshes at all its frames, its environment and all else that the scenes of benchmark and charts use: conductors of
    /// reflectance 1, dielectrics, diffuse and metallic-roughness surfaces, textures of colour alone, quad lights, an environment, a fixed
    /// pinhole camera. Leaves `ready` at the last frame. Threads: as many as Cycles shall use.
    CyclesPeer(RenderScene &ready, int threads);
    ~CyclesPeer();
    CyclesPeer(const CyclesPeer &) = delete;
    CyclesPeer &operator=(const CyclesPeer &) = delete;

    CyclesRender render(const CyclesRequest &request);

  private:
    struct Process;
    std::unique_ptr<Process> process_;
};

} // namespace taut::chart
