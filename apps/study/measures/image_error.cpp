#include "study/measures/image_error.h"

#include "taut/base/vec.h"

#include <cmath>
#include <cstddef>

namespace taut::chart {

double relativeRms(std::span<const float> image, std::span<const float> reference) {
    double difference = 0;
    double size = 0;
    for (std::size_t i = 0; i < image.size(); ++i) {
        difference += sqr(static_cast<double>(image[i] - reference[i]));
        size += sqr(static_cast<double>(reference[i]));
    }
    return std::sqrt(difference / size);
}

std::vector<float> boxed(std::span<const float> rgb, int width, int height, int size) {
    std::vector<float> means;
    for (int y = 0; y + size <= height; y += size)
        for (int x = 0; x + size <= width; x += size)
            for (int c = 0; c < 3; ++c) {
                double sum = 0;
                for (int v = y; v < y + size; ++v)
                    for (int u = x; u < x + size; ++u) sum += static_cast<double>(rgb[static_cast<std::size_t>(3 * (v * width + u) + c)]);
                means.push_back(static_cast<float>(sum / (size * size)));
            }
    return means;
}

double relativeMse(std::span<const float> image, std::span<const float> reference) {
    const auto lit = [&](std::size_t pixel) {
        float sum = 0;
        for (std::size_t c = 0; c < 3; ++c) sum += reference[3 * pixel + c] + image[3 * pixel + c];
        return sum > 0;
    };
    double mean = 0;
    std::size_t count = 0;
    for (std::size_t pixel = 0; pixel < image.size() / 3; ++pixel) {
        if (!lit(pixel)) continue;
        for (std::size_t c = 0; c < 3; ++c) mean += static_cast<double>(reference[3 * pixel + c]);
        count += 3;
    }
    mean /= static_cast<double>(count);
    double sum = 0;
    for (std::size_t pixel = 0; pixel < image.size() / 3; ++pixel) {
        if (!lit(pixel)) continue;
        for (std::size_t c = 3 * pixel; c < 3 * pixel + 3; ++c)
            sum += sqr(static_cast<double>(image[c] - reference[c])) / (sqr(static_cast<double>(reference[c])) + 0.01 * mean * mean);
    }
    return sum / static_cast<double>(count);
}

double meanOf(std::span<const float> values) {
    double sum = 0;
    for (const float v : values) sum += static_cast<double>(v);
    return sum / static_cast<double>(values.size());
}

double relativeVariance(std::span<const std::vector<float>> images) {
    const auto count = static_cast<double>(images.size());
    double variance = 0;
    double size = 0;
    for (std::size_t i = 0; i < images[0].size(); ++i) {
        double mean = 0;
        double squares = 0;
        for (const std::vector<float> &image : images) {
            mean += static_cast<double>(image[i]) / count;
            squares += sqr(static_cast<double>(image[i]));
        }
        variance += (squares - count * sqr(mean)) / (count - 1);
        size += sqr(mean);
    }
    return variance / size;
}

double errorOfTwo(std::span<const float> a, std::span<const float> b) {
    double sum = 0;
    for (std::size_t i = 0; i < a.size(); ++i) {
        const double difference = static_cast<double>(a[i]) - static_cast<double>(b[i]);
        sum += difference * difference;
    }
    return 0.5 * sum / static_cast<double>(a.size());
}

double expectedDifference(std::span<const float> a1, std::span<const float> a2, std::span<const float> b1, std::span<const float> b2) {
    double product = 0;
    double power = 0;
    for (std::size_t i = 0; i < a1.size(); ++i) {
        const double p1 = static_cast<double>(a1[i]);
        const double p2 = static_cast<double>(a2[i]);
        const double q1 = static_cast<double>(b1[i]);
        const double q2 = static_cast<double>(b2[i]);
        product += (p1 - q1) * (p2 - q2);
        power += 0.25 * (p1 + q1) * (p2 + q2);
    }
    return std::copysign(std::sqrt(std::fabs(product) / power), product);
}

double samplesToReach(std::span<const ErrorPoint> curve, double error) {
    std::size_t i = 1;
    while (i + 1 < curve.size() && curve[i].error > error) ++i;
    const ErrorPoint &a = curve[i - 1];
    const ErrorPoint &b = curve[i];
    const double slope = std::log(b.samples / a.samples) / std::log(b.error / a.error);
    return a.samples * std::exp(slope * std::log(error / a.error));
}

} // namespace taut::chart
