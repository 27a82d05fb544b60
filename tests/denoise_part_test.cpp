// What a picture holds is what denoising takes: the part that is noisy is filtered as if it were the picture, the rest is as it was.

#include "catch.h"

#include "taut/render/denoise.h"
#include "taut/render/denoise_features.h"
#include "taut/render/denoise_pixels.h"

#include <cmath>
#include <random>

using namespace taut;

namespace {

constexpr int kWidth = 150, kHeight = 110, kSpp = 8, kRadius = 17;

/// A noisy disc of light 1 about (x0, y0) before even light; samples follow from the place in the disc.
Film discFilm(int x0, int y0, float background, float noise = 0.7F) {
    const Window window{3, 5, 3 + kWidth, 5 + kHeight};
    Film film(window, {}, {}, denoiseBlockOf(kSpp, true));
    for (int y = window.y0; y < window.y1; ++y)
        for (int x = window.x0; x < window.x1; ++x) {
            const bool isDisc = std::hypot(x - x0, y - y0) <= kRadius;
            std::mt19937 random(static_cast<unsigned>(1000 + x - x0 + 1000 * (1000 + y - y0)));
            std::uniform_real_distribution<float> uniform(-noise, noise);
            FeatureMeans means;
            for (int s = 0; s < kSpp; ++s) {
                const Vec3 radiance(isDisc ? 1 + uniform(random) : background);
                film.add(x, y, radiance, isDisc || background > 0 ? 1.0F : 0.0F, nullptr);
                film.denoiseSums()->add(x, y, static_cast<std::uint32_t>(s), radiance, isDisc);
            }
            std::array<float, kDenoiseFeatures> features{};
            features[kNormal + 2] = 1;
            if (!isDisc)
                means.addNothing(background > 0, false);
            else if (means.addHit(0, 1))
                means.tell(features.data(), true);
            film.denoiseSums()->tell(x, y, means.rounded(false));
        }
    return film;
}

std::size_t placeOf(int x, int y) {
    return static_cast<std::size_t>((y - 5) * kWidth + x - 3);
}

} // namespace

TEST_CASE("denoise: the noisy part is found, with a margin, and no more", "[denoise]") {
    for (const float background : {0.0F, 0.3F}) { // squares of 0.3 are rounded: that is no noise
        const Window part = noisyPart(discFilm(60, 50, background));
        CHECK(part.x0 <= 60 - kRadius);
        CHECK(part.x0 > 60 - kRadius - 12);
        CHECK(part.x1 > 60 + kRadius);
        CHECK(part.x1 <= 61 + kRadius + 12);
        CHECK(part.y0 <= 50 - kRadius);
        CHECK(part.y1 > 50 + kRadius);
        CHECK(part.y1 <= 51 + kRadius + 12);
    }
    CHECK(noisyPart(discFilm(60, 50, 0.3F, 0.0F)).empty());
    // At the picture's border it ends there.
    const Window corner = noisyPart(discFilm(5, 7, 0));
    CHECK(corner.x0 == 3);
    CHECK(corner.y0 == 5);
}

TEST_CASE("denoise: around a figure the picture is exact, and the figure is filtered alike wherever it stands", "[denoise]") {
    for (const float background : {0.0F, 0.3F}) {
        const Film film = discFilm(60, 50, background);
        const Denoised seen = denoise(film);
        const Denoised moved = denoise(discFilm(88, 64, background));
        bool isExact = true;
        bool isAlike = true;
        const std::vector<std::array<float, 4>> colours = film.colours();
        double noisy = 0;
        double left = 0;
        for (int y = 5; y < 5 + kHeight; ++y)
            for (int x = 3; x < 3 + kWidth; ++x) {
                const std::size_t i = placeOf(x, y);
                const double away = std::hypot(x - 60, y - 50);
                if (std::max(std::abs(x - 60), std::abs(y - 50)) > kRadius + 12)
                    isExact &= seen.rgb[3 * i] == background && seen.error[i] == 0;
                if (away > kRadius) continue;
                noisy += std::pow(static_cast<double>(colours[i][0]) - 1, 2);
                left += std::pow(static_cast<double>(seen.rgb[3 * i]) - 1, 2);
                for (std::size_t c = 0; c < 3; ++c) isAlike &= seen.rgb[3 * i + c] == moved.rgb[3 * placeOf(x + 28, y + 14) + c];
            }
        CHECK(isExact);
        CHECK(isAlike);
        CHECK(left < noisy / 8);
    }
    // A picture without noise is what it was.
    const Film still = discFilm(60, 50, 0.3F, 0.0F);
    const Denoised same = denoise(still);
    const std::vector<std::array<float, 4>> colours = still.colours();
    bool isSame = true;
    for (int y = 5; y < 5 + kHeight; ++y)
        for (int x = 3; x < 3 + kWidth; ++x)
            isSame &= same.rgb[3 * placeOf(x, y)] == colours[placeOf(x, y)][0] && same.error[placeOf(x, y)] == 0;
    CHECK(isSame);
}
