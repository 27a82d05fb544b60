#pragma once
/// Scattering at a facet of the mesostructure, which leans from the mesh: seen from the mesh's shading frame.
///
/// The facet's BSDF works in the facet's own frame. Between the two horizons it may send light to a side of the mesh on which it is not:
/// reflected light below, where it meets the neighbouring relief. It goes on mirrored at the mesh's plane, so that nothing is lost and
/// nothing is made: the albedo is the facet's. Of a direction and its mirror image each has its own density, and they are weighed against
/// light samples one by one. What is mirrored is not reciprocal; the rest is.

#include "taut/bsdf/bsdf.h"

namespace taut {

/// A facet in the mesh's shading frame.
struct TiltedFacet {
    Frame frame;         ///< of the facet
    Vec3 plane{0, 0, 1}; ///< the mesh's geometric normal, on the viewer's side
};

class FacetScattering {
  public:
    /// `facet`: null where it is the mesh. `wo` in the shading frame.
    FacetScattering(const Bsdf &bsdf, const TiltedFacet *facet, const Vec3 &wo)
        : facet_(facet), point_(bsdf, facet != nullptr ? seenBy(facet->frame, wo) : wo) {}

    /// Whether light may leave along `wi` (shading frame), which lies to that side of the mesh: where shading and geometric normal disagree
    /// about it, it would leak. A facet answers for itself.
    [[nodiscard]] bool mayLeave(const Vec3 &wi, bool viewersSide) const { return facet_ != nullptr || viewersSide == (wi.z > 0); }

    /// use(BsdfEval) for all that is scattered towards wi, shading frame, in parts that are weighed one by one.
    template <class Use> void forEachPart(const Vec3 &wi, const walk::Numbers &numbers, const Use &use) const {
        forEachSource(wi, [&](const Vec3 &local) {
            const auto [single, multiple] = point_.evaluateParts(local, numbers);
            use(single);
            use(multiple);
            use(point_.evaluateBeside(local));
        });
    }
    /// Their sum.
    [[nodiscard]] BsdfEval evaluate(const Vec3 &wi, const walk::Numbers &numbers = {}) const {
        BsdfEval sum;
        forEachSource(wi, [&](const Vec3 &local) {
            const BsdfEval e = point_.evaluate(local, numbers);
            sum.fCos += e.fCos;
            sum.pdf += e.pdf;
        });
        return sum;
    }

    /// As ScatteringPoint::sample(), in the shading frame; the density is that of its own part.
    [[nodiscard]] std::optional<BsdfSample> sample(const Vec2 &u, float lobe, std::uint32_t seed = 0) const {
        std::optional<BsdfSample> s = point_.sample(u, lobe, seed);
        if (facet_ == nullptr || !s) return s;
        s->wi = facet_->frame.fromLocal(s->wi);
        const float height = glm::dot(s->wi, facet_->plane);
        if ((height > 0) == s->transmitted) s->wi -= 2 * height * facet_->plane;
        return s;
    }

  private:
    /// A facet that turns from the viewer is seen as by his mirror image, above it.
    static Vec3 seenBy(const Frame &facet, const Vec3 &wo) {
        const Vec3 local = facet.toLocal(wo);
        return {local.x, local.y, std::fabs(local.z)};
    }
    /// use(direction in the facet's frame) for those that leave the mesh along `wi`.
    template <class Use> void forEachSource(const Vec3 &wi, const Use &use) const {
        if (facet_ == nullptr) return void(use(wi));
        const float height = glm::dot(wi, facet_->plane);
        for (const Vec3 &w : {wi, wi - 2 * height * facet_->plane}) {
            const Vec3 local = facet_->frame.toLocal(w);
            if ((local.z > 0) == (height > 0)) use(local);
        }
    }

    const TiltedFacet *facet_;
    ScatteringPoint point_;
};

} // namespace taut
