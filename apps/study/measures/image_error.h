#pragma once
/// How far images are from one another, of a reference or of two seeds, and what one renderer needs to reach the error of another.

#include <span>
#include <vector>

namespace taut::chart {

/// Root mean square of the difference over that of the reference.
double relativeRms(std::span<const float> image, std::span<const float> reference);

/// Mean over pixels and colours of the square of the difference, over the square of the reference plus a hundredth of its mean
/// squared, where either lights the pixel: relMSE.
double relativeMse(std::span<const float> image, std::span<const float> reference);

double meanOf(std::span<const float> values);

/// Means of boxes of `size` x `size` pixels of an R G B image, which noise hardly touches; rows and columns that fill none are left out.
std::vector<float> boxed(std::span<const float> rgb, int width, int height, int size);

/// Variance of images of several seeds over pixels and colours, relative to the square of their means.
double relativeVariance(std::span<const std::vector<float>> images);

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
