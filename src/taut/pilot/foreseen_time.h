#pragma once
/// How long things would take, counted from what they are made of: seconds of the machine that costs.h names, never of a clock.

#include "taut/scene/scene.h"

#include <vector>

namespace taut {

class ForeseenTime {
  public:
    explicit ForeseenTime(const Scene &scene) : scene_(scene) {}

    /// Building all meshes at these levels [objects] once: topology, refinement, a frame, BVH.
    [[nodiscard]] double build(const std::vector<int> &levels) const;
    /// Bringing those that deform to another frame.
    [[nodiscard]] double update(const std::vector<int> &levels) const;
    [[nodiscard]] double rays(double count) const;
    /// Samples of a pixel of the scene, one path each.
    [[nodiscard]] double samples(double count) const;
    /// All frames of the scene at so many samples a pixel.
    [[nodiscard]] double whole(const std::vector<int> &levels, double samplesAPixel) const;

  private:
    const Scene &scene_;
};

} // namespace taut
