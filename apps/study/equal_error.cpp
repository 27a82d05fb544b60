#include "study/equal_error.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace taut::chart {

Spread spreadOf(std::vector<double> values) {
    if (values.empty()) return {};
    std::sort(values.begin(), values.end());
    const auto at = [&](double share) {
        const double place = share * static_cast<double>(values.size() - 1);
        const auto below = static_cast<std::size_t>(place);
        const std::size_t above = std::min(below + 1, values.size() - 1);
        return values[below] + (place - static_cast<double>(below)) * (values[above] - values[below]);
    };
    return {at(0.25), at(0.5), at(0.75)};
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
