#pragma once
/// A sheet of glass so thin that light leaves it where it came in: both
/// interfaces in one, without refraction. What passes goes straight on, spread
/// as far as what is reflected: the lobe of transmission is that of reflection,
/// mirrored at the surface.
///
/// With R of one interface, T = 1 - R and all the light that bounces to and fro
/// inside, the sheet reflects R' = R + T^2 R / (1 - R^2) = 2 R / (1 + R)
/// (Stokes 1862) and lets 1 - R' pass, times its tint.

#include "taut/bsdf/fresnel.h"
#include "taut/bsdf/reflection_lobe.h"

namespace taut {

struct ThinGlassBsdf {
    static void make(const MaterialValues &material, Bsdf &bsdf) { bsdf.tint = material.color; }

    static BsdfEval evaluate(const BsdfView &view, const Vec3 &wi) {
        if (wi.z == 0) return {};
        const bool passes = wi.z < 0;
        float share = 0; // of samples that go to wi's side
        BsdfEval e = reflectionLobe(view.bsdf.micro, view.lobe, view.wo, Vec3(wi.x, wi.y, std::fabs(wi.z)), [&](float cosine) {
            const float reflected = reflectance(view.bsdf, cosine);
            const float chance = reflectionChance(view.bsdf, reflected);
            share = passes ? 1 - chance : chance;
            return passes ? view.bsdf.tint * (1 - reflected) : Vec3(reflected);
        });
        e.pdf *= share;
        return e;
    }

    /// A reflected direction, mirrored by the sheet's choice.
    static std::optional<Vec3> sample(const BsdfView &view, const Vec2 &u, float lobe) {
        const std::optional<Vec3> wi = view.reflections->sample(u);
        if (!wi) return std::nullopt;
        const Vec3 h = view.wo + *wi;
        const float cosine = glm::dot(view.wo, h) / std::sqrt(glm::dot(h, h));
        if (lobe < reflectionChance(view.bsdf, reflectance(view.bsdf, cosine))) return wi;
        return Vec3(wi->x, wi->y, -wi->z);
    }

  private:
    /// R'.
    static float reflectance(const Bsdf &bsdf, float cosine) {
        const float r = fresnel::dielectric(cosine, bsdf.eta);
        return 2 * r / (1 + r);
    }
    static float reflectionChance(const Bsdf &bsdf, float reflected) {
        const float all = reflected + (1 - reflected) * maxComponent(bsdf.tint);
        return all > 0 ? reflected / all : 1.0F;
    }
};

} // namespace taut
