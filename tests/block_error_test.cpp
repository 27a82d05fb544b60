/// What a block's sums say of its noise, and how well.

#include "catch.h"

#include "taut/render/picture_noise.h"

#include <random>

using namespace taut;

TEST_CASE("picture noise: what is usual has its number of samples, and steps between", "[picture-noise]") {
    const std::pair<int, double> usual[] = {{1, 0.70},  {2, 0.70},  {3, 0.68},  {4, 0.66},   {5, 0.66},   {6, 0.63},   {16, 0.60},
                                            {64, 0.80}, {95, 0.80}, {96, 0.68}, {384, 0.80}, {512, 0.90}, {768, 0.90}, {1 << 16, 0.90}};
    for (const auto &[samples, factor] : usual) {
        INFO(samples);
        CHECK(usualFactor(samples) == factor);
    }
}

TEST_CASE("picture noise: a block says how well it is known", "[picture-noise]") {
    // Of independent samples: what many blocks tell of their variance has the variance that they say it has.
    const Window window{0, 0, 4, 4};
    constexpr double kDeviation = 0.5;
    constexpr int kBlocks = 4000;
    std::mt19937 engine(1);
    std::normal_distribution<double> normal(1, kDeviation);
    double mean = 0;
    double square = 0;
    double spread = 0;
    for (int block = 0; block < kBlocks; ++block) {
        Film film(window, {});
        ColourSums sums;
        const auto add = [&](std::vector<double> &into) {
            for (int y = 0; y < window.y1; ++y)
                for (int x = 0; x < window.x1; ++x)
                    for (int i = 0; i < 8; ++i) film.add(x, y, Vec3(static_cast<float>(normal(engine))), 1, nullptr);
            ColourSums::fill(film, window, into);
        };
        add(sums.half);
        add(sums.all);
        const BlockError found = blockErrorOf(window, window, sums, 8, 16);
        mean += found.variance / kBlocks;
        square += sqr(found.variance) / kBlocks;
        spread += found.spread / kBlocks;
    }
    CHECK(mean == Approx(sqr(kDeviation) / 16).epsilon(0.03));
    CHECK(spread == Approx(square - sqr(mean)).epsilon(0.1));
    CHECK(spread == Approx(2 * sqr(mean) / 16).epsilon(0.1)); // chi-squared of one degree a pixel, whose colours are one
}
