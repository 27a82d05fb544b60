/// What the benchmark makes of errors, against closed forms.

#include "catch.h"

#include "study/measures/image_error.h"

#include <cmath>
#include <random>

using namespace taut::chart;

namespace {

/// `count` values about `mean(i)` with normal noise.
template <class Mean> std::vector<float> noisy(std::size_t count, unsigned seed, double deviation, const Mean &mean) {
    std::mt19937 engine(seed);
    std::normal_distribution<double> noise(0, deviation);
    std::vector<float> values;
    for (std::size_t i = 0; i < count; ++i) values.push_back(static_cast<float>(mean(i) + noise(engine)));
    return values;
}

} // namespace

TEST_CASE("equal error: the error of two images is the variance of one", "[bench]") {
    const auto mean = [](std::size_t i) { return static_cast<double>(i % 7); };
    const auto a = noisy(200000, 1, 0.3, mean);
    const auto b = noisy(200000, 2, 0.3, mean);
    CHECK(errorOfTwo(a, b) == Approx(0.09).epsilon(0.02));
    CHECK(errorOfTwo(a, a) == 0);
}

TEST_CASE("equal error: a difference of means is found beneath noise three times as large", "[bench]") {
    const auto ours = [](std::size_t) { return 1.0; };
    const auto theirs = [](std::size_t i) { return i % 2 == 0 ? 1.1 : 0.9; };
    const auto of = [&](unsigned seed, const auto &mean) { return noisy(400000, seed, 0.3, mean); };
    CHECK(expectedDifference(of(1, ours), of(2, ours), of(3, theirs), of(4, theirs)) == Approx(0.1).epsilon(0.03));
    CHECK(std::fabs(expectedDifference(of(1, ours), of(2, ours), of(3, ours), of(4, ours))) < 0.03);
}

TEST_CASE("equal error: samples to reach an error on power laws", "[bench]") {
    const auto law = [](double samples) { return ErrorPoint{samples, 2 / samples}; };
    const std::vector<ErrorPoint> curve{law(4), law(16), law(64)};
    for (const double samples : {4.0, 9.0, 16.0, 50.0, 64.0, 1000.0, 1.0}) CHECK(samplesToReach(curve, 2 / samples) == Approx(samples));
    // The slope changes at 16: 1 before, 3/2 after.
    const std::vector<ErrorPoint> bent{{4, 1}, {16, 0.25}, {64, 0.25 / 8}};
    CHECK(samplesToReach(bent, 0.5) == Approx(8));
    CHECK(samplesToReach(bent, 0.25 / std::pow(2, 1.5)) == Approx(32));
}
