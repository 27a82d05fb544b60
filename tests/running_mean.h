#pragma once
/// Directions by their angles, and means of random numbers with their errors.

#include "taut/base/vec.h"

#include <algorithm>
#include <cmath>

namespace taut::test {

/// Unit; theta from z, phi from x towards y.
inline Vec3 direction(double thetaDegrees, double phiDegrees) {
    const double t = radians(thetaDegrees);
    const double p = radians(phiDegrees);
    return {static_cast<float>(std::sin(t) * std::cos(p)), static_cast<float>(std::sin(t) * std::sin(p)), static_cast<float>(std::cos(t))};
}

struct RunningMean {
    double sum = 0, squares = 0;
    int count = 0;
    void add(double x) {
        sum += x;
        squares += x * x;
        ++count;
    }
    [[nodiscard]] double mean() const { return sum / count; }
    [[nodiscard]] double variance() const { return std::max(0.0, squares / count - mean() * mean()) / count; } ///< of the mean
    /// Distance of the mean from `truth` in standard errors.
    [[nodiscard]] double off(double truth) const { return std::fabs(mean() - truth) / std::sqrt(variance() + 1e-18); }
};

} // namespace taut::test
