#pragma once
/// Scattering at one hit: conductor, dielectric, diffuse, and diffuse under a coat, on a transformed GGX microsurface.
///
/// Local shading space: z = shading normal on the viewer's side. The caller turns the frame so that the geometric normal faces
/// the viewer; wo.z may still be negative where an interpolated normal leans away, and is handled (Tokuyoshi 2021).
/// `fCos` is the BSDF times |wi.z|, the only product that stays finite at grazing; it is never split.
///
/// With Multiscatter::Walk evaluation is an unbiased estimate, drawn from `seed`, and a sampled direction's weight is its walk's
/// throughput. The density of the walk is not known; `pdf` of a sample is that of its part in evaluateParts() (multiple_scattering.h):
/// the density of walks of one facet, exact, or a stand-in, so that multiple importance sampling of each part stays unbiased.

#include "taut/base/warp.h"
#include "taut/bsdf/multiple_scattering.h"
#include "taut/bsdf/reflection_lobe.h"
#include "taut/microsurface/reflection_sampler.h"

#include <optional>

namespace taut {

/// 1 - (diffuse reflectance from inside) of a smooth coat of index eta: (1 - R_outside) / eta^2.
inline float coatEscape(float eta) {
    return (1 - fresnel::diffuseReflectance(eta)) / (eta * eta);
}

/// A Bsdf seen from one direction: what evaluation and sampling share, computed once a hit.
class ScatteringPoint {
  public:
    ScatteringPoint(const Bsdf &bsdf, const Vec3 &wo) : bsdf_(bsdf), wo_(wo) {
        if (bsdf.type == BsdfType::Diffuse) return;
        length_ = ggx::stretchedLength(bsdf.micro, wo);
        area_ = ggx::visibleArea(bsdf.micro, wo, length_);
        if (bsdf.type != BsdfType::Dielectric) reflections_.emplace(bsdf.micro, wo, bsdf.bearableWaste);
        if (bsdf.multiscatter != Multiscatter::Off) multiple_ = multiple::prepare(bsdf, wo);
        if (hasDiffuse()) {
            const float reflected = luminance(facetReflectance(bsdf, std::fabs(wo.z)));
            const float below = luminance(bsdf.albedo) * (1 - reflected);
            specularProbability_ = below > 0 ? glm::clamp(reflected / (reflected + below), 0.1F, 0.9F) : 1.0F;
        }
    }

    /// fCos and pdf of a given wi. `seed` names the walk, where there is one: another one for every call of a path.
    [[nodiscard]] BsdfEval evaluate(const Vec3 &wi, std::uint32_t seed = 0) const {
        if (bsdf_.type == BsdfType::Diffuse) return diffuse(wi);
        if (multiple_.treatment == Multiscatter::Walk) {
            const multiple::WalkEval e = multiple::evaluateWalk(bsdf_, wo_, wi, seed);
            return {e.single.fCos + e.multiple.fCos, e.single.pdf + e.multiple.pdf};
        }
        if (wi.z <= 0) return bsdf_.type == BsdfType::Dielectric ? transmission(wi) : BsdfEval{};
        BsdfEval e = reflection(wi);
        if (bsdf_.type == BsdfType::Dielectric) return e;
        if (multiple_.treatment == Multiscatter::Compensation) {
            e.fCos += multiple_.color * multiple::compensation(bsdf_.micro, multiple_.loss, multiple_.lossMean, wi);
            e.pdf = (1 - multiple_.probability) * e.pdf + multiple_.probability * (kInvPi * wi.z);
        }
        e.pdf *= specularProbability_;
        if (hasDiffuse()) {
            const BsdfEval d = substrate(wi);
            e.fCos += d.fCos;
            e.pdf += (1 - specularProbability_) * d.pdf;
        }
        return e;
    }

    /// The same in the parts that are weighed against light samples one by one: all of it is `single` but for a walk's second and later
    /// facets.
    [[nodiscard]] multiple::WalkEval evaluateParts(const Vec3 &wi, std::uint32_t seed = 0) const {
        if (multiple_.treatment == Multiscatter::Walk) return multiple::evaluateWalk(bsdf_, wo_, wi, seed);
        return {evaluate(wi), {}};
    }

    /// A wi with density evaluate(wi).pdf, or nothing where the sampled normal reflects below the horizon. `lobe` chooses
    /// between lobes, `u` the direction; both uniform in [0, 1). `seed` as above.
    [[nodiscard]] std::optional<BsdfSample> sample(const Vec2 &u, float lobe, std::uint32_t seed = 0) const {
        if (multiple_.treatment == Multiscatter::Walk) return multiple::sampleWalk(bsdf_, wo_, u, seed);
        if (multiple_.treatment == Multiscatter::Compensation && lobe < multiple_.probability) return finish(squareToCosineHemisphere(u));
        if (bsdf_.type == BsdfType::Diffuse || (hasDiffuse() && lobe >= specularProbability_)) {
            return finish(squareToCosineHemisphere(u));
        }
        if (bsdf_.type == BsdfType::Dielectric) return sampleInterface(u, lobe);
        // What is left of the number that chose the lobe is uniform again.
        const float coin =
            multiple_.probability > 0 ? (lobe - multiple_.probability) / (1 - multiple_.probability) : lobe / specularProbability_;
        const auto wi = reflections_->sample(u, coin);
        return wi ? finish(*wi) : std::nullopt;
    }

  private:
    [[nodiscard]] bool hasDiffuse() const {
        return (bsdf_.type == BsdfType::Coated || bsdf_.type == BsdfType::MetallicRoughness) && bsdf_.albedo != Vec3(0);
    }

    /// Dielectric: a visible normal, then reflection or refraction by Fresnel's choice.
    [[nodiscard]] std::optional<BsdfSample> sampleInterface(const Vec2 &u, float lobe) const {
        const Vec3 wm = ggx::spreadVisibleNormal(bsdf_.micro, wo_, u);
        const float cosine = glm::dot(wo_, wm);
        if (!(cosine > 0)) return std::nullopt;
        if (lobe >= fresnel::dielectric(cosine, bsdf_.eta)) {
            Vec3 wi;
            if (!fresnel::refract(wo_, wm, cosine, bsdf_.eta, wi) || !(wi.z < 0)) return std::nullopt;
            return finish(wi);
        }
        const Vec3 wi = glm::normalize(2 * cosine * wm - wo_);
        return wi.z > 0 ? finish(wi) : std::nullopt;
    }

    [[nodiscard]] std::optional<BsdfSample> finish(const Vec3 &wi) const {
        const BsdfEval e = evaluate(wi);
        if (!(e.pdf > 0)) return std::nullopt;
        BsdfSample s;
        s.wi = wi;
        s.pdf = e.pdf;
        s.weight = e.fCos * (1 / e.pdf);
        s.transmitted = wi.z < 0;
        s.etaScale = s.transmitted ? bsdf_.eta * bsdf_.eta : 1;
        return s;
    }

    [[nodiscard]] BsdfEval diffuse(const Vec3 &wi) const {
        if (wi.z <= 0) return {};
        return {bsdf_.albedo * (kInvPi * wi.z), kInvPi * wi.z};
    }

    /// Lambertian layer under a smooth-interface approximation of the coat: albedo / pi T(wo) T(wi) / (eta^2 (1 - albedo R_in)),
    /// which reflects everything the coat lets through where albedo = 1.
    [[nodiscard]] BsdfEval substrate(const Vec3 &wi) const {
        const float in = 1 - fresnel::dielectric(wi.z, bsdf_.eta);
        const float out = 1 - fresnel::dielectric(std::fabs(wo_.z), bsdf_.eta);
        const Vec3 series = bsdf_.albedo / (Vec3(1) - bsdf_.albedo * (1 - bsdf_.diffuseEscape));
        return {series * (kInvPi * wi.z * in * out / (bsdf_.eta * bsdf_.eta)), kInvPi * wi.z};
    }

    /// Reflection lobe: F D visibility cos, and the density of its sampling, which is D times a constant.
    [[nodiscard]] BsdfEval reflection(const Vec3 &wi) const {
        const LobeView view{length_, area_, reflections_ ? reflections_->pdfScale() : 0.5F / area_, bsdf_.correlated};
        float facet = 1;
        BsdfEval e = reflectionLobe(bsdf_.micro, view, wo_, wi, [&](float cosine) {
            const Vec3 f = facetReflectance(bsdf_, cosine);
            facet = f.x;
            return f;
        });
        if (bsdf_.type == BsdfType::Dielectric) e.pdf *= facet;
        return e;
    }

    /// Refraction lobe, for wi.z < 0.
    [[nodiscard]] BsdfEval transmission(const Vec3 &wi) const {
        if (wi.z >= 0) return {};
        const LobeView view{length_, area_, 0, bsdf_.correlated};
        const BsdfEval e = refractionLobe(bsdf_.micro, view, wo_, wi, bsdf_.eta, bsdf_.tint);
        return e.pdf > 0 ? e : BsdfEval{};
    }

    const Bsdf &bsdf_;
    Vec3 wo_;
    float length_ = 1; ///< L(wo)
    float area_ = 1;   ///< wo.z + L(wo), stable
    float specularProbability_ = 1;
    std::optional<ReflectionSampler> reflections_; ///< all but diffuse and dielectric
    MultipleScattering multiple_;
};

} // namespace taut
