#pragma once
/// Scattering at a facet of the mesostructure, which leans from the mesh: seen from the mesh's shading frame.
///
/// The facet's BSDF works in the facet's own frame. Between the two horizons it may send light to a side of the mesh on which it is not:
/// reflected light below, where it meets the neighbouring relief. It goes on mirrored at the mesh's plane, so that nothing is lost and
/// nothing is made: the albedo is the facet's. Of a direction and its mirror image each has its own density, and they are weighed against
/// light samples one by one. What is mirrored is not reciprocal; the rest is.

#include "taut/bsdf/bsdf.h"

namespace taut {

class FacetScattering {
  public:
    /// `facet` in the shading frame; null: the mesh's own. `wo` in the shading frame.
    FacetScattering(const Bsdf &bsdf, const Frame *facet, const Vec3 &wo)
        : facet_(facet), point_(bsdf, facet != nullptr ? facet->toLocal(wo) : wo) {}

    /// use(direction in the facet's frame) for those that leave the surface along `wi`, shading frame.
    template <class Use> void forEachSource(const Vec3 &wi, const Use &use) const {
        if (facet_ == nullptr) return void(use(wi));
        for (const float mirror : {1.0F, -1.0F}) {
            const Vec3 local = facet_->toLocal({wi.x, wi.y, mirror * wi.z});
            if ((local.z > 0) == (wi.z > 0)) use(local);
        }
    }

    /// use(BsdfEval) for all that is scattered towards wi, in parts that are weighed one by one.
    template <class Use> void forEachPart(const Vec3 &wi, std::uint32_t seed, const Use &use) const {
        forEachSource(wi, [&](const Vec3 &local) {
            const auto [single, multiple] = point_.evaluateParts(local, seed);
            use(single);
            use(multiple);
            use(point_.evaluateBeside(local));
        });
    }
    /// Their sum.
    [[nodiscard]] BsdfEval evaluate(const Vec3 &wi, std::uint32_t seed = 0) const {
        BsdfEval sum;
        forEachSource(wi, [&](const Vec3 &local) {
            const BsdfEval e = point_.evaluate(local, seed);
            sum.fCos += e.fCos;
            sum.pdf += e.pdf;
        });
        return sum;
    }

    /// As ScatteringPoint::sample(), in the shading frame; the density is that of its own part.
    [[nodiscard]] std::optional<BsdfSample> sample(const Vec2 &u, float lobe, std::uint32_t seed = 0) const {
        std::optional<BsdfSample> s = point_.sample(u, lobe, seed);
        if (facet_ == nullptr || !s) return s;
        const bool up = !s->transmitted;
        s->wi = facet_->fromLocal(s->wi);
        if ((s->wi.z > 0) != up) s->wi.z = -s->wi.z;
        return s;
    }

  private:
    const Frame *facet_;
    ScatteringPoint point_;
};

} // namespace taut
