#pragma once
/// Whether two noisy pictures differ by more than their noise: Welch's t-test at every value.
///
/// Welch: The generalization of "Student's" problem when several different population variances are involved (Biometrika 34, 1947).

#include <cstddef>
#include <span>
#include <vector>

namespace taut::chart {

/// Probability that Student's t of `freedom` degrees is beyond +-t; infinite freedom is the normal distribution.
double studentTail(double t, double freedom);

/// A picture with the variances of its values, which are means of so many samples.
struct NoisyValues {
    std::span<const float> values, variances; ///< equally many
    std::span<const float> samples;           ///< likewise; empty: so many that variances are certain
};

struct WelchTest {
    std::size_t tested = 0; ///< values of which either has a variance, or that differ
    std::size_t beyond = 0; ///< of them beyond the bound
    double greatest = 0;    ///< |t|
    std::size_t at = 0;     ///< where
    std::vector<float> t;   ///< (a - b) / sqrt(va + vb) at each value, 0 where both are the same without a variance; may be infinite
    [[nodiscard]] double share() const { return tested > 0 ? static_cast<double>(beyond) / static_cast<double>(tested) : 0; }
};

/// Values that differ by more than chance does with probability `level`, by degrees of freedom after Welch and Satterthwaite. A value
/// whose variance is not finite is not tested, and has a t of 0.
WelchTest welchTest(const NoisyValues &a, const NoisyValues &b, double level = 0.05);

} // namespace taut::chart
