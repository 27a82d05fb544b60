/// Pixels that share their samples: the same filter as without, the same picture in the mean, less than half of the variance.

#include "catch.h"
#include "render_fixtures.h"

#include "taut/render/pixel_filter.h"
#include "taut/render/shared_sums.h"

#include <tbb/global_control.h>

#include <functional>
#include <random>
#include <sstream>

using namespace taut;
using namespace taut::test;

namespace {

/// Blackman-Harris of radius 1.5 over its integral, in double (Harris 1978).
double filterAt(double x) {
    if (std::fabs(x) > 1.5) return 0;
    const double w = kTwoPi * (0.5 + x / 3);
    return (0.35875 - 0.48829 * std::cos(w) + 0.14128 * std::cos(2 * w) - 0.01168 * std::cos(3 * w)) / (3 * 0.35875);
}

/// Mean over a pixel's samples of what `light` at their place in the frame gives to the pixel at a distance of k pixels, along a row.
double given(const Window &window, int x, int k, const std::function<double(double)> &light) {
    constexpr int kSteps = 1 << 14;
    double sum = 0;
    for (int i = 0; i < kSteps; ++i) {
        const SharedSample sample = sharedSample(window, x, 3, {(static_cast<float>(i) + 0.5F) / kSteps, 0.5F});
        sum += static_cast<double>(sample.across[static_cast<std::size_t>(k + 1)]) * light(x + static_cast<double>(sample.offset.x));
    }
    return sum / kSteps;
}

Scene sceneOf(int size) {
    Scene scene = smallScene(makeObject(makeSphere(48, 24, 0.7F)), ggxMaterial(0.05F, 0.3F), size);
    scene.environment = studioEnvironment();
    scene.render.boxFilter = false;
    return scene;
}

std::vector<float> picture(const RenderScene &ready, bool shares, int spp, std::uint32_t seed, const Window &window = {},
                           bool independent = false) {
    FrameOptions options;
    options.spp = spp;
    options.seed = seed;
    options.shares = shares;
    options.window = window;
    options.independent = independent;
    return renderFrame(ready, options).film.resolve(); // R G B A
}

/// Mean square difference of two pictures of which each is one of a pair, free of the noise of either.
double squaredBias(const std::array<std::vector<float>, 2> &a, const std::array<std::vector<float>, 2> &b) {
    double sum = 0;
    for (std::size_t i = 0; i < a[0].size(); ++i)
        sum +=
            (static_cast<double>(a[0][i]) - static_cast<double>(b[0][i])) * (static_cast<double>(a[1][i]) - static_cast<double>(b[1][i]));
    return sum / static_cast<double>(a[0].size());
}

double meanSquare(const std::vector<float> &a, const std::vector<float> &b) {
    double sum = 0;
    for (std::size_t i = 0; i < a.size(); ++i) sum += sqr(static_cast<double>(a[i]) - static_cast<double>(b[i]));
    return sum / static_cast<double>(a.size());
}

} // namespace

TEST_CASE("shared samples: a pixel is filtered as the window function says, at the window's edge too", "[shared-samples]") {
    const Window window{2, 0, 8, 7};
    for (const double frequency : {0.0, 0.7, 2.1}) {
        const auto light = [&](double x) { return std::cos(frequency * x + 0.4); };
        for (int x = window.x0; x < window.x1; ++x) {
            double sum = 0;
            for (int k = -1; k <= 1; ++k) // what the pixel at x - k gives
                if (x - k >= window.x0 && x - k < window.x1) sum += given(window, x - k, k, light);
            double expected = 0;
            constexpr int kSteps = 30000;
            for (int i = 0; i < kSteps; ++i) {
                const double offset = 3 * (i + 0.5) / kSteps - 1.5;
                expected += 3.0 / kSteps * filterAt(offset) * light(x + offset);
            }
            INFO("pixel " << x << ", frequency " << frequency);
            CHECK(sum == Approx(expected).margin(2e-5));
        }
    }
    // One pixel alone has all of its filter to itself, and none gives to pixels that are not there.
    const Window one{4, 3, 5, 4};
    CHECK(given(one, 4, 0, [](double) { return 1.0; }) == Approx(1).margin(2e-5));
    CHECK(given(one, 4, -1, [](double) { return 1.0; }) == 0);
    CHECK(given(window, window.x1 - 1, 1, [](double) { return 1.0; }) == 0);
    // The integral of the squared filter, in both directions.
    double squared = 0;
    for (int i = 0; i < 30000; ++i) squared += 3.0 / 30000 * sqr(filterAt(3 * (i + 0.5) / 30000 - 1.5));
    CHECK(kSharedVariance == Approx(sqr(squared)).margin(1e-3));
}

TEST_CASE("shared samples: the mean is the picture without, the variance less than half", "[shared-samples]") {
    RenderScene ready(sceneOf(48), false);
    ready.setFrame(1);
    const auto pair = [&](bool shares, int spp, std::uint32_t seed, const Window &window = {}) {
        return std::array{picture(ready, shares, spp, seed, window), picture(ready, shares, spp, seed + 1, window)};
    };
    const auto apart = pair(false, 1024, 100);
    const auto shared = pair(true, 1024, 200);
    const double noise = std::sqrt(0.5 * meanSquare(apart[0], apart[1]) + 0.5 * meanSquare(shared[0], shared[1]));
    INFO("noise of both " << noise);
    CHECK(std::fabs(squaredBias(apart, shared)) < 0.1 * sqr(noise)); // 9216 values, of which few are alike
    CHECK(std::sqrt(meanSquare(apart[0], std::vector<float>(apart[0].size()))) > 20 * noise);
    // A part of it by itself, whose edges lie within the picture.
    const Window part{10, 12, 33, 31};
    const auto cropped = pair(true, 1024, 300, part);
    std::array<std::vector<float>, 2> same;
    for (std::size_t which = 0; which < 2; ++which)
        for (int y = part.y0; y < part.y1; ++y) {
            const auto *row = &apart[which][static_cast<std::size_t>((y * 48 + part.x0) * 4)];
            same[which].insert(same[which].end(), row, row + 4 * part.width());
        }
    const double noiseOfPart = std::sqrt(0.5 * meanSquare(same[0], same[1]) + 0.5 * meanSquare(cropped[0], cropped[1]));
    CHECK(std::fabs(squaredBias(same, cropped)) < 0.2 * sqr(noiseOfPart));
    // Where light is alike around, kSharedVariance; at outlines the two are less apart.
    double apartVariance = 0;
    double sharedVariance = 0;
    for (std::uint32_t seed = 0; seed < 8; seed += 2) {
        apartVariance += meanSquare(picture(ready, false, 16, seed, {}, true), picture(ready, false, 16, seed + 1, {}, true));
        sharedVariance += meanSquare(picture(ready, true, 16, seed, {}, true), picture(ready, true, 16, seed + 1, {}, true));
    }
    INFO("independent samples: " << sharedVariance / apartVariance);
    CHECK(sharedVariance < 0.55 * apartVariance);
    CHECK(sharedVariance > 0.35 * apartVariance);
    // And with points that stratify each other, too.
    CHECK(meanSquare(picture(ready, true, 16, 1), picture(ready, true, 16, 2)) <
          0.6 * meanSquare(picture(ready, false, 16, 1), picture(ready, false, 16, 2)));
}

TEST_CASE("shared samples: a pixel is the mean of what the nine around it give, by weights", "[shared-samples]") {
    const Window window{3, 5, 8, 9};
    const auto pixels = static_cast<std::size_t>(window.width() * window.height());
    SharedSums sums(window);
    std::vector<std::uint32_t> counts(pixels);
    std::vector<std::array<double, 5>> expected(pixels);
    std::mt19937 engine(4);
    std::uniform_real_distribution<float> uniform(0, 1);
    const auto indexOf = [&](int x, int y) { return static_cast<std::size_t>((y - window.y0) * window.width() + x - window.x0); };
    for (int y = window.y0; y < window.y1; ++y)
        for (int x = window.x0; x < window.x1; ++x) {
            const std::uint32_t count = engine() % 4; // some give nothing
            counts[indexOf(x, y)] = count;
            for (std::uint32_t k = 0; k < count; ++k) {
                const SharedSample sample = sharedSample(window, x, y, {uniform(engine), uniform(engine)});
                const std::array<float, 5> values{uniform(engine), uniform(engine), uniform(engine), uniform(engine), 1};
                sums.add(x, y, sample, {values[0], values[1], values[2]}, values[3]);
                for (int dy = -1; dy <= 1; ++dy)
                    for (int dx = -1; dx <= 1; ++dx) {
                        if (x + dx < window.x0 || x + dx >= window.x1 || y + dy < window.y0 || y + dy >= window.y1) continue;
                        const double weight = static_cast<double>(sample.across[static_cast<std::size_t>(dx + 1)]) *
                                              static_cast<double>(sample.down[static_cast<std::size_t>(dy + 1)]) / count;
                        for (std::size_t i = 0; i < 5; ++i) expected[indexOf(x + dx, y + dy)][i] += weight * static_cast<double>(values[i]);
                    }
            }
        }
    const std::vector<std::array<float, 4>> found = sums.resolve(counts);
    REQUIRE(found.size() == pixels);
    for (std::size_t p = 0; p < pixels; ++p)
        for (std::size_t i = 0; i < 4; ++i)
            CHECK(static_cast<double>(found[p][i]) ==
                  Approx(expected[p][4] > 0 ? expected[p][i] / expected[p][4] : 0).epsilon(1e-5).margin(1e-6));
}

TEST_CASE("shared samples: even light is even from the first sample on, where there is nothing it is nothing", "[shared-samples]") {
    Scene scene = sceneOf(20);
    scene.objects.clear();
    scene.lights.clear();
    scene.environment = constantEnvironment(Vec3(0.25F, 0.5F, 1));
    RenderScene ready(scene, false);
    ready.setFrame(1);
    const std::vector<float> values = picture(ready, true, 1, 5);
    for (std::size_t i = 0; i < values.size(); i += 4) {
        CHECK(values[i] == Approx(0.25).epsilon(1e-6));
        CHECK(values[i + 2] == Approx(1).epsilon(1e-6));
    }
    Film film(Window{0, 0, 3, 3}, {}, {}, 0, true);
    CHECK(film.resolve() == std::vector<float>(36, 0.0F));
}

TEST_CASE("shared samples: the same bits for any number of threads; saved and gone on with; not merged", "[shared-samples]") {
    RenderScene ready(sceneOf(40), false);
    ready.setFrame(1);
    FrameOptions options;
    options.spp = 12;
    options.shares = true;
    const auto onThreads = [&](std::size_t threads) {
        const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
        return renderFrame(ready, options).film;
    };
    const Film whole = onThreads(2);
    CHECK(onThreads(1) == whole);
    std::stringstream saved;
    {
        FrameRender frame(ready, options);
        CHECK(frame.advance({5, 0}) == FrameState::Going);
        CHECK(frame.film() == frame.filmAtRest());
        frame.save(saved);
    }
    const std::string bytes = saved.str();
    FrameRender other(ready, options);
    other.restore(saved);
    CHECK(other.advance() == FrameState::Done);
    CHECK(std::move(other).takeFilm() == whole);
    for (const std::size_t cut : {std::size_t{1}, std::size_t{4000}}) {
        std::istringstream part(bytes.substr(0, bytes.size() - cut));
        CHECK_THROWS_WITH(FrameRender(ready, options).restore(part), Catch::Contains("end early"));
    }
    FrameOptions apart = options;
    apart.shares = false;
    std::istringstream again(bytes);
    CHECK_THROWS_WITH(FrameRender(ready, apart).restore(again), Catch::Contains("share"));
    Film film = whole;
    CHECK_THROWS_WITH(film.merge(whole), Catch::Contains("share"));
    // What has a value of its own in every pixel is not shared.
    FrameOptions refused = options;
    refused.firstSample = 4;
    CHECK_THROWS_AS(FrameRender(ready, refused), InputError);
    refused = options;
    refused.aovs = aovsNamed(std::vector<std::string_view>{"depth"}, "test");
    CHECK_FALSE(mayShare(refused, ready.scene().render));
    CHECK_THROWS_AS(FrameRender(ready, refused), InputError);
}
