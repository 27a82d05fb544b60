#pragma once
/// When a deforming mesh's BVH is built anew rather than refitted.
///
/// A refitted BVH keeps its tree, and deformation lets the boxes of neighbours grow into each other. How much is measured on the
/// mesh itself: clusters of triangles that lay together when the BVH was built, the surface of whose boxes is what rays meet. As a
/// multiple of the triangles' own area it stays what it was as long as the tree fits. Traversal is taken to slow down in
/// proportion to its growth; a new build is due when the rays of a frame would pay for it. The rule looks at geometry and sample
/// counts alone, never at a clock: the same scene gives the same bits.

#include "taut/base/vec.h"

#include <span>
#include <vector>

namespace taut {

class BvhPolicy {
  public:
    /// The BVH has been built on these positions.
    void built(std::span<const Index3> triangles, std::span<const Vec3> positions);

    /// Whether to build rather than refit for these positions, with about this many rays to trace.
    [[nodiscard]] bool shouldRebuild(std::span<const Index3> triangles, std::span<const Vec3> positions, double rays) const;

    /// Boxes' surface over triangles' area, relative to what it was when the BVH was built: 1 when fresh.
    [[nodiscard]] double growth(std::span<const Index3> triangles, std::span<const Vec3> positions) const;

  private:
    std::vector<Index> order_; // triangles along a space-filling curve over the positions of the last build
    double fresh_ = 0;
};

} // namespace taut
