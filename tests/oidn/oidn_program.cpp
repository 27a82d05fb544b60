// denoise_oidn.cpp against the stand-in: what the library is handed, what becomes of what it gives back, what its errors become. It shows
// nothing of how well the library denoises.

#include "../catch.h"

#include "OpenImageDenoise/oidn.hpp"

#include "taut/base/error.h"
#include "taut/render/denoise.h"
#include "taut/render/denoise_oidn.h"

#include <cmath>
#include <random>

using namespace taut;

namespace {

constexpr int kWidth = 40, kHeight = 30, kSpp = 8;

/// Even, noisy light on a plate whose colour is beyond 1 at its right.
Film plateFilm() {
    const Window window{2, 3, 2 + kWidth, 3 + kHeight};
    Film film(window, {}, {}, denoiseBlockOf(kSpp, true));
    std::mt19937 random(7);
    std::uniform_real_distribution<float> uniform(-0.8F, 0.8F);
    for (int y = window.y0; y < window.y1; ++y)
        for (int x = window.x0; x < window.x1; ++x) {
            for (int s = 0; s < kSpp; ++s) {
                const Vec3 radiance = Vec3(3, 2, 1) * (1 + uniform(random));
                film.add(x, y, radiance, 1, nullptr);
                film.denoiseSums()->add(x, y, static_cast<std::uint32_t>(s), radiance, true);
            }
            std::array<float, kDenoiseFeatures> features{};
            features[kNormal + 2] = -1;
            features[kAlbedo] = x > kWidth / 2 ? 1.5F : 0.5F;
            FeatureMeans means;
            if (means.addHit(0, 1)) means.tell(features.data(), true);
            film.denoiseSums()->tell(x, y, means.rounded(false));
        }
    return film;
}

oidn::standin::World &freshWorld() {
    oidn::standin::world() = {};
    return oidn::standin::world();
}

} // namespace

TEST_CASE("oidn: both halves go through it, with albedo and normal, as its API wants them", "[oidn]") {
    const auto &world = freshWorld();
    const Film film = plateFilm();
    const DenoisePixels pixels = denoisePixelsOf(film, film.window());
    const Regressed out = openImageDenoise(pixels);
    REQUIRE(world.executions.size() == 2);
    for (std::size_t half = 0; half < 2; ++half) {
        const oidn::standin::Execution &e = world.executions[half];
        CHECK(e.width == kWidth);
        CHECK(e.height == kHeight);
        CHECK(e.hdr);
        CHECK(e.cleanAux); // probes have no noise here
        CHECK_FALSE(e.setAffinity);
        REQUIRE(e.images.size() == 3);
        bool same = true;
        bool filtered = true;
        for (std::size_t i = 0; i < pixels.count(); ++i)
            for (std::size_t c = 0; c < 3; ++c) {
                same &= e.images.at("color")[3 * i + c] == pixels.half[half][c][i];
                same &= e.images.at("normal")[3 * i + c] == pixels.normal[c][i];
                same &= e.images.at("albedo")[3 * i + c] == std::min(1.0F, pixels.albedo[c][i]);
                double sum = 0, count = 0; // the stand-in's mean of 3 x 3
                const int x = static_cast<int>(i) % kWidth, y = static_cast<int>(i) / kWidth;
                for (int v = std::max(0, y - 1); v <= std::min(kHeight - 1, y + 1); ++v)
                    for (int u = std::max(0, x - 1); u <= std::min(kWidth - 1, x + 1); ++u, ++count)
                        sum += static_cast<double>(pixels.half[half][c][static_cast<std::size_t>(v * kWidth + u)]);
                filtered &= std::fabs(static_cast<double>(out.half[half][c][i]) - sum / count) < 1e-5 * sum / count;
            }
        CHECK(same);
        CHECK(filtered);
    }
    CHECK(std::all_of(out.known.begin(), out.known.end(), [](float k) { return k == 1; }));
}

TEST_CASE("oidn: a picture denoised by it is nearer to the truth, and says by how much", "[oidn]") {
    const auto &world = freshWorld();
    const Film film = plateFilm();
    const Denoised denoised = denoise(film);
    CHECK(world.executions.size() == 2);
    REQUIRE(denoised.rgb.size() == 3 * kWidth * kHeight);
    const std::vector<std::array<float, 4>> colours = film.colours();
    double noisy = 0, left = 0, told = 0;
    for (int y = 0; y < kHeight; ++y)
        for (int x = 0; x < kWidth; ++x) {
            const auto i = static_cast<std::size_t>(y * kWidth + x);
            for (std::size_t c = 0; c < 3; ++c) {
                const double truth = 3 - static_cast<double>(c);
                noisy += std::pow(static_cast<double>(colours[i][c]) - truth, 2);
                left += std::pow(static_cast<double>(denoised.rgb[3 * i + c]) - truth, 2);
            }
            told += 3 * std::pow(static_cast<double>(denoised.error[i]), 2);
        }
    CHECK(left < 0.3 * noisy); // a mean of nine has a ninth
    CHECK(told > 0.3 * left);
    CHECK(told < 3 * left);
}

TEST_CASE("oidn: what fails there is an error with its words", "[oidn]") {
    freshWorld().hasDevice = false;
    const Film film = plateFilm();
    try {
        denoise(film);
        FAIL("no error");
    } catch (const RunError &error) {
        CHECK(std::string(error.what()) == "Open Image Denoise: unsupported device type: CPU");
    }
    freshWorld();
    DenoisePixels pixels = denoisePixelsOf(film, film.window());
    pixels.normal[1][17] = -3; // no unit vector
    CHECK_THROWS_WITH(openImageDenoise(pixels), "Open Image Denoise: normal beyond [-1, 1]");
    CHECK(denoise(film).rgb.size() == 3 * kWidth * kHeight); // and the next is one of its own
}
