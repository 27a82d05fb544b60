#pragma once
/// Error of images that two seeds made, and what one renderer needs to reach the error of another.

#include <span>
#include <vector>

namespace taut::chart {

/// Median and quartiles of repeated measurements (linear between order statistics).
struct Spread {
    double lower = 0, median = 0, upper = 0;
};
Spread spreadOf(std::vector<double> values);

/// Mean squared error of either of two independent unbiased images of the same distribution: half the mean square of their
/// difference, over all values. The sizes are equal.
double errorOfTwo(std::span<const float> a, std::span<const float> b);

/// Root mean square of the difference of two renderers' expected images over that of their mean image, free of the noise in both:
/// from two independent images of each, E (a1 - b1)(a2 - b2) = (E a - E b)^2. Negative where noise hides the difference.
double expectedDifference(std::span<const float> a1, std::span<const float> a2, std::span<const float> b1, std::span<const float> b2);

/// A renderer's error at a number of samples a pixel.
struct ErrorPoint {
    double samples = 0;
    double error = 0;
};

/// Samples a pixel at which the curve reaches `error`: linear between the points in the logarithms of both, and beyond the ends
/// along the segment there. Points in order of samples, at least two.
double samplesToReach(std::span<const ErrorPoint> curve, double error);

} // namespace taut::chart
