/// Adaptive sampling to the noise of the whole picture: where samples go, what it says it has reached, and that it has no bias.

#include "catch.h"
#include "cli_fixtures.h"
#include "render_fixtures.h"
#include "statistics.h"

#include "taut/render/picture_noise.h"

#include <tbb/global_control.h>

#include <random>
#include <sstream>

using namespace taut;
using namespace taut::test;

namespace {

/// Independent samples of mean 1: to the left of the middle of the window with one standard deviation, to the right with another.
class TwoHalves {
  public:
    TwoHalves(const Window &window, double left, double right, unsigned seed)
        : middle_((window.x0 + window.x1) / 2), left_(left), right_(right), engine_(seed) {}

    double add(Film &film, const Window &part, int first, int last) {
        std::normal_distribution<double> normal;
        for (int y = part.y0; y < part.y1; ++y)
            for (int x = part.x0; x < part.x1; ++x)
                for (int i = first; i < last; ++i)
                    film.add(x, y, Vec3(static_cast<float>(1 + (x < middle_ ? left_ : right_) * normal(engine_))), 1, nullptr);
        return static_cast<double>(part.width()) * part.height() * (last - first);
    }

  private:
    int middle_;
    double left_, right_;
    std::mt19937 engine_;
};

struct Made {
    Film film;
    PictureNoiseReached reached;
};

template <class Light> Made make(const Window &window, double noise, int most, Light &light) {
    Made made{Film(window, {}), {}};
    AdaptivePasses passes(window, PictureGoal{noise, 4}, most, 3);
    PassScratch scratch;
    while (!passes.pieces().empty()) {
        for (const PassPiece &piece : passes.pieces())
            passes.make(piece, made.film, scratch,
                        [&](const Window &part, int first, int last) { return light.add(made.film, part, first, last); });
        const std::vector<PassPiece> controls = passes.drawControls(made.film);
        std::vector<std::vector<double>> again;
        for (const PassPiece &piece : controls) {
            Film other(piece.window, {});
            light.add(other, piece.window, 0, piece.last);
            ColourSums::fill(other, piece.window, again.emplace_back());
        }
        passes.decide(made.film, controls, again);
    }
    made.reached = *passes.reached();
    return made;
}

double samplesIn(const Film &film, const Window &part) {
    double sum = 0;
    for (int y = part.y0; y < part.y1; ++y)
        for (int x = part.x0; x < part.x1; ++x) sum += film.samplesAt(x, y);
    return sum / (part.width() * part.height());
}

/// Light of mean 1 that comes rarely: each block has its own chance, so that the variance of a sample is 1 / chance - 1.
class RareField {
  public:
    /// Chances c0 e^(-spread z) with a normal z for each 4 x 4 block, or for each square of `patch` blocks.
    RareField(const Window &window, double chance, double spread, int patch, unsigned seed) : engine_(seed), patch_(4 * patch) {
        std::mt19937 field(1000 + seed);
        std::normal_distribution<double> normal;
        columns_ = window.x1 / patch_ + 1;
        for (int i = 0; i < columns_ * (window.y1 / patch_ + 1); ++i)
            chances_.push_back(std::clamp(chance * std::exp(-spread * normal(field)), 1e-3, 0.9));
    }
    [[nodiscard]] double chanceAt(int x, int y) const { return chances_[static_cast<std::size_t>(y / patch_ * columns_ + x / patch_)]; }
    [[nodiscard]] double varianceAt(int x, int y) const { return 1 / chanceAt(x, y) - 1; }
    double add(Film &film, const Window &part, int first, int last) {
        std::uniform_real_distribution<double> uniform;
        for (int y = part.y0; y < part.y1; ++y)
            for (int x = part.x0; x < part.x1; ++x)
                for (int i = first; i < last; ++i)
                    film.add(x, y, Vec3(uniform(engine_) < chanceAt(x, y) ? static_cast<float>(1 / chanceAt(x, y)) : 0.0F), 1, nullptr);
        return static_cast<double>(part.width()) * part.height() * (last - first);
    }

  private:
    std::mt19937 engine_;
    int patch_, columns_;
    std::vector<double> chances_;
};

/// The variance of a picture over that of one whose pixels all have as many samples, as many in all: known from the numbers alone.
double overEven(const Film &film, const Window &window, const RareField &light) {
    double variance = 0;
    double ofOne = 0;
    for (int y = window.y0; y < window.y1; ++y)
        for (int x = window.x0; x < window.x1; ++x) {
            variance += light.varianceAt(x, y) / film.samplesAt(x, y);
            ofOne += light.varianceAt(x, y);
        }
    return variance * film.meanSamples() / ofOne;
}

Scene noisyScene(int size) {
    Scene scene = smallScene(makeObject(makeSphere(48, 24, 0.7F)), ggxMaterial(0.05F, 0.3F), size);
    scene.environment = studioEnvironment();
    return scene;
}

FrameOptions toNoise(double noise, std::uint32_t seed, bool shares = false) {
    FrameOptions options;
    options.shares = shares;
    options.picture = PictureGoal{noise, 4};
    options.spp = 4096;
    options.seed = seed;
    return options;
}

/// Relative RMS difference of two films, over the square root of 2: the noise of either.
double noiseOfTwo(const Film &a, const Film &b) {
    const std::vector<float> first = coloursOf(a.resolve());
    const std::vector<float> second = coloursOf(b.resolve());
    double difference = 0;
    double square = 0;
    for (std::size_t i = 0; i < first.size(); ++i) {
        difference += 0.5 * sqr(static_cast<double>(first[i]) - static_cast<double>(second[i]));
        square += static_cast<double>(first[i]) * static_cast<double>(second[i]);
    }
    return std::sqrt(difference / square);
}

} // namespace

TEST_CASE("picture noise: numbers of samples, and the exponent of points that stratify each other", "[picture-noise]") {
    std::vector<int> counts{1};
    while (counts.back() < 64) counts.push_back(nextSampleCount(counts.back()));
    CHECK(counts == std::vector<int>{1, 2, 3, 4, 6, 8, 12, 16, 24, 32, 48, 64});
    CHECK(nextSampleCount(5) == 6);
    CHECK(nextSampleCount(7) == 8);
    // Variance n^-p: halves of 2n points that are independent of one another would have n^-p / 2 together; what they tell is that
    // plus minus the covariance, V(2n) = V(n) - D / 4.
    for (const double p : {1.0, 1.25, 1.5, 2.0}) {
        const double n = 32;
        const double told = std::pow(n, -p) - std::pow(2 * n, -p); // D / 4
        CHECK(exponentOf(std::pow(2 * n, -p) / told) == Approx(p));
    }
}

TEST_CASE("picture noise: independent samples go where they are needed, and what is told is what is there", "[picture-noise]") {
    const Window window{3, 2, 131, 98};
    constexpr double kGoal = 0.02;
    constexpr double kLeft = 0.1;
    constexpr double kRight = 0.9;
    std::vector<double> errors;
    for (unsigned seed = 1; seed <= 12; ++seed) {
        TwoHalves light(window, kLeft, kRight, seed);
        const Made made = make(window, kGoal, 1 << 15, light);
        double variance = 0; // of the means, known from the numbers of samples alone
        for (int y = window.y0; y < window.y1; ++y)
            for (int x = window.x0; x < window.x1; ++x)
                variance += sqr(x < (window.x0 + window.x1) / 2 ? kLeft : kRight) / made.film.samplesAt(x, y);
        const double error = std::sqrt(variance / (window.width() * window.height()));
        INFO("seed " << seed << ": true " << error << ", told " << made.reached.error << " +- " << made.reached.spread);
        CHECK(error < 1.12 * kGoal); // the standard error of what is told is 5 %, and kept in reserve
        CHECK(error > 0.7 * kGoal);
        CHECK(std::fabs(made.reached.error - error) < 4 * made.reached.spread + 0.01 * error);
        CHECK(made.reached.controls > 10);
        errors.push_back(error);
        // Neyman: in proportion to the standard deviations, up to the steps of the numbers.
        const double left = samplesIn(made.film, {window.x0, window.y0, window.x0 + 48, window.y1});
        const double right = samplesIn(made.film, {window.x1 - 48, window.y0, window.x1, window.y1});
        CHECK(right / left > 5);
        CHECK(right / left < 16);
        // As many samples in every pixel would have to be more.
        CHECK(made.film.meanSamples() < 0.8 * 0.5 * (sqr(kLeft) + sqr(kRight)) / sqr(error));
    }
    CHECK(std::count_if(errors.begin(), errors.end(), [](double error) { return error <= kGoal; }) >= 10);
}

TEST_CASE("picture noise: rare light keeps its mean", "[picture-noise]") {
    struct RareLight {
        std::mt19937 engine;
        double add(Film &film, const Window &part, int first, int last) {
            constexpr double kRare = 0.02;
            std::uniform_real_distribution<double> uniform;
            for (int y = part.y0; y < part.y1; ++y)
                for (int x = part.x0; x < part.x1; ++x)
                    for (int i = first; i < last; ++i)
                        film.add(x, y, Vec3(uniform(engine) < kRare ? static_cast<float>(1 / kRare) : 0.0F), 1, nullptr);
            return 1;
        }
    };
    const Window window{0, 0, 64, 48};
    std::vector<double> means;
    double samples = 0;
    for (unsigned seed = 1; seed <= 200; ++seed) {
        RareLight light{std::mt19937(seed)};
        const Made made = make(window, 0.8, 4096, light);
        double mean = 0;
        const std::vector<float> values = made.film.resolve();
        for (std::size_t i = 0; i < values.size(); i += 4) mean += static_cast<double>(values[i]) / (window.width() * window.height());
        means.push_back(mean);
        samples += made.film.meanSamples() / 200;
    }
    double mean = 0;
    double square = 0;
    for (const double m : means) mean += m / 200;
    for (const double m : means) square += sqr(m - mean) / (200 * 199);
    INFO(mean << " +- " << std::sqrt(square) << ", " << samples << " samples");
    CHECK(std::fabs(mean - 1) < 4 * std::sqrt(square));
    CHECK(std::sqrt(square) < 0.01);
    CHECK(samples > 40);
}

TEST_CASE("picture noise: never worse than as many samples everywhere, however rare the light", "[picture-noise]") {
    const Window window{0, 0, 96, 64};
    struct Field {
        const char *name;
        double chance, spread;
        int patch;
        double atMost; ///< variance over that of even samples
    };
    // Where blocks differ from all their neighbours nobody can know; where they are alike there is nothing to gain. Half of the pixels with
    // half as many samples again as the others, since only some numbers are good: (1 + 1.5) / 2 (1 + 1 / 1.5) / 2 = 1.042 of the variance.
    for (const Field &field : {Field{"the same everywhere", 0.02, 0, 1, 1.042},
                               {"very rare everywhere", 0.004, 0, 1, 1.05},
                               {"each block by itself", 0.05, 1, 1, 1.05},
                               {"in patches", 0.05, 1.5, 6, 0.85}}) {
        double mean = 0;
        for (unsigned seed = 1; seed <= 4; ++seed) {
            RareField light(window, field.chance, field.spread, field.patch, seed);
            const Made made = make(window, 0.3, 1 << 15, light);
            const double ratio = overEven(made.film, window, light);
            INFO(field.name << ", seed " << seed << ": " << ratio << " with " << made.film.meanSamples() << " samples");
            CHECK(ratio < 1.1 * field.atMost);
            mean += ratio / 4;
        }
        INFO(field.name << ": " << mean);
        CHECK(mean < field.atMost);
    }
}

TEST_CASE("picture noise: pictures have the mean of a converged one", "[picture-noise]") {
    const bool shares = GENERATE(false, true);
    INFO((shares ? "shared" : "not shared"));
    Scene scene = noisyScene(24);
    scene.render.boxFilter = !shares;
    RenderScene ready(scene, false);
    ready.setFrame(1);
    FrameOptions even;
    even.spp = 1 << 14;
    even.seed = 4711;
    const std::vector<float> reference = coloursOf(renderFrame(ready, even).film.resolve());
    constexpr int kSeeds = 32;
    std::vector<double> sums(reference.size());
    std::vector<double> squares(reference.size());
    double whole = 0;
    double wholeSquare = 0;
    double samples = 0;
    for (int seed = 1; seed <= kSeeds; ++seed) {
        const FrameResult result = renderFrame(ready, toNoise(shares ? 0.07 : 0.1, static_cast<std::uint32_t>(seed), shares));
        const std::vector<float> picture = coloursOf(result.film.resolve());
        double difference = 0;
        for (std::size_t i = 0; i < picture.size(); ++i) {
            const double d = static_cast<double>(picture[i]) - static_cast<double>(reference[i]);
            sums[i] += d;
            squares[i] += d * d;
            difference += d;
        }
        whole += difference / kSeeds;
        wholeSquare += difference * difference / kSeeds;
        samples += result.film.meanSamples() / kSeeds;
    }
    CHECK(samples > 8); // more than the first pass: somebody decided
    const double wholeSpread = std::sqrt((wholeSquare - whole * whole) / (kSeeds - 1));
    INFO("sum of all pixels off by " << whole << " +- " << wholeSpread << ", " << samples << " samples a pixel");
    CHECK(std::fabs(whole) < 4 * wholeSpread);
    // Of each value the squared mean: its variance, and the reference's, where there is no bias. Of independent normal values the sum has
    // the variance 2 sum v^2.
    const double both = 1 + kSeeds * samples / even.spp;
    double bias = 0;
    double noise = 0;
    double spread = 0;
    for (std::size_t i = 0; i < sums.size(); ++i) {
        const double mean = sums[i] / kSeeds;
        const double variance = both * (squares[i] / kSeeds - mean * mean) / (kSeeds - 1);
        bias += mean * mean;
        noise += variance;
        spread += 2 * variance * variance;
    }
    INFO("squared means " << bias << ", by noise " << noise << " +- " << std::sqrt(spread));
    CHECK(bias < noise + 5 * std::sqrt(spread)); // colours of a pixel go together
    CHECK(bias > noise - 5 * std::sqrt(spread));
    CHECK(std::sqrt(spread) < 0.3 * noise);
}

TEST_CASE("picture noise: a rendered picture has the noise that is asked for, and says so", "[picture-noise]") {
    Scene scene = noisyScene(96);
    scene.render.boxFilter = false;
    RenderScene ready(scene, false);
    ready.setFrame(1);
    for (const auto &[goal, shares] : {std::pair(0.1, false), std::pair(0.04, false), std::pair(0.1, true), std::pair(0.04, true)}) {
        const FrameResult a = renderFrame(ready, toNoise(goal, 1, shares));
        const FrameResult b = renderFrame(ready, toNoise(goal, 2, shares));
        const double noise = noiseOfTwo(a.film, b.film);
        INFO(goal << (shares ? ", shared" : "") << ": true " << noise << ", told " << a.reached->error << " and " << b.reached->error
                  << ", p " << a.reached->exponent);
        CHECK(noise < 1.15 * goal);
        CHECK(noise > 0.5 * goal);
        CHECK(a.reached->error < 1.3 * noise);
        CHECK(a.reached->error > 0.7 * noise);
        CHECK(a.reached->controls > 10);
        CHECK(a.film.samples() > 2 * static_cast<int>(a.film.samplesAt(0, 0))); // the sky is even
    }
}

TEST_CASE("picture noise: the same bits for any number of threads, budgets, and after going on elsewhere", "[picture-noise]") {
    const bool shares = GENERATE(false, true);
    Scene scene = noisyScene(52);
    scene.render.boxFilter = !shares;
    RenderScene ready(scene, false);
    ready.setFrame(1);
    const FrameOptions options = toNoise(0.08, 5, shares);
    const auto onThreads = [&](std::size_t threads) {
        const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
        return renderFrame(ready, options).film;
    };
    const Film whole = onThreads(2);
    CHECK(onThreads(1) == whole);
    std::stringstream saved;
    {
        FrameRender frame(ready, options);
        CHECK(frame.advance({1, 0}) == FrameState::Going); // one pass
        frame.save(saved);
    }
    const std::string bytes = saved.str();
    FrameRender other(ready, options);
    other.restore(saved);
    while (other.advance({0, 1e-3}) != FrameState::Done) {}
    const PictureNoiseReached reached = *other.reached();
    CHECK(std::move(other).takeFilm() == whole);
    CHECK(reached.error == renderFrame(ready, options).reached->error);
    // Of another goal, or damaged: refused, and nothing is changed.
    FrameRender strange(ready, toNoise(0.07, 5, shares));
    std::istringstream again(bytes);
    CHECK_THROWS_AS(strange.restore(again), InputError);
    for (std::size_t cut : {bytes.size() - 1, bytes.size() - 400}) {
        std::istringstream part(bytes.substr(0, cut));
        CHECK_THROWS_AS(FrameRender(ready, options).restore(part), InputError);
    }
}

TEST_CASE("picture noise: the command takes an error and says what it reached", "[picture-noise][cli]") {
    const Workplace place("error");
    const CommandResult result = runTaut(
        {"render", place.scene, "-o", place.path("a.exr"), "--error", "0.1", "--stats", place.path("s.json"), "--progress", "plain"});
    requireSuccess(result);
    CHECK(result.err.find("error 0.") != std::string::npos);
    CHECK(result.err.find("noise 0.") != std::string::npos);
    CHECK(result.err.find("bias 0") != std::string::npos);
    for (const char *value : {"0", "-0.1", "1", "nan", "fine", ""}) {
        INFO(value);
        checkUsageError(runTaut({"render", place.scene, "-o", place.path("b.exr"), "--error", value}), "--error");
    }
    for (const auto &[option, value] : {std::pair("--noise", "0.1"), std::pair("--time", "5s"), std::pair("--tolerance", "0.1")}) {
        INFO(option);
        checkUsageError(runTaut({"render", place.scene, "-o", place.path("b.exr"), "--error", "0.1", option, value}), option);
    }
    checkUsageError(runTaut({"view", place.scene, "--no-open", "--error", "0.1"}), "--error");
    checkUsageError(runTaut({"render", place.scene, "-o", place.path("b.exr"), "--error", "0.1", "--shard", "1/2", "--shard-by", "rows"}),
                    "--error");
    CHECK(!fs::exists(place.path("b.exr")));
}
