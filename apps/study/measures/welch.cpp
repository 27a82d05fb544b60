#include "study/measures/welch.h"

#include <cmath>
#include <limits>

namespace taut::chart {

namespace {

constexpr double kInfinite = std::numeric_limits<double>::infinity();

/// The incomplete beta function's continued fraction (Abramowitz & Stegun 26.5.8) by Lentz's method.
double betaFraction(double a, double b, double x) {
    constexpr int kMost = 1000;
    constexpr double kTiny = 1e-300;
    const auto safe = [](double v) { return std::fabs(v) < kTiny ? kTiny : v; };
    double c = 1;
    double d = 1 / safe(1 - (a + b) * x / (a + 1));
    double h = d;
    for (int m = 1; m < kMost; ++m) {
        const auto step = [&](double coefficient) {
            d = 1 / safe(1 + coefficient * d);
            c = safe(1 + coefficient / c);
            h *= c * d;
            return std::fabs(c * d - 1);
        };
        step(m * (b - m) * x / ((a + 2 * m - 1) * (a + 2 * m)));
        if (step(-(a + m) * (a + b + m) * x / ((a + 2 * m) * (a + 2 * m + 1))) < 1e-15) break;
    }
    return h;
}

/// I_x(a, b).
double incompleteBeta(double a, double b, double x) {
    if (x <= 0 || x >= 1) return x <= 0 ? 0 : 1;
    const double front = std::exp(std::lgamma(a + b) - std::lgamma(a) - std::lgamma(b) + a * std::log(x) + b * std::log1p(-x));
    return x < (a + 1) / (a + b + 2) ? front * betaFraction(a, b, x) / a : 1 - front * betaFraction(b, a, 1 - x) / b;
}

double freedomOf(double varianceA, double samplesA, double varianceB, double samplesB) {
    const auto part = [](double variance, double samples) { return variance > 0 ? variance * variance / (samples - 1) : 0; };
    const double parts = part(varianceA, samplesA) + part(varianceB, samplesB);
    const double sum = varianceA + varianceB;
    return parts > 0 ? sum * sum / parts : kInfinite;
}

} // namespace

double studentTail(double t, double freedom) {
    if (std::isinf(t)) return 0;
    if (std::isinf(freedom)) return std::erfc(std::fabs(t) / std::sqrt(2.0));
    return incompleteBeta(freedom / 2, 0.5, freedom / (freedom + t * t));
}

WelchTest welchTest(const NoisyValues &a, const NoisyValues &b, double level) {
    WelchTest test;
    test.t.assign(a.values.size(), 0);
    const auto samplesOf = [](const NoisyValues &of, std::size_t i) {
        return of.samples.empty() ? kInfinite : static_cast<double>(of.samples[i]);
    };
    for (std::size_t i = 0; i < a.values.size(); ++i) {
        const auto va = static_cast<double>(a.variances[i]);
        const auto vb = static_cast<double>(b.variances[i]);
        const double difference = static_cast<double>(a.values[i]) - static_cast<double>(b.values[i]);
        if (!std::isfinite(va + vb) || !std::isfinite(difference)) continue;
        if (va + vb <= 0 && difference == 0) continue;
        ++test.tested;
        const double t = va + vb > 0 ? difference / std::sqrt(va + vb) : std::copysign(kInfinite, difference);
        test.t[i] = static_cast<float>(t);
        if (studentTail(t, freedomOf(va, samplesOf(a, i), vb, samplesOf(b, i))) < level) ++test.beyond;
        if (std::fabs(t) > test.greatest) {
            test.greatest = std::fabs(t);
            test.at = i;
        }
    }
    return test;
}

} // namespace taut::chart
