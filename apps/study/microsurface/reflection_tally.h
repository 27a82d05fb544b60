#pragma once
/// What samplers of reflections waste and vary: the loop that charts time. A sampler S has the shape of
/// ReflectionSampler: S(m, wo), sample(u), pdf(wi).

#include "study/microsurface/normal_samplers.h"

#include "taut/bsdf/bsdf.h"

#include <random>
#include <vector>

namespace taut::chart {

/// Bounded caps (Eto & Tokuyoshi 2023) everywhere, by the same class as the cone.
struct BoundedCaps : ReflectionSampler {
    BoundedCaps(const MicroTransform &m, const Vec3 &wo) : ReflectionSampler(m, wo, 1) {}
};
/// What renders: the cone or bounded caps, by what caps would lose.
struct RenderersChoice : ReflectionSampler {
    RenderersChoice(const MicroTransform &m, const Vec3 &wo) : ReflectionSampler(m, wo, kBearableWaste) {}
};

/// f cos at F = 1, height-correlated, with the density that `sampler` gives wi; wi.z > 0. For wo below the horizon the shape is that
/// of Tokuyoshi 2021. `length` = L(wo).
struct Reflection {
    float fCos, pdf;
};
template <class S> Reflection evaluateReflection(const S &sampler, const MicroTransform &m, const Vec3 &wo, float length, const Vec3 &wi) {
    const float density = ggx::distribution(m, wo, wi);
    const float lengthI = ggx::stretchedLength(m, wi);
    const float shape =
        wo.z > 0 ? ggx::visibility(wo.z, length, wi.z, lengthI, true) : 1 / (ggx::visibleArea(m, wo, length) * (wi.z + lengthI));
    if constexpr (requires { sampler.pdfScale(); })
        return {density * shape * wi.z, density * sampler.pdfScale()};
    else
        return {density * shape * wi.z, sampler.pdf(wi)};
}

/// Of the weights f cos / pdf of single samples, rejected ones as zeros.
struct Tally {
    double samples = 0, valid = 0, sum = 0, squares = 0;
    [[nodiscard]] double rejected() const { return 1 - valid / samples; }
    [[nodiscard]] double variance() const { return squares / samples - sqr(sum / samples); }
};

/// A sample for every number of `u`, over `views` in turn; prepared anew for each (perHit) or once a view.
template <class S>
Tally tallyReflections(const MicroTransform &m, const std::vector<Vec3> &views, const std::vector<Vec2> &u, bool perHit) {
    Tally t;
    t.samples = static_cast<double>(u.size());
    const auto take = [&](const S &sampler, const Vec3 &wo, float length, const Vec2 &number) {
        const auto wi = sampler.sample(number);
        if (!wi) return;
        const Reflection r = evaluateReflection(sampler, m, wo, length, *wi);
        if (!(r.pdf > 0)) return;
        const float weight = r.fCos / r.pdf;
        ++t.valid;
        t.sum += static_cast<double>(weight);
        t.squares += static_cast<double>(weight) * static_cast<double>(weight);
    };
    if (perHit) {
        std::size_t v = 0;
        for (const Vec2 &number : u) {
            take(S(m, views[v]), views[v], ggx::stretchedLength(m, views[v]), number);
            if (++v == views.size()) v = 0;
        }
    } else {
        const std::size_t each = u.size() / views.size();
        for (std::size_t v = 0; v < views.size(); ++v) {
            const S sampler(m, views[v]);
            const float length = ggx::stretchedLength(m, views[v]);
            for (std::size_t i = 0; i < each; ++i) take(sampler, views[v], length, u[v * each + i]);
        }
    }
    return t;
}

inline std::vector<Vec2> uniformPairs(std::size_t count, std::mt19937 &random) {
    std::uniform_real_distribution<float> uniform(0, kOneMinusEpsilon);
    std::vector<Vec2> u(count);
    for (Vec2 &x : u) x = {uniform(random), uniform(random)};
    return u;
}

/// Views at one angle from the normal, in random azimuths.
inline std::vector<Vec3> viewsAt(float thetaDegrees, std::size_t count, std::mt19937 &random) {
    std::uniform_real_distribution<float> uniform(0, kOneMinusEpsilon);
    const float theta = thetaDegrees * kPi / 180;
    std::vector<Vec3> views(count);
    for (Vec3 &w : views) w = Vec3(std::sin(theta) * unitCircle(uniform(random)), std::cos(theta));
    return views;
}

} // namespace taut::chart
