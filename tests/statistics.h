#pragma once
/// Chi-squared goodness of fit for samplers, with pooled bins and a correction for the number of tests.

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

namespace taut::test {

/// Regularised upper incomplete gamma Q(a, x): the chance of a chi-squared at least 2x with 2a degrees of freedom.
inline double upperGamma(double a, double x) {
    if (x <= 0) return 1;
    if (x < a + 1) { // series for P
        double sum = 1 / a;
        double term = sum;
        for (double n = a + 1; term > sum * 1e-16; ++n) sum += (term *= x / n);
        return 1 - sum * std::exp(-x + a * std::log(x) - std::lgamma(a));
    }
    double b = x + 1 - a; // continued fraction (Lentz)
    double c = 1e300;
    double d = 1 / b;
    double h = d;
    for (int i = 1; i < 10000; ++i) {
        const double an = -i * (i - a);
        b += 2;
        d = 1 / std::max(1e-300, an * d + b);
        c = b + an / c;
        const double delta = d * c;
        h *= delta;
        if (std::fabs(delta - 1) < 1e-15) break;
    }
    return h * std::exp(-x + a * std::log(x) - std::lgamma(a));
}

/// p-value of observed counts against expected ones. Neighbouring bins are pooled until each group expects at least five; what is
/// left over at the end joins the last group.
inline double chiSquaredP(const std::vector<double> &observed, const std::vector<double> &expected) {
    std::vector<std::pair<double, double>> groups{{0, 0}}; // observed, expected
    for (std::size_t i = 0; i < observed.size(); ++i) {
        if (groups.back().second >= 5) groups.emplace_back(0, 0);
        groups.back().first += observed[i];
        groups.back().second += expected[i];
    }
    if (groups.size() > 1 && groups.back().second < 5) {
        const auto leftOver = groups.back();
        groups.pop_back();
        groups.back().first += leftOver.first;
        groups.back().second += leftOver.second;
    }
    double statistic = 0;
    for (const auto &[o, e] : groups) statistic += (o - e) * (o - e) / e;
    return groups.size() > 1 ? upperGamma(0.5 * static_cast<double>(groups.size() - 1), 0.5 * statistic) : 1;
}

/// Sidak: the level of one test among `tests` so that all together fail by chance with probability `level`.
inline double sidak(double level, int tests) {
    return 1 - std::pow(1 - level, 1.0 / tests);
}

} // namespace taut::test
