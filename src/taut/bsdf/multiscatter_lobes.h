#pragma once
/// Light that meets more than one facet, as a BSDF scatters it: the compensating lobe and the random walk. Used by bsdf.h; kept out of
/// line and apart from it, so that single scattering stays as small as it is without.

#include "taut/bsdf/bsdf_dispatch.h"
#include "taut/microsurface/random_walk.h"

#include <optional>

namespace taut {

namespace multiple {

[[gnu::noinline]] inline MultipleScattering prepare(const Bsdf &bsdf, Vec3 wo) {
    const BsdfInfo &info = bsdfInfo(bsdf.type);
    MultipleScattering s;
    if (bsdf.multiscatter == Multiscatter::Walk && info.manyFacets) {
        s.treatment = Multiscatter::Walk;
        if (!info.refracts) s.lossMean = std::max(1 - energy::averageAlbedo(bsdf.micro), 1e-6F); // the fit rounds
    }
    // A view from below the horizon has no albedo in the table: its one bounce is left as it is.
    if (bsdf.multiscatter == Multiscatter::Compensation && info.compensates() && wo.z > 0) {
        s.treatment = Multiscatter::Compensation;
        s.loss = 1 - energy::singleScatterAlbedo(bsdf.micro, wo);
        const float mean = energy::averageAlbedo(bsdf.micro);
        s.lossMean = 1 - mean;
        withInterface(bsdf, [&](const auto &facet) {
            if constexpr (!std::decay_t<decltype(facet)>::kTransmits) {
                s.color = energy::multipleColor(facet.meanReflectance(), mean);
                const float multipleShare = s.loss * luminance(s.color);
                const float singleShare = (1 - s.loss) * luminance(facet.reflectance(wo.z));
                s.probability = multipleShare > 0 ? std::fmin(multipleShare / (multipleShare + singleShare), 0.9F) : 0.0F;
            }
        });
    }
    return s;
}

/// The compensating lobe times the cosine, before its colour; wi.z > 0.
[[gnu::noinline]] inline float compensation(const MicroTransform &m, float loss, float lossMean, Vec3 wi) {
    return energy::multipleLobe(loss, 1 - energy::singleScatterAlbedo(m, wi), lossMean, wi.z);
}

/// From energy to radiance, and the tint of what passes.
inline Vec3 radianceScale(const Bsdf &bsdf, bool transmitted) {
    return transmitted ? bsdf.tint / (bsdf.eta * bsdf.eta) : Vec3(1);
}

/// What the walk scatters towards wi, by the number of facets: of one in closed form with the density of such walks; of more as an
/// estimate, with a stand-in for a density.
///
/// The two are weighed against light samples apart (multiple importance sampling needs weights that add up to one for each part). What
/// a sampled direction's weight should be held against is its density times the estimate's second moment over its mean squared: as if
/// directions were sampled so densely.
struct WalkEval {
    BsdfEval single, multiple;
};

inline float singleWalkPdf(const Bsdf &bsdf, const Vec3 &wo, const Vec3 &wi) {
    if (bsdfInfo(bsdf.type).refracts) return walk::evaluateSingle(bsdf.micro, wo, wi, DielectricInterface{bsdf.eta}).x;
    return wi.z > 0 ? walk::evaluateSingle(bsdf.micro, wo, wi, walk::UniformReflector{}).x : 0.0F;
}
/// Between reflecting facets the light is a share, lossMean, of broad lobes, or on brushed metal of narrow ones; the factors were
/// measured (`taut chart walk`). The estimate through an interface is 0 but where the walk's last lobe holds wi, and then as high as
/// that lobe: its second moment is its mean times the lobe's peak, D / 4.
inline float multipleWalkPdf(const Bsdf &bsdf, const MultipleScattering &scattering, const Vec3 &wi) {
    const float broad = kInvPi * std::fabs(wi.z);
    const float peak = bsdf.micro.det * (kInvPi / 4);
    if (bsdfInfo(bsdf.type).refracts) return std::max(broad, peak);
    return wi.z > 0 ? scattering.lossMean * std::max(1.5F * broad, 2.5F * peak) : 0.0F;
}

/// The interface that one walk is of.
template <class Interface> Interface walked(const Interface &facet, walk::Random &random) {
    if constexpr (requires { facet.partOfWalk(0.0F); })
        return facet.partOfWalk(random.uniform());
    else
        return facet;
}

[[gnu::noinline]] inline WalkEval evaluateWalk(const Bsdf &bsdf, const MultipleScattering &scattering, Vec3 wo, Vec3 wi,
                                              const walk::Numbers &numbers) {
    WalkEval e;
    e.multiple.pdf = multipleWalkPdf(bsdf, scattering, wi);
    if (!(e.multiple.pdf > 0)) return e;
    e.single.pdf = singleWalkPdf(bsdf, wo, wi);
    walk::Random random(numbers.seed);
    const Vec3 scale = radianceScale(bsdf, wi.z < 0);
    withInterface(bsdf, [&](const auto &facet) {
        e.single.fCos = walk::evaluateSingle(bsdf.micro, wo, wi, facet) * scale;
        e.multiple.fCos = walk::evaluateMultiple(bsdf.micro, wo, wi, walked(facet, random), numbers.ends, random) * scale;
    });
    return e;
}

[[gnu::noinline]] inline std::optional<BsdfSample> sampleWalk(const Bsdf &bsdf, const MultipleScattering &scattering, Vec3 wo, Vec2 u,
                                                              std::uint32_t seed) {
    walk::Random random(seed);
    const walk::Exit exit =
        withInterface(bsdf, [&](const auto &facet) { return walk::sample(bsdf.micro, wo, walked(facet, random), u, random); });
    BsdfSample s;
    s.wi = exit.w;
    s.pdf = exit.bounces == 1 ? singleWalkPdf(bsdf, wo, exit.w) : multipleWalkPdf(bsdf, scattering, exit.w);
    s.transmitted = exit.beyond;
    if (exit.throughput == Vec3(0) || !(s.pdf > 0) || s.transmitted != (s.wi.z < 0)) return std::nullopt;
    s.weight = exit.throughput * radianceScale(bsdf, s.transmitted);
    s.etaScale = s.transmitted ? bsdf.eta * bsdf.eta : 1;
    return s;
}

} // namespace multiple
} // namespace taut
