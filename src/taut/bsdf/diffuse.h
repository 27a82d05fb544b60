#pragma once
/// Lambert's diffuse surface, without a microsurface.

#include "taut/base/warp.h"
#include "taut/bsdf/reflection_lobe.h"

namespace taut {

struct DiffuseBsdf {
    static void make(const MaterialValues &material, Bsdf &bsdf) { bsdf.albedo = material.color; }

    static BsdfEval evaluate(const BsdfView &view, const Vec3 &wi) {
        if (wi.z <= 0) return {};
        return above(view.bsdf, view.bsdf.micro, view.lobe, view.wo, wi);
    }
    static std::optional<Vec3> sample(const BsdfView & /*view*/, const Vec2 &u, float /*lobe*/) { return squareToCosineHemisphere(u); }

    [[gnu::always_inline]] static BsdfEval above(const Bsdf &bsdf, const MicroTransform &, const LobeView &, const Vec3 &, const Vec3 &wi) {
        const float pdf = kInvPi * wi.z;
        return {bsdf.albedo * pdf, pdf};
    }
    [[gnu::always_inline]] static LaneSample sampleLane(const Bsdf &, const MicroTransform &, const LobeView &, float, const Vec3 &,
                                                        const Vec2 &u, float) {
        return {squareToCosineHemisphere(u), 1, -1};
    }
};

} // namespace taut
