#pragma once
/// A highlight on a plate whose every point is a patch of explicit facets, traced facet by facet, and the same from M: what a renderer of
/// M must agree with. Mirrors of F = 1 under a lamp in a dim sky.

#include "study/chart.h"

#include "taut/mesh/mesh.h"
#include "taut/microsurface/transform.h"

#include <memory>

namespace taut::chart {

inline constexpr int kHighlightSize = 24; ///< pixels, square

/// A patch of makeGgxHeightfield, deformed; `m` is the deformation.
class FacetPatch {
  public:
    FacetPatch(const Mesh &patch, const MicroTransform &m);
    ~FacetPatch();
    /// `samples` rays a pixel, each to a facet somewhere in the patch. `allBounces`: facets that light other facets are followed; else
    /// what does not leave at once is lost.
    [[nodiscard]] Pixels render(int samples, bool allBounces, std::uint32_t seed) const;

  private:
    struct State;
    std::unique_ptr<State> state_;
};

/// The picture of the highlight from M instead of facets: single scattering, or the random walk.
Pixels renderMicrosurface(const MicroTransform &m, int samples, bool allBounces, std::uint32_t seed);

} // namespace taut::chart
