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

    std::uint64_t add(Film &film, const Window &part, int first, int last) {
        std::normal_distribution<double> normal;
        for (int y = part.y0; y < part.y1; ++y)
            for (int x = part.x0; x < part.x1; ++x)
                for (int i = first; i < last; ++i)
                    film.add(x, y, Vec3(static_cast<float>(1 + (x < middle_ ? left_ : right_) * normal(engine_))), 1, nullptr);
        return static_cast<std::uint64_t>(part.width()) * static_cast<std::uint64_t>(part.height()) * static_cast<std::uint64_t>(last - first);
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
        const std::vector<PassPiece> controls = passes.controls();
        std::vector<std::vector<double>> again;
        for (const PassPiece &piece : controls) {
            Film other(piece.window, {});
            light.add(other, piece.window, 0, piece.last);
            std::vector<double> &means = again.emplace_back();
            ColourSums::fill(other, piece.window, means);
            for (double &value : means) value /= piece.last;
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

Scene noisyScene(int size) {
    Scene scene = smallScene(makeObject(makeSphere(48, 24, 0.7F)), ggxMaterial(0.05F, 0.3F), size);
    scene.environment = studioEnvironment();
    return scene;
}

FrameOptions toNoise(double noise, std::uint32_t seed) {
    FrameOptions options;
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
        CHECK(error < 1.06 * kGoal); // the standard error of what is told is 5 %
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
}

TEST_CASE("picture noise: rare light keeps its mean", "[picture-noise]") {
    struct RareLight {
        std::mt19937 engine;
        std::uint64_t add(Film &film, const Window &part, int first, int last) {
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

TEST_CASE("picture noise: a rendered picture has the noise that is asked for, and says so", "[picture-noise]") {
    RenderScene ready(noisyScene(96), false);
    ready.setFrame(1);
    for (const double goal : {0.1, 0.04}) {
        const FrameResult a = renderFrame(ready, toNoise(goal, 1));
        const FrameResult b = renderFrame(ready, toNoise(goal, 2));
        const double noise = noiseOfTwo(a.film, b.film);
        INFO(goal << ": true " << noise << ", told " << a.reached->error << " and " << b.reached->error << ", p " << a.reached->exponent);
        CHECK(noise < 1.15 * goal);
        CHECK(noise > 0.5 * goal);
        CHECK(a.reached->error < 1.3 * noise);
        CHECK(a.reached->error > 0.7 * noise);
        CHECK(a.film.samples() > 2 * static_cast<int>(a.film.samplesAt(0, 0))); // the sky is even
    }
}

TEST_CASE("picture noise: the same bits for any number of threads, budgets, and after going on elsewhere", "[picture-noise]") {
    RenderScene ready(noisyScene(52), false);
    ready.setFrame(1);
    const FrameOptions options = toNoise(0.08, 5);
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
    FrameRender strange(ready, toNoise(0.07, 5));
    std::istringstream again(bytes);
    CHECK_THROWS_AS(strange.restore(again), InputError);
    for (std::size_t cut : {bytes.size() - 1, bytes.size() - 400}) {
        std::istringstream part(bytes.substr(0, cut));
        CHECK_THROWS_AS(FrameRender(ready, options).restore(part), InputError);
    }
}

TEST_CASE("picture noise: the command takes an error and says what it reached", "[picture-noise][cli]") {
    const Workplace place("error");
    const CommandResult result = runTaut({"render", place.scene, "-o", place.path("a.exr"), "--error", "0.1", "--stats", place.path("s.json"), "--progress", "plain"});
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
    checkUsageError(runTaut({"render", place.scene, "-o", place.path("b.exr"), "--error", "0.1", "--shard", "1/2", "--shard-by", "rows"}), "--error");
    CHECK(!fs::exists(place.path("b.exr")));
}
