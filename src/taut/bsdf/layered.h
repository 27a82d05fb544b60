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
    static float split(const Bsdf &bsdf, const Vec3 &wo) {
        if (!hasDiffuse(bsdf)) return 1;
        const float reflected = luminance(Class::interface(bsdf).reflectance(std::fabs(wo.z)));
        const float below = luminance(bsdf.albedo) * (1 - reflected);
        return below > 0 ? glm::clamp(reflected / (reflected + below), 0.1F, 0.9F) : 1.0F;
    }

    static BsdfEval evaluate(const BsdfView &view, const Vec3 &wi) {
        if (wi.z <= 0) return {};
        BsdfEval e = Reflector<Class>::evaluate(view, wi);
        e.pdf *= view.split;
        if (hasDiffuse(view.bsdf)) {
            const BsdfEval d = substrate(view, wi);
            e.fCos += d.fCos;
            e.pdf += (1 - view.split) * d.pdf;
        }
        return e;
    }

    static std::optional<Vec3> sample(const BsdfView &view, const Vec2 &u, float lobe) {
        if (hasDiffuse(view.bsdf) && lobe >= view.split) return squareToCosineHemisphere(u);
        return Reflector<Class>::sample(view, u, lobe / view.split); // uniform again
    }

  private:
    static bool hasDiffuse(const Bsdf &bsdf) { return bsdf.albedo != Vec3(0); }

    /// Lambertian layer under a smooth-interface approximation of the coat: albedo / pi T(wo) T(wi) / (eta^2 (1 - albedo R_in)),
    /// which reflects everything the coat lets through where albedo = 1.
    static BsdfEval substrate(const BsdfView &view, const Vec3 &wi) {
        const Bsdf &bsdf = view.bsdf;
        const float in = 1 - fresnel::dielectric(wi.z, bsdf.eta);
        const float out = 1 - fresnel::dielectric(std::fabs(view.wo.z), bsdf.eta);
        const Vec3 series = bsdf.albedo / (Vec3(1) - bsdf.albedo * (1 - bsdf.diffuseEscape));
        return {series * (kInvPi * wi.z * in * out / (bsdf.eta * bsdf.eta)), kInvPi * wi.z};
    }
};

} // namespace taut
