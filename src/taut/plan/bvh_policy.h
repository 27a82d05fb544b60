#pragma once
/// When a deforming mesh's BVH is built anew rather than refitted.
///
/// A refitted BVH keeps its tree, and deformation lets the boxes of neighbours grow into each other. How much is measured on the
/// mesh itself: clusters of triangles that lay together when the BVH was built, the surface of whose boxes is what rays meet. As a
/// multiple of the triangles' own area it stays what it was as long as the tree fits. Traversal is taken to slow down in
/// proportion to its growth; a new build is due when the rays of a frame would pay for it. The rule looks at geometry and sample
/// counts alone, never at a clock: the same scene gives the same bits.

#include "taut/plan/costs.h"
#include "taut/scene/scene.h"

#include <span>
#include <vector>

namespace taut {

class BvhPolicy {
  public:
    /// The BVH has been built on these positions.
    void built(std::span<const Index3> triangles, std::span<const Vec3> positions);

    /// Whether to build rather than refit for these positions, with about this many rays to trace: where refitting costs more.
    [[nodiscard]] bool shouldRebuild(std::span<const Index3> triangles, std::span<const Vec3> positions, double rays,
                                     const BvhCosts &costs = {}) const {
        return refitSeconds(triangles, positions, rays, costs) > rebuildSeconds(triangles.size(), costs);
    }

    /// What either costs this frame, as the policy reckons: a refit with what its boxes slow down its rays, a build. Both of a BVH that
    /// can be refitted.
    [[nodiscard]] double refitSeconds(std::span<const Index3> triangles, std::span<const Vec3> positions, double rays,
                                      const BvhCosts &costs = {}) const;
    [[nodiscard]] static double rebuildSeconds(std::size_t triangles, const BvhCosts &costs = {}) {
        return (costs.refit + costs.build) * static_cast<double>(triangles);
    }

    /// Boxes' surface over triangles' area, relative to what it was when the BVH was built: 1 when fresh.
    [[nodiscard]] double growth(std::span<const Index3> triangles, std::span<const Vec3> positions) const;

    [[nodiscard]] std::size_t bytes() const { return order_.capacity() * sizeof(Index); }

  private:
    std::vector<Index> order_; // of the clusters that are looked at: triangles side by side on a space-filling curve over the
                               // positions of the last build
    double fresh_ = 0;
};

/// Rays of a frame, about.
inline double raysPerFrame(const RenderSettings &render) {
    constexpr double kRaysPerSample = 2.5;
    return kRaysPerSample * render.width * render.height * render.spp;
}

} // namespace taut
