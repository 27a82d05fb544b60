#pragma once
/// Scattering at one hit, by any kind of BSDF (bsdf_table.h).
///
/// Local shading space: z = shading normal on the viewer's side. The caller turns the frame so that the geometric normal faces
/// the viewer; wo.z may still be negative where an interpolated normal leans away, and is handled (Tokuyoshi 2021).
/// `fCos` is the BSDF times |wi.z|, the only product that stays finite at grazing; it is never split.
///
/// With Multiscatter::Walk evaluation is an unbiased estimate, drawn from `seed`, and a sampled direction's weight is its walk's
/// throughput. The density of the walk is not known; `pdf` of a sample is that of its part in evaluateParts() (multiscatter_lobes.h):
/// the density of walks of one facet, exact, or a stand-in, so that multiple importance sampling of each part stays unbiased.

#include "taut/bsdf/multiscatter_lobes.h"

namespace taut {

/// Stands for the density of a single direction: its square is a float, and outweighs those of light samples.
inline constexpr float kDeltaPdf = 1e18F;

/// A Bsdf seen from one direction: what evaluation and sampling share, computed once a hit.
class ScatteringPoint {
  public:
    ScatteringPoint(const Bsdf &bsdf, const Vec3 &wo) : view_{bsdf, wo, {}, std::nullopt} {
        const BsdfInfo &info = bsdfInfo(bsdf.type);
        if (!info.microsurface) return;
        passes_ = info.refracts && fresnel::isMatched(bsdf.eta);
        if (passes_) return;
        const float length = ggx::stretchedLength(bsdf.micro, wo);
        const float area = ggx::visibleArea(bsdf.micro, wo, length);
        if (!info.refracts) view_.reflections.emplace(bsdf.micro, wo, bsdf.bearableWaste);
        view_.lobe = {length, area, info.refracts ? 0.5F / area : view_.reflections->pdfScale(), bsdf.correlated, bsdf.eta, {}};
        if (bsdf.multiscatter != Multiscatter::Off) multiple_ = multiple::prepare(bsdf, wo);
        onBsdf(bsdf.type, [&](auto kind) {
            using Class = typename decltype(kind)::Class;
            if constexpr (requires { Class::split(bsdf, wo); }) view_.lobe.shares.facets = Class::split(bsdf, wo);
            if constexpr (requires { Class::prepare(view_, multiple_); }) Class::prepare(view_, multiple_);
        });
    }

    /// fCos and pdf of a given wi. `seed` names the walk, where there is one: another one for every call of a path.
    [[nodiscard]] BsdfEval evaluate(const Vec3 &wi, const walk::Numbers &numbers = {}) const {
        if (passes_) return {}; // straight on alone, which no other sampler meets
        if (multiple_.treatment == Multiscatter::Walk) {
            const multiple::WalkEval e = evaluateParts(wi, numbers);
            const BsdfEval lobes = evaluateBeside(wi);
            return {e.single.fCos + e.multiple.fCos + lobes.fCos, e.single.pdf + e.multiple.pdf + lobes.pdf};
        }
        if (multiple_.treatment == Multiscatter::Off) return evaluateSingle(wi);
        BsdfEval e = evaluateSingle(wi);
        if (wi.z > 0) {
            e.fCos += multiple_.color * multiple::compensation(view_.bsdf.micro, multiple_.loss, multiple_.lossMean, wi);
            e.pdf = (1 - multiple_.probability) * e.pdf + multiple_.probability * (kInvPi * wi.z);
        }
        return e;
    }

    /// In the parts that are weighed against light samples one by one: all of it is `single` but for a walk's second and later facets,
    /// and what evaluateBeside() gives.
    [[nodiscard]] multiple::WalkEval evaluateParts(const Vec3 &wi, const walk::Numbers &numbers = {}) const {
        if (multiple_.treatment != Multiscatter::Walk) return {evaluate(wi), {}};
        multiple::WalkEval e = multiple::evaluateWalk(view_.bsdf, multiple_, view_.wo, wi, numbers);
        if (!walksBesideLobes()) return e;
        for (BsdfEval *part : {&e.single, &e.multiple}) {
            part->fCos *= view_.lobe.shares.under;
            part->pdf *= view_.lobe.shares.facets;
        }
        return e;
    }
    /// With a walk: the lobes beside it, a third part.
    [[nodiscard]] BsdfEval evaluateBeside(const Vec3 &wi) const {
        if (multiple_.treatment != Multiscatter::Walk) return {};
        return onBsdf(view_.bsdf.type, [&](auto kind) -> BsdfEval {
            if constexpr (requires { decltype(kind)::Class::beside(view_, wi); }) return decltype(kind)::Class::beside(view_, wi);
            return {};
        });
    }

    /// A wi with density evaluate(wi).pdf, or nothing where the sampled normal reflects below the horizon. `lobe` chooses
    /// between lobes, `u` the direction; both uniform in [0, 1). `seed` as above.
    [[nodiscard]] std::optional<BsdfSample> sample(const Vec2 &u, float lobe, std::uint32_t seed = 0) const {
        if (passes_) return BsdfSample{-view_.wo, view_.bsdf.tint, kDeltaPdf, 1, true};
        if (multiple_.treatment == Multiscatter::Walk) return sampleWalk(u, lobe, seed);
        if (multiple_.treatment == Multiscatter::Compensation && lobe < multiple_.probability) return finish(squareToCosineHemisphere(u));
        // What is left of the number that chose the lobe is uniform again.
        const float rest = multiple_.probability > 0 ? (lobe - multiple_.probability) / (1 - multiple_.probability) : lobe;
        return onBsdf(view_.bsdf.type, [&](auto kind) -> std::optional<BsdfSample> {
            const std::optional<Vec3> wi = decltype(kind)::Class::sample(view_, u, rest);
            return wi ? finish(*wi) : std::nullopt;
        });
    }

  private:
    [[nodiscard]] bool walksBesideLobes() const { return bsdfInfo(view_.bsdf.type).reads(kMetallicKey); }

    [[nodiscard]] std::optional<BsdfSample> sampleWalk(const Vec2 &u, float lobe, std::uint32_t seed) const {
        if (!walksBesideLobes()) return multiple::sampleWalk(view_.bsdf, multiple_, view_.wo, u, seed);
        const float facets = view_.lobe.shares.facets;
        if (lobe < facets) {
            std::optional<BsdfSample> s = multiple::sampleWalk(view_.bsdf, multiple_, view_.wo, u, seed);
            if (!s) return s;
            s->weight *= view_.lobe.shares.under / facets;
            s->pdf *= facets;
            return s;
        }
        return onBsdf(view_.bsdf.type, [&](auto kind) -> std::optional<BsdfSample> {
            using Class = typename decltype(kind)::Class;
            if constexpr (requires { Class::sampleBeside(view_, u, lobe); }) {
                const std::optional<Vec3> wi = Class::sampleBeside(view_, u, (lobe - facets) / (1 - facets));
                return wi ? sampled(*wi, Class::beside(view_, *wi)) : std::nullopt;
            }
            return std::nullopt;
        });
    }

    [[nodiscard]] BsdfEval evaluateSingle(const Vec3 &wi) const {
        return onBsdf(view_.bsdf.type, [&](auto kind) { return decltype(kind)::Class::evaluate(view_, wi); });
    }

    /// Made in place: an optional that is copied after its parts were written waits for them.
    [[nodiscard]] std::optional<BsdfSample> finish(const Vec3 &wi) const { return sampled(wi, evaluate(wi)); }
    [[nodiscard]] std::optional<BsdfSample> sampled(const Vec3 &wi, const BsdfEval &e) const {
        std::optional<BsdfSample> out;
        if (!(e.pdf > 0)) return out;
        BsdfSample &s = out.emplace();
        s.wi = wi;
        s.pdf = e.pdf;
        s.weight = e.fCos * (1 / e.pdf);
        s.transmitted = wi.z < 0;
        s.etaScale = s.transmitted && (bsdfInfo(view_.bsdf.type).refracts || view_.bsdf.refracts) ? view_.bsdf.eta * view_.bsdf.eta : 1;
        return out;
    }

    BsdfView view_;
    MultipleScattering multiple_;
    bool passes_ = false; ///< glass of the index of what is around it: straight on
};

} // namespace taut
