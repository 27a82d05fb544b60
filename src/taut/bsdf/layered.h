#pragma once
/// Diffuse under a rough interface: reflection by its facets, and what the layer below them sends back.

#include "taut/base/warp.h"
#include "taut/bsdf/reflector.h"

namespace taut {

/// 1 - (diffuse reflectance from inside) of a smooth coat of index eta: (1 - R_outside) / eta^2.
inline float coatEscape(float eta) {
    return (1 - fresnel::diffuseReflectance(eta)) / (eta * eta);
}

/// Base of a Class as Reflector's.
template <class Class> struct Layered : Reflector<Class> {
    [[gnu::always_inline]] static float split(const Bsdf &bsdf, const Vec3 &wo) {
        const float reflected = luminance(Class::interface(bsdf).reflectance(std::fabs(wo.z)));
        const float below = luminance(bsdf.albedo) * (1 - reflected);
        const bool both = hasDiffuse(bsdf) & (below > 0);
        return both ? glm::clamp(reflected / (both ? reflected + below : 1.0F), 0.1F, 0.9F) : 1.0F;
    }

    static BsdfEval evaluate(const BsdfView &view, const Vec3 &wi) {
        if (wi.z <= 0) return {};
        return above(view.bsdf, view.bsdf.micro, view.lobe, view.wo, wi);
    }
    [[gnu::always_inline]] static BsdfEval above(const Bsdf &bsdf, const MicroTransform &m, const LobeView &view, const Vec3 &wo,
                                                 const Vec3 &wi) {
        const BsdfEval e = Reflector<Class>::above(bsdf, m, view, wo, wi);
        const float upper = view.shares.facets;
        const BsdfEval d = substrate(bsdf, wo, wi);
        return {Vec3(e.fCos.x + d.fCos.x, e.fCos.y + d.fCos.y, e.fCos.z + d.fCos.z), e.pdf * upper + (1 - upper) * d.pdf};
    }

    static std::optional<Vec3> sample(const BsdfView &view, const Vec2 &u, float lobe) {
        const float upper = view.lobe.shares.facets;
        if (lobe >= upper) return squareToCosineHemisphere(u);
        return Reflector<Class>::sample(view, u, lobe / upper); // uniform again
    }
    [[gnu::always_inline]] static LaneSample sampleLane(const Bsdf &bsdf, const MicroTransform &m, const LobeView &view, float cap,
                                                        const Vec3 &wo, const Vec2 &u, float lobe) {
        const float upper = view.shares.facets;
        const LaneSample facets = Reflector<Class>::sampleLane(bsdf, m, view, cap, wo, u, lobe / upper);
        const Vec3 below = squareToCosineHemisphere(u);
        const bool isFacets = lobe < upper;
        return {Vec3(isFacets ? facets.wi.x : below.x, isFacets ? facets.wi.y : below.y, isFacets ? facets.wi.z : below.z), 1,
                isFacets ? facets.coin : -1.0F};
    }

  private:
    [[gnu::always_inline]] static bool hasDiffuse(const Bsdf &bsdf) {
        return (bsdf.albedo.x != 0) | (bsdf.albedo.y != 0) | (bsdf.albedo.z != 0);
    }

    /// Lambertian layer under a smooth-interface approximation of the coat: albedo / pi T(wo) T(wi) / (eta^2 (1 - albedo R_in)),
    /// which reflects everything the coat lets through where albedo = 1.
    [[gnu::always_inline]] static BsdfEval substrate(const Bsdf &bsdf, const Vec3 &wo, const Vec3 &wi) {
        const float in = 1 - fresnel::dielectric(wi.z, bsdf.eta);
        const float out = 1 - fresnel::dielectric(std::fabs(wo.z), bsdf.eta);
        const Vec3 series = bsdf.albedo / (Vec3(1) - bsdf.albedo * (1 - bsdf.diffuseEscape));
        return {series * (kInvPi * wi.z * in * out / (bsdf.eta * bsdf.eta)), kInvPi * wi.z};
    }
};

} // namespace taut
