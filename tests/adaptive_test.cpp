/// Adaptive sampling: the ring that keeps it unbiased, its mean against that of a fixed number of samples, and what it reaches.

#include "catch.h"
#include "cli_fixtures.h"
#include "render_fixtures.h"

#include "taut/render/adaptive.h"

#include <tbb/global_control.h>

#include <functional>
#include <random>
#include <set>

using namespace taut;
using namespace taut::test;

namespace {

/// Mean and standard error of the mean.
struct Estimate {
    double mean = 0, error = 0;
};
Estimate estimate(const std::vector<double> &values) {
    const auto count = static_cast<double>(values.size());
    double sum = 0;
    for (const double v : values) sum += v;
    double squares = 0;
    for (const double v : values) squares += sqr(v - sum / count);
    return {sum / count, std::sqrt(squares / (count * (count - 1)))};
}

double meanOf(const std::vector<float> &values) {
    double sum = 0;
    for (const float v : values) sum += static_cast<double>(v);
    return sum / static_cast<double>(values.size());
}

constexpr double kRare = 0.004; ///< of the samples below are bright; their mean is 1

/// Adds samples of a rare bright event to a film.
class RareLight {
  public:
    RareLight(Film &film, unsigned seed) : film_(film), engine_(seed) {}
    void operator()(const Window &window, int first, int last) {
        for (int y = window.y0; y < window.y1; ++y)
            for (int x = window.x0; x < window.x1; ++x)
                for (int i = first; i < last; ++i)
                    film_.add(x, y, Vec3(uniform_(engine_) < kRare ? static_cast<float>(1 / kRare) : 0.0F), 1, nullptr);
    }

  private:
    Film &film_;
    std::mt19937 engine_;
    std::uniform_real_distribution<double> uniform_;
};

constexpr int kMost = 1024;
const Window kWindow{3, 2, 35, 33}; // blocks are cut at its edges

/// Image mean of one render by the ring's rule.
double guidedMean(double noise, unsigned seed, double &samples) {
    Film film(kWindow, {});
    RareLight light(film, seed);
    BlockScratch scratch;
    AdaptiveBlocks blocks(kWindow, noise, kMost);
    while (!blocks.active().empty()) {
        for (const Index block : blocks.active()) samplePass(blocks, block, film, scratch, std::ref(light));
        blocks.decide();
    }
    samples += film.meanSamples();
    std::vector<float> red;
    const std::vector<float> values = film.resolve();
    for (std::size_t i = 0; i < values.size(); i += 4) red.push_back(values[i]);
    return meanOf(red);
}

/// Mean of a block that stops by its own noise.
double selfishMean(double noise, unsigned seed) {
    const Window block{0, 0, 4, 4};
    Film film(block, {});
    RareLight light(film, seed);
    BlockScratch scratch;
    int samples = AdaptiveBlocks::kPilot;
    light(block, 0, samples / 2);
    for (int before = samples / 2;; before = samples, samples *= 2) {
        BlockScratch::fill(film, block, scratch.before);
        light(block, before, samples);
        BlockScratch::fill(film, block, scratch.after);
        const BlockNoise found = noiseOf(scratch.before, before, scratch.after, samples);
        if (samples >= kMost || found.variance <= sqr(noise * std::max(found.luminance, 0.1))) return found.luminance;
    }
}

Scene noisyScene() {
    Scene scene = smallScene(makeObject(makeSphere(48, 24, 0.7F)), ggxMaterial(0.05F, 0.3F), 36);
    scene.environment = studioEnvironment();
    return scene;
}

FrameResult renderWith(const Scene &scene, std::optional<double> noise, int spp, std::uint32_t seed) {
    RenderScene ready(scene, false);
    StageTimes times;
    ready.setFrame(1, times);
    FrameOptions options;
    options.noise = noise;
    options.spp = spp;
    options.seed = seed;
    return renderFrame(ready, options);
}

} // namespace

TEST_CASE("adaptive: each colour's guide has the next colour, on a ring of nine", "[adaptive]") {
    std::set<int> colours;
    for (int row = 0; row < 6; ++row)
        for (int column = 0; column < 6; ++column) {
            const int colour = BlockGrid::colourAt(column, row);
            const auto [dx, dy] = BlockGrid::towardsGuide(column, row);
            colours.insert(colour);
            CHECK(std::abs(dx) + std::abs(dy) == 1);
            for (const int step : {1, -2})
                CHECK(BlockGrid::colourAt(column + step * dx, row + step * dy) == (colour + 1) % BlockGrid::kColours);
        }
    CHECK(colours.size() == BlockGrid::kColours);
}

TEST_CASE("adaptive: followers of a colour are those around it whose colours are next on the ring", "[adaptive]") {
    for (int row = 3; row < 6; ++row)
        for (int column = 3; column < 6; ++column)
            for (const int reach : {1, 2, 6, 8}) {
                const int colour = BlockGrid::colourAt(column, row);
                const std::vector<BlockGrid::Neighbour> ways = BlockGrid::followers(colour, reach, 4);
                CHECK(ways.size() == static_cast<std::size_t>(9 * reach)); // 9 x 9 blocks hold each colour nine times
                for (const auto &[dx, dy] : ways) {
                    const int steps = (BlockGrid::colourAt(column + dx, row + dy) - colour + BlockGrid::kColours) % BlockGrid::kColours;
                    CHECK((steps >= 1 && steps <= reach));
                }
            }
}

TEST_CASE("adaptive: the noise of a block is the variance of its pixels' means", "[adaptive]") {
    std::mt19937 engine(3);
    std::normal_distribution<double> normal(2, 0.5);
    std::vector<double> before(4000, 0.0);
    for (double &sum : before)
        for (int i = 0; i < 4; ++i) sum += normal(engine);
    std::vector<double> after = before;
    for (double &sum : after)
        for (int i = 0; i < 12; ++i) sum += normal(engine);
    const BlockNoise noise = noiseOf(before, 4, after, 16);
    CHECK(noise.variance == Approx(0.25 / 16).epsilon(0.1));
    CHECK(noise.luminance == Approx(2).epsilon(0.01));
    CHECK(noise.samples == 16);
}

TEST_CASE("adaptive: rare light keeps its mean, which a rule that looks at its own samples loses", "[adaptive]") {
    constexpr double kNoise = 0.6;
    std::vector<double> guided;
    std::vector<double> selfish;
    double samples = 0;
    for (unsigned seed = 1; seed <= 300; ++seed) guided.push_back(guidedMean(kNoise, seed, samples));
    for (unsigned seed = 1; seed <= 4000; ++seed) selfish.push_back(selfishMean(kNoise, seed));
    const Estimate ours = estimate(guided);
    const Estimate theirs = estimate(selfish);
    INFO("guided " << ours.mean << " +- " << ours.error << ", selfish " << theirs.mean << " +- " << theirs.error);
    CHECK(std::fabs(ours.mean - 1) < 4 * ours.error);
    CHECK(ours.error < 0.01);
    CHECK(std::fabs(theirs.mean - 1) > 20 * theirs.error);
    samples /= 300;
    CHECK(samples > 2 * AdaptiveBlocks::kPilot); // stopping did happen, and not at once
    CHECK(samples < 0.8 * kMost);
}

TEST_CASE("adaptive: the mean over seeds is that of a fixed number of samples, and the noise what was asked for", "[adaptive]") {
    const Scene scene = noisyScene();
    constexpr double kNoise = 0.08;
    constexpr int kSeeds = 24;
    std::vector<double> adaptive;
    std::vector<double> fixed;
    std::vector<double> sums;
    std::vector<double> squares;
    double samples = 0;
    for (std::uint32_t seed = 1; seed <= kSeeds; ++seed) {
        const FrameResult result = renderWith(scene, kNoise, 1024, seed);
        const std::vector<float> values = result.film.resolve();
        sums.resize(values.size());
        squares.resize(values.size());
        for (std::size_t i = 0; i < values.size(); ++i) {
            sums[i] += static_cast<double>(values[i]);
            squares[i] += sqr(static_cast<double>(values[i]));
        }
        adaptive.push_back(meanOf(values));
        fixed.push_back(meanOf(renderWith(scene, std::nullopt, 64, 1000 + seed).film.resolve()));
        samples += result.film.meanSamples() / kSeeds;
    }
    const Estimate a = estimate(adaptive);
    const Estimate f = estimate(fixed);
    INFO("adaptive " << a.mean << " +- " << a.error << ", fixed " << f.mean << " +- " << f.error << ", samples " << samples);
    CHECK(std::fabs(a.mean - f.mean) < 4 * std::hypot(a.error, f.error));
    CHECK(a.error < 2e-3 * a.mean);
    CHECK(samples > 20);
    CHECK(samples < 400);
    // Green of every pixel: standard deviation over seeds, relative to the pixel.
    double relative = 0;
    for (std::size_t i = 1; i < sums.size(); i += 4) {
        const double mean = sums[i] / kSeeds;
        relative += (squares[i] / kSeeds - sqr(mean)) / std::max(sqr(mean), 1e-12);
    }
    relative = std::sqrt(relative * 4 / static_cast<double>(sums.size()));
    INFO("relative noise " << relative);
    CHECK(relative < 1.1 * kNoise);
    CHECK(relative > 0.3 * kNoise);
}

TEST_CASE("adaptive: the same bits for any number of threads, and those of a plain render where all go to the end", "[adaptive]") {
    const Scene scene = noisyScene();
    const auto onThreads = [&](std::size_t threads) {
        const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
        return renderWith(scene, 0.1, 256, 5).film.resolve();
    };
    CHECK(onThreads(1) == onThreads(2));
    for (const int spp : {1, 7, 40}) {
        INFO(spp);
        CHECK(renderWith(scene, 1e-9, spp, 5).film.resolve() == renderWith(scene, std::nullopt, spp, 5).film.resolve());
    }
}

TEST_CASE("adaptive: the command takes a noise level", "[adaptive][cli]") {
    const Workplace place("adaptive");
    requireSuccess(runTaut({"render", place.scene, "-o", place.path("a.exr"), "--noise", "0.05", "--spp", "200", "-q"}));
    const double mean = std::stod(metadata(place.path("a.exr"), "taut:meanSpp"));
    CHECK(mean >= 16);
    CHECK(mean < 200);
    CHECK(std::stod(metadata(place.path("a.exr"), "taut:spp")) >= mean);
    for (const char *value : {"0", "-0.1", "1", "nan", "inf", "0.01x", "fine", ""}) {
        INFO(value);
        checkUsageError(runTaut({"render", place.scene, "-o", place.path("b.exr"), "--noise", value}), "--noise");
        CHECK(!fs::exists(place.path("b.exr")));
    }
}
