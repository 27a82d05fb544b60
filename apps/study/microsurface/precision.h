#pragma once
/// How many digits float (or double) leaves: every formulation of reference.h against the stable forms in long double, over alpha 1e-4 ..
/// 10, stretch 1e-3 .. 1e3, shear 0 .. 1e3 and views to 89.999 degrees. For charts and tests.
///
/// The surface is M = [1 shear; 0 1] diag(stretch, 1) / alpha. The truth is evaluated at the float inputs (the canonical M, wo and wi as
/// they were rounded), so an error is the formula's own. `kRoundedInputs` is the exception: the stable forms against the truth
/// at the inputs before rounding, which no formula can do better than.

#include "study/microsurface/reference.h"

#include <algorithm>
#include <array>
#include <random>
#include <string>
#include <vector>

namespace taut::precision {

inline constexpr std::size_t kQuantities = 4;
inline constexpr std::array<const char *, kQuantities> kQuantityNames{"D", "G1", "pdf", "weight"};

/// Where in the sweep a sample lies.
struct Place {
    float alpha = 1;
    float stretch = 1;
    float shear = 0;
    float theta = 0;     ///< of wo, degrees
    bool inLobe = false; ///< wi was sampled by a visible normal; else it is anywhere above the horizon
};

struct Sample {
    Place place;
    std::array<double, kQuantities> error{}; ///< relative; infinite where the value is not finite
    MicroTransform m = {};                   ///< what was evaluated, in float
    Vec3 wo = {}, wi = {};
};

struct Formulation {
    const char *name;
    std::vector<Sample> samples;
};

/// Their order in sweep().
enum FormulationIndex : std::size_t { kStable, kRoundedInputs, kWalter, kCosineSquared, kChain, kTensor, kTextbook, kFormulations };

struct Summary {
    double median = 0;
    double most = 0; ///< 99 % are below
    double greatest = 0;
    Place worst;
    std::size_t count = 0;
    std::size_t notFinite = 0;
};

/// Of the samples for which `where`(Place) holds.
template <class Where> Summary summarize(const Formulation &formulation, std::size_t quantity, const Where &where) {
    Summary summary;
    std::vector<double> errors;
    for (const Sample &sample : formulation.samples) {
        if (!where(sample.place)) continue;
        const double error = sample.error[quantity];
        if (!std::isfinite(error)) ++summary.notFinite;
        if (errors.empty() || error > summary.greatest) {
            summary.greatest = error;
            summary.worst = sample.place;
        }
        errors.push_back(error);
    }
    summary.count = errors.size();
    if (errors.empty()) return summary;
    std::sort(errors.begin(), errors.end());
    summary.median = errors[errors.size() / 2];
    summary.most = errors[errors.size() * 99 / 100];
    return summary;
}

/// Where a quantity is off by more than `tolerance`, one parameter at a time, the others harmless (alpha 1, stretch 1, shear 0, theta
/// below 85 degrees); theta at any alpha.
struct FailingRegion {
    float alphaUpTo = 0;         ///< fails at alphas up to this one; 0: nowhere
    float shearFrom = kInfinity; ///< infinite: nowhere; likewise below
    float stretchRatioFrom = kInfinity;
    float thetaFrom = kInfinity;
};
inline FailingRegion failingRegion(const Formulation &formulation, std::size_t quantity, double tolerance) {
    FailingRegion region;
    for (const Sample &sample : formulation.samples) {
        if (sample.error[quantity] <= tolerance) continue;
        const Place &at = sample.place;
        const float ratio = std::fmax(at.stretch, 1 / at.stretch);
        const bool easyAlpha = std::fabs(at.alpha - 1) < 0.01F;
        const bool easyView = at.theta < 85;
        if (at.shear == 0 && ratio < 1.01F && easyView) region.alphaUpTo = std::fmax(region.alphaUpTo, at.alpha);
        if (easyAlpha && ratio < 1.01F && easyView) region.shearFrom = std::fmin(region.shearFrom, at.shear);
        if (easyAlpha && at.shear == 0 && easyView) region.stretchRatioFrom = std::fmin(region.stretchRatioFrom, ratio);
        if (at.shear == 0 && ratio < 1.01F) region.thetaFrom = std::fmin(region.thetaFrom, at.theta);
    }
    return region;
}

/// Calls f(index, make) for every form with arithmetic of its own; make(m, its alphas) prepares it.
template <class T, class F> void forEachForm(const F &f) {
    using M = BasicMicroTransform<T>;
    using Alpha = BasicEquivalentAlpha<T>;
    f(kStable, [](const M &m, const Alpha &) { return reference::Stable<T>(m); });
    f(kTextbook, [](const M &, const Alpha &alpha) { return reference::Textbook<T>(alpha); });
    f(kWalter, [](const M &, const Alpha &alpha) { return reference::Walter<T>(alpha); });
    f(kCosineSquared, [](const M &, const Alpha &alpha) { return reference::CosineSquared<T>(alpha); });
    f(kChain, [](const M &m, const Alpha &) { return reference::JacobianChain<T>(m); });
    f(kTensor, [](const M &m, const Alpha &) { return reference::Tensor<T>(m); });
}

namespace detail {

using Real = long double;
using Exact = Vector3<Real>;
using Values = std::array<Real, kQuantities>;

template <class F, class V> Values values(const F &f, const V &wo, const V &wi) {
    return {f.D(wo, wi), f.G1(wo), f.reflectionPdf(wo, wi), f.weight(wo, wi)};
}

/// The quantities by the stable forms in long double at the same inputs.
template <class T> Values truthAt(const BasicMicroTransform<T> &m, const Vector3<T> &wo, const Vector3<T> &wi) {
    return values(reference::Stable<Real>(canonicalTransform<Real>(m.a, m.b, m.d)), Exact(wo), Exact(wi));
}

/// The quantities by every formulation in T; those that know M by its alphas get them rounded from long double.
template <class T> std::array<Values, kFormulations> evaluate(const BasicMicroTransform<T> &m, const Vector3<T> &wo, const Vector3<T> &wi) {
    const auto exact = equivalentAlpha(canonicalTransform<Real>(m.a, m.b, m.d));
    const BasicEquivalentAlpha<T> alpha{static_cast<T>(exact.max), static_cast<T>(exact.min), static_cast<T>(exact.phi)};
    std::array<Values, kFormulations> found{};
    forEachForm<T>([&](FormulationIndex i, const auto &make) { found[i] = values(make(m, alpha), wo, wi); });
    found[kRoundedInputs] = found[kStable];
    return found;
}

inline Sample sampleOf(const Sample &inputs, const Values &found, const Values &truth) {
    Sample sample = inputs;
    for (std::size_t i = 0; i < kQuantities; ++i) {
        const Real error = std::fabs(found[i] - truth[i]);
        sample.error[i] = std::isfinite(found[i]) ? static_cast<double>(error == 0 ? 0 : error / truth[i]) : INFINITY;
    }
    return sample;
}

inline Exact directionAt(Real thetaDegrees, Real phi) {
    const Real theta = thetaDegrees * std::numbers::pi_v<Real> / 180;
    return {std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), std::cos(theta)};
}

inline constexpr std::array<float, 8> kThetas{0, 30, 60, 80, 89, 89.9F, 89.99F, 89.999F};

/// Half by a visible normal, as a renderer samples; half anywhere above the horizon, grazing too.
template <class Random> Exact drawWi(const BasicMicroTransform<Real> &m, const Exact &wo, Random &random, bool &inLobe) {
    std::uniform_real_distribution<Real> uniform(0, 1);
    const Real choice = uniform(random);
    const Vector2<Real> u(uniform(random), uniform(random));
    const Exact wm = ggx::sampleVisibleNormal(m, wo, u);
    const Exact wi = 2 * glm::dot(wo, wm) * wm - wo;
    inLobe = choice < 0.5L && wi.z > 1e-5L;
    if (inLobe) return wi;
    return directionAt(kThetas[static_cast<std::size_t>(u.x * kThetas.size())], 2 * std::numbers::pi_v<Real> * u.y);
}

} // namespace detail

/// Takes samples at places, from one fixed seed, with the formulations evaluated in T.
template <class T> class Sweep {
    using Real = detail::Real;
    using Exact = detail::Exact;

  public:
    Sweep() : all_(kFormulations) {
        const std::array<const char *, kFormulations> names{
            "stable", "stable, inputs rounded", "Walter, tan^2", "cos^2", "chain of Jacobians", "tensor S", "textbook, x^2/alpha^2"};
        for (std::size_t i = 0; i < kFormulations; ++i) all_[i].name = names[i];
    }

    /// One sample of every formulation; none where wo or wi rounds to the horizon.
    void visit(Place place) {
        using namespace detail;
        const Real scale = jitter_(random_) / place.alpha;
        const auto exactM =
            microTransform<Real>(place.stretch * jitter_(random_) * scale, place.shear * jitter_(random_) * scale, 0, scale);
        using W = Wider<T>;
        const auto m = canonicalTransform<T>(W(exactM.a), W(exactM.b), W(exactM.d));
        const Exact exactWo = directionAt(place.theta, turn_(random_));
        const Exact exactWi = drawWi(exactM, exactWo, random_, place.inLobe);
        const Vector3<T> wo(exactWo);
        const Vector3<T> wi(exactWi);
        if (!(wi.z > 0) || !(wo.z > 0)) return;
        const Values truth = truthAt(m, wo, wi);
        const Values unrounded = values(reference::Stable<Real>(exactM), exactWo, exactWi);
        const std::array<Values, kFormulations> found = evaluate(m, wo, wi);
        const Sample at{place, {}, canonicalTransform(double(m.a), double(m.b), double(m.d)), Vec3(wo), Vec3(wi)};
        for (std::size_t i = 0; i < kFormulations; ++i)
            all_[i].samples.push_back(sampleOf(at, found[i], i == kRoundedInputs ? unrounded : truth));
    }

    [[nodiscard]] const std::vector<Formulation> &formulations() const { return all_; }

  private:
    std::vector<Formulation> all_;
    std::mt19937 random_{1};
    std::uniform_real_distribution<Real> turn_{0, 2 * std::numbers::pi_v<Real>};
    std::uniform_real_distribution<Real> jitter_{1, 1.1L}; ///< round numbers are often exact in float, and flatter
};

/// The whole sweep; `perPlace` samples at each of its 3080 places.
template <class T = float> std::vector<Formulation> sweep(int perPlace = 16) {
    Sweep<T> samples;
    for (int half = -8; half <= 2; ++half) // alpha in half decades
        for (int decade = -3; decade <= 3; ++decade)
            for (const float shear : {0.0F, 1.0F, 10.0F, 100.0F, 1000.0F})
                for (const float theta : detail::kThetas) {
                    const Place place{std::pow(10.0F, 0.5F * static_cast<float>(half)), std::pow(10.0F, static_cast<float>(decade)), shear,
                                      theta, false};
                    for (int i = 0; i < perPlace; ++i) samples.visit(place);
                }
    return samples.formulations();
}

} // namespace taut::precision
