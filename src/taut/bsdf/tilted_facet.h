#pragma once
/// Scattering at a facet of the mesostructure, which leans from the mesh.
///
/// The facet's BSDF works in the facet's own frame. Between the two horizons it may send light to a side of the mesh on which it is not:
/// reflected light below, where it meets the neighbouring relief. It goes on mirrored at the mesh's plane, so that nothing is lost and
/// nothing is made: the albedo is the facet's. Of a direction and its mirror image each has its own density, and they are weighed against
/// light samples one by one. What is mirrored is not reciprocal; the rest is.

#include "taut/bsdf/bsdf.h"

namespace taut {

/// A facet's formulas, for hits one by one and many at once: `height` of a direction over the mesh's plane, whose unit normal is `plane`.
namespace tilted {

/// A facet that turns from the viewer is seen as by his mirror image, above it; in the facet's frame.
[[gnu::always_inline]] inline Vec3 seen(const Vec3 &woLocal) {
    return {woLocal.x, woLocal.y, std::fabs(woLocal.z)};
}
[[gnu::always_inline]] inline Vec3 mirrored(const Vec3 &w, float height, const Vec3 &plane) {
    return w - 2 * height * plane;
}
/// Whether light that leaves the facet at that z of its own frame is on this side of the mesh.
[[gnu::always_inline]] inline bool agree(float z, float height) {
    return (z > 0) == (height > 0);
}

} // namespace tilted

class FacetScattering {
  public:
    /// `frame`: the facet's. `plane`: null where that is the mesh, else the mesh's geometric normal on the viewer's side, unit. All
    /// directions are in the space that these are in.
    FacetScattering(const Bsdf &bsdf, const Frame &frame, const Vec3 *plane, const Vec3 &wo)
        : frame_(frame), plane_(plane), point_(bsdf, plane != nullptr ? tilted::seen(frame.toLocal(wo)) : frame.toLocal(wo)) {}

    /// Whether light may leave along `wi`, which lies to that side of the mesh: where shading and geometric normal disagree about it, it
    /// would leak. A facet answers for itself.
    [[nodiscard]] bool mayLeave(const Vec3 &wi, bool viewersSide) const {
        return plane_ != nullptr || viewersSide == (glm::dot(wi, frame_.n) > 0);
    }

    /// use(BsdfEval) for all that is scattered towards wi, in parts that are weighed one by one.
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

    /// As ScatteringPoint::sample(), of its own part the density; not quite of unit length.
    [[nodiscard]] std::optional<BsdfSample> sample(const Vec2 &u, float lobe, std::uint32_t seed = 0) const {
        std::optional<BsdfSample> s = point_.sample(u, lobe, seed);
        if (!s) return s;
        s->wi = frame_.fromLocal(s->wi);
        if (plane_ == nullptr) return s;
        const float height = glm::dot(s->wi, *plane_);
        if (!tilted::agree(s->transmitted ? -1.0F : 1.0F, height)) s->wi = tilted::mirrored(s->wi, height, *plane_);
        return s;
    }

  private:
    /// use(direction in the facet's frame) for those that leave the mesh along `wi`.
    template <class Use> void forEachSource(const Vec3 &wi, const Use &use) const {
        if (plane_ == nullptr) return void(use(frame_.toLocal(wi)));
        const float height = glm::dot(wi, *plane_);
        for (const Vec3 &w : {wi, tilted::mirrored(wi, height, *plane_)}) {
            const Vec3 local = frame_.toLocal(w);
            if (tilted::agree(local.z, height)) use(local);
        }
    }

    const Frame &frame_;
    const Vec3 *plane_;
    ScatteringPoint point_;
};

} // namespace taut
