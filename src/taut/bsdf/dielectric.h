#pragma once
/// A rough interface between two clear media (Walter, Marschner, Li & Torrance 2007).

#include "taut/bsdf/interfaces.h"
#include "taut/bsdf/reflection_lobe.h"

namespace taut {

struct DielectricBsdf {
    static void make(const MaterialValues &material, Bsdf &bsdf) { bsdf.tint = material.color; }
    [[gnu::always_inline]] static DielectricInterface interface(const Bsdf &bsdf) { return {bsdf.eta}; }

    static BsdfEval evaluate(const BsdfView &view, const Vec3 &wi) {
        if (wi.z > 0) return above(view.bsdf, view.bsdf.micro, view.lobe, view.wo, wi);
        if (wi.z >= 0) return {};
        const BsdfEval e = below(view.bsdf, view.bsdf.micro, view.lobe, view.wo, wi);
        return e.pdf > 0 ? e : BsdfEval{};
    }

    /// A visible normal, then reflection or refraction by Fresnel's choice.
    static std::optional<Vec3> sample(const BsdfView &view, const Vec2 &u, float lobe) {
        const Vec3 &wo = view.wo;
        const float eta = view.bsdf.eta;
        const Vec3 wm = ggx::spreadVisibleNormal(view.bsdf.micro, wo, u);
        const float cosine = glm::dot(wo, wm);
        if (!(cosine > 0)) return std::nullopt;
        Vec3 wi;
        if (lobe >= fresnel::dielectric(cosine, eta)) {
            if (!fresnel::refract(wo, wm, cosine, eta, wi) || !(wi.z < 0)) return std::nullopt;
            return wi;
        }
        wi = glm::normalize(2 * cosine * wm - wo);
        if (!(wi.z > 0)) return std::nullopt;
        return wi;
    }

    [[gnu::always_inline]] static BsdfEval above(const Bsdf &, const MicroTransform &m, const LobeView &view, const Vec3 &wo,
                                                 const Vec3 &wi) {
        float facet = 1;
        const BsdfEval e = reflectionLobe(
            m, view, wo, wi, [&](float cosine) __attribute__((always_inline)) {
                facet = fresnel::dielectric(cosine, view.eta);
                return Vec3(facet);
            });
        return {Vec3(e.fCos.x, e.fCos.y, e.fCos.z), e.pdf * facet};
    }
    /// refractionLobe(), tinted.
    [[gnu::always_inline]] static BsdfEval below(const Bsdf &bsdf, const MicroTransform &m, const LobeView &view, const Vec3 &wo,
                                                 const Vec3 &wi) {
        const BsdfEval e = refractionLobe(
            m, view, wo, wi, [&](float cosine) __attribute__((always_inline)) { return 1 - fresnel::dielectric(cosine, view.eta); });
        const Vec3 fCos = bsdf.tint * e.fCos.x;
        return {Vec3(fCos.x, fCos.y, fCos.z), e.pdf};
    }
    [[gnu::always_inline]] static LaneSample sampleLane(const Bsdf &, const MicroTransform &m, const LobeView &view, float /*cap*/,
                                                        const Vec3 &wo, const Vec2 &u, float lobe) {
        const Vec3 wm = ggx::spreadVisibleNormalBranchless(m, wo, u);
        const float cosine = glm::dot(wo, wm);
        const bool reflects = lobe < fresnel::dielectric(cosine, view.eta);
        const Vec3 reflected = glm::normalize(2 * cosine * wm - wo);
        Vec3 refracted;
        const bool through = facet::refract(wo, wm, cosine, view.eta, refracted);
        const float beyond = through ? -refracted.z : -1.0F;
        return {{reflects ? reflected.x : refracted.x, reflects ? reflected.y : refracted.y, reflects ? reflected.z : refracted.z},
                std::min(cosine, reflects ? reflected.z : beyond),
                -1};
    }
};

} // namespace taut
