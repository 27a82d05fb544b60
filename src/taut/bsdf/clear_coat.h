#pragma once
/// A clear coat above everything (KHR_materials_clearcoat): a dielectric of index 1.5 with its own microsurface, in its own frame; F by the
/// cosine at the normal, so that what it leaves to the layers below is one number. Always inline, for hits one by one and many at once.

#include "taut/bsdf/fresnel.h"
#include "taut/bsdf/reflection_lobe.h"

namespace taut::clear_coat {

inline constexpr float kF0 = 0.04F; ///< of index 1.5

/// What a coat of that share reflects of the light from wo.
[[gnu::always_inline]] inline float reflectance(float share, const Vec3 &wo) {
    return share * (kF0 + (1 - kF0) * fresnel::schlickShare(std::fabs(wo.z)));
}

/// Seen from one direction.
struct Seen {
    MicroTransform m;
    LobeView lobe;
    float reflected; ///< LayerView::coatShare
    Vec3 wo;
};
/// What it adds to other lobes, for wi.z > 0; `samples`: its share of them.
[[gnu::always_inline]] inline BsdfEval above(const BsdfEval &others, const Seen &coat, float samples, const Vec3 &wi) {
    const float reflected = coat.reflected;
    const BsdfEval e = reflectionLobe(
        coat.m, coat.lobe, coat.wo, wi, [&](float /*cosine*/) __attribute__((always_inline)) { return Vec3(reflected); });
    return {Vec3(others.fCos.x + e.fCos.x, others.fCos.y + e.fCos.y, others.fCos.z + e.fCos.z), others.pdf + samples * e.pdf};
}
/// Without a branch: the others alone where there is none of it.
[[gnu::always_inline]] inline BsdfEval aboveWhere(const BsdfEval &others, const Seen &coat, float samples, const Vec3 &wi) {
    const BsdfEval both = above(others, coat, samples, wi);
    const bool there = (samples > 0) & (wi.z > 0);
    return {Vec3(there ? both.fCos.x : others.fCos.x, there ? both.fCos.y : others.fCos.y, there ? both.fCos.z : others.fCos.z),
            there ? both.pdf : others.pdf};
}

} // namespace taut::clear_coat
