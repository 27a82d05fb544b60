#pragma once
/// Least-squares fits of the albedo of the transformed GGX microsurface in the coordinates of microsurface/energy_compensation.h.

#include "study/microsurface/albedo_quadrature.h"

#include "taut/microsurface/energy_compensation.h"

#include <algorithm>
#include <random>
#include <vector>

namespace taut::tables {

/// Weighted linear least squares by the normal equations.
struct Fit {
    std::size_t unknowns;
    std::vector<double> normal, right; ///< A^T W A (lower triangle) and A^T W b

    explicit Fit(std::size_t n) : unknowns(n), normal(n * n), right(n) {}

    void add(const std::vector<double> &row, double value, double weight) {
        for (std::size_t i = 0; i < unknowns; ++i) {
            right[i] += weight * row[i] * value;
            const double scaled = weight * row[i];
            for (std::size_t j = 0; j <= i; ++j) normal[i * unknowns + j] += scaled * row[j];
        }
    }

    /// By Cholesky; a trace of ridge keeps combinations that no surface has at zero.
    [[nodiscard]] std::vector<double> solve() {
        const std::size_t n = unknowns;
        for (std::size_t i = 0; i < n; ++i) normal[i * n + i] += 1e-3;
        for (std::size_t i = 0; i < n; ++i)
            for (std::size_t j = 0; j <= i; ++j) {
                double sum = normal[i * n + j];
                for (std::size_t k = 0; k < j; ++k) sum -= normal[i * n + k] * normal[j * n + k];
                normal[i * n + j] = i == j ? std::sqrt(sum) : sum / normal[j * n + j];
            }
        std::vector<double> x = right;
        for (std::size_t i = 0; i < n; ++i) {
            for (std::size_t k = 0; k < i; ++k) x[i] -= normal[i * n + k] * x[k];
            x[i] /= normal[i * n + i];
        }
        for (std::size_t i = n; i-- > 0;) {
            for (std::size_t k = i + 1; k < n; ++k) x[i] -= normal[k * n + i] * x[k];
            x[i] /= normal[i * n + i];
        }
        return x;
    }
};

struct Surface {
    float rougher, smoother;
    [[nodiscard]] MicroTransform transform() const { return microTransformFromAlpha(rougher, smoother); }
};

/// Alphas spread over the range in both their logarithm and alpha / (1 + alpha); a tenth of the surfaces are isotropic.
inline Surface randomSurface(std::mt19937 &random, float least, float greatest, float aspect) {
    std::uniform_real_distribution<float> unit(0, 1);
    const float u = unit(random);
    const float f = u * greatest / (1 + greatest);
    const float alpha = unit(random) < 0.5F ? least * std::pow(greatest / least, u) : std::fmax(least, f / (1 - f));
    const float ratio = unit(random) < 0.1F ? 1 : std::pow(aspect, -unit(random));
    return {alpha, std::fmax(alpha * ratio, 0.5F * least)};
}

/// A direction whose standard cosine is spread over (0, 1], more at both ends.
inline Vec3 randomDirection(std::mt19937 &random, const Surface &s) {
    std::uniform_real_distribution<float> unit(0, 1);
    const float u = unit(random);
    const float which = unit(random);
    const float c = std::fmax(which < 0.2F ? u * u : which < 0.4F ? 1 - u * u : u, 1e-3F);
    float phi = 0.5F * kPi * unit(random);
    // Half of them even in the standard azimuth, for otherwise the smooth axis of a long ellipse is hardly met.
    if (unit(random) < 0.5F) phi = std::atan2(std::sin(phi) * s.rougher, std::cos(phi) * s.smoother);
    const float along = std::hypot(s.rougher * std::cos(phi), s.smoother * std::sin(phi));
    const float tangent = std::sqrt(1 / (c * c) - 1) / along;
    const float z = 1 / std::sqrt(1 + tangent * tangent);
    return {tangent * z * std::cos(phi), tangent * z * std::sin(phi), z};
}

/// E -> s, and how much E moves with it.
struct Target {
    double s, weight;
};
inline Target target(double albedo, bool inRange) {
    const double e = std::min(std::max(albedo, 1e-5), 1 - 1e-6);
    const double y = std::sqrt(1 / e - 1);
    const double slope = 2 * y / sqr(1 + y * y) * sqr(1 + y);
    return {y / (1 + y), (slope * slope + 0.03) * (inRange ? 4 : 1)};
}
inline bool inRange(const Surface &s) {
    return s.rougher <= 2.1F && s.smoother >= 0.015F;
}

/// Coefficients of energy::table::kAlbedo from `points` random surfaces and directions, `samples` of quadrature each.
inline std::vector<double> fitAlbedo(int points, std::uint32_t samples) {
    std::mt19937 random(1);
    namespace t = energy::table;
    Fit fit(t::kAlbedo.size());
    std::vector<double> row;
    for (int i = 0; i < points; ++i) {
        const Surface s = i % 4 != 0 ? randomSurface(random, 0.015F, 2.2F, 25) : randomSurface(random, 0.005F, energy::kGreatestAlpha, 40);
        const Vec3 w = randomDirection(random, s);
        const auto at = energy::coordinates(s.transform(), w);
        const auto e = energy::chebyshev<t::kElevation>(at.elevation);
        const auto a = energy::chebyshev<t::kAlong>(at.along);
        const auto b = energy::chebyshev<t::kAcross>(at.across);
        const auto r = energy::chebyshev<2>(at.correlation);
        row.clear();
        for (const float x : e)
            for (const float y : a)
                for (const float v : r)
                    for (const float z : b) row.push_back(static_cast<double>(x) * y * v * z);
        const Target to = target(albedo(s.transform(), w, samples), inRange(s));
        fit.add(row, to.s, to.weight);
    }
    return fit.solve();
}

/// Coefficients of energy::table::kAverage: the mean, by `samples` directions, of the albedo with the given coefficients.
inline std::vector<double> fitAverage(const std::vector<double> &albedoCoefficients, int points, std::uint32_t samples) {
    std::mt19937 random(2);
    namespace t = energy::table;
    const std::vector<float> coefficients(albedoCoefficients.begin(), albedoCoefficients.end());
    Fit fit(t::kAverage.size());
    std::vector<double> row;
    for (int i = 0; i < points; ++i) {
        const Surface s = i % 4 != 0 ? randomSurface(random, 0.015F, 2.2F, 25) : randomSurface(random, 0.005F, energy::kGreatestAlpha, 40);
        const auto x = energy::chebyshev<t::kAverageDegree>(energy::roughnessCoordinate(s.rougher));
        const auto y = energy::chebyshev<t::kAverageDegree>(energy::roughnessCoordinate(s.smoother));
        row.clear();
        for (const float a : x)
            for (const float b : y) row.push_back(static_cast<double>(a) * static_cast<double>(b));
        double mean = 0;
        for (std::uint32_t k = 0; k < samples; ++k) {
            const Vec3 w = squareToCosineHemisphere(sobol2(k, 777));
            mean += w.z > 0 ? static_cast<double>(energy::singleScatterAlbedo(s.transform(), w, coefficients.data())) / samples : 0;
        }
        // What matters is the relative error of the loss, y^2 / (1 + y^2), by which all compensation scales.
        const Target to = target(mean, inRange(s));
        const double loss = std::max(1 - mean, 1e-4);
        fit.add(row, to.s, to.weight / (loss * std::sqrt(loss)));
    }
    return fit.solve();
}

} // namespace taut::tables
