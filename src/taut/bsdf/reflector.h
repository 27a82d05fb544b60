#pragma once
/// Reflection by facets of one interface (interfaces.h): all of a conductor, and the upper layer of a coat.

#include "taut/bsdf/interfaces.h"
#include "taut/bsdf/reflection_lobe.h"

namespace taut {

/// Base of a Class with `static Interface interface(const Bsdf &)`.
template <class Class> struct Reflector {
    static BsdfEval evaluate(const BsdfView &view, const Vec3 &wi) {
        if (wi.z <= 0) return {};
        return above(view.bsdf, view.bsdf.micro, view.lobe, view.wo, wi);
    }
    static std::optional<Vec3> sample(const BsdfView &view, const Vec2 &u, float coin) { return view.reflections->sample(u, coin); }

    [[gnu::always_inline]] static BsdfEval above(const Bsdf &bsdf, const MicroTransform &m, const LobeView &view, const Vec3 &wo,
                                                 const Vec3 &wi) {
        return reflectionLobe(
            m, view, wo, wi, [&](float cosine) __attribute__((always_inline)) { return Class::interface(bsdf).reflectance(cosine); });
    }
    /// By caps; lanes where those waste too much are sampled again by a cone each.
    [[gnu::always_inline]] static LaneSample sampleLane(const Bsdf &, const MicroTransform &m, const LobeView &, float cap, const Vec3 &wo,
                                                        const Vec2 &u, float coin) {
        const Vec3 wm = ggx::spreadVisibleNormalBranchless(m, wo, u, cap);
        return {(2 * glm::dot(wo, wm) / glm::dot(wm, wm)) * wm - wo, 1, coin};
    }
};

} // namespace taut
