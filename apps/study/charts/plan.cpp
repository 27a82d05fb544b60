/// taut chart plan: what an error that is asked for costs, and whether it is kept.

#include "study/charts.h"
#include "study/measures/image_error.h"
#include "study/measures/render_image.h"
#include "study/scenes/error_scenes.h"
#include "study/text.h"

#include "taut/pilot/plan_by_pilots.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <ctime>
#include <optional>

namespace taut::chart {

namespace {

constexpr std::array<float, 3> kErrors{0.1F, 0.03F, 0.01F};
constexpr int kMost = 1 << 15; // samples a pixel
constexpr int kSeeds = 3;      // errors of few samples are averaged over

/// Of this process, all its threads: what a busy machine disturbs least.
double processSeconds() {
    timespec time{};
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
    return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

/// A picture with the time of all that it took from the scene on.
struct Shot {
    std::vector<float> values;
    double seconds = 0;
    double samples = 0;
    double told = 0; ///< error that the frame says it has reached
    ScenePlan plan;
};

std::vector<float> coloursOf(const Film &film) {
    const std::vector<float> values = film.resolve();
    std::vector<float> colours;
    for (std::size_t i = 0; i < values.size(); i += 4) colours.insert(colours.end(), {values[i], values[i + 1], values[i + 2]});
    return colours;
}

Shot shoot(const Scene &scene, double frame, PlannedScene planned, FrameOptions options, double began) {
    Shot shot;
    shot.plan = planned.plan;
    if (planned.plan.budget) {
        options.picture = PictureGoal{static_cast<double>(planned.plan.budget->noise), planned.plan.budget->firstSamples};
        options.spp = kMost;
    }
    RenderScene ready(scene, std::move(planned.plan), false, std::move(planned.surfaces));
    ready.setFrame(frame);
    const FrameResult result = renderFrame(ready, options);
    shot.seconds = processSeconds() - began;
    shot.values = coloursOf(result.film);
    shot.samples = result.film.meanSamples();
    if (shot.plan.budget) shot.told = std::hypot(result.reached->error, static_cast<double>(shot.plan.budget->bias));
    return shot;
}

Shot shootTo(const Scene &scene, double frame, float error, bool full, std::uint32_t seed) {
    const double began = processSeconds();
    PlanOptions options;
    options.error = error;
    options.full = full;
    FrameOptions frameOptions;
    frameOptions.seed = seed;
    return shoot(scene, frame, planByPilots(scene, options), frameOptions, began);
}

Shot shootFixed(const Scene &scene, double frame, int spp, std::uint32_t seed) {
    const double began = processSeconds();
    PlannedScene planned;
    planned.plan = fullPlan(scene);
    FrameOptions options;
    options.spp = spp;
    options.seed = seed;
    return shoot(scene, frame, std::move(planned), options, began);
}

/// Error against what two references would be without their noise: E (I - R1) (I - R2) = (I - R)^2.
double trueError(const std::vector<float> &image, const std::array<std::vector<float>, 2> &references) {
    double square = 0;
    double all = 0;
    for (std::size_t i = 0; i < image.size(); ++i) {
        const auto value = static_cast<double>(image[i]);
        const auto first = static_cast<double>(references[0][i]);
        const auto second = static_cast<double>(references[1][i]);
        square += (value - first) * (value - second);
        all += first * second;
    }
    return std::sqrt(std::max(square, 0.0) / all);
}

/// One way to render to an error.
struct Way {
    double error = 0, told = 0;
    double seconds = 0;
    double fixed = 0; ///< s of the full model with the fewest samples, the same in every pixel, that reach the asked error
    double samples = 0;
    [[nodiscard]] double ratio() const { return seconds / fixed; }
};

struct Outcome {
    std::string name;
    std::array<Way, kErrors.size()> planned, samplesAlone;
};

/// Seconds of the full model for an error: with the fewest samples of the curve that reach it, or, beyond its end, with as many as its
/// last part foresees, in proportion.
double fixedSeconds(const std::vector<ErrorPoint> &curve, const std::vector<double> &seconds, double error) {
    for (std::size_t i = 0; i < curve.size(); ++i)
        if (curve[i].error <= error) return seconds[i];
    const double rate = (seconds.back() - seconds.front()) / (curve.back().samples - curve.front().samples);
    return seconds.back() + rate * (samplesToReach(curve, error) - curve.back().samples);
}

Outcome outcomeOf(const ErrorScene &from, int most) {
    const Scene scene = from.make();
    const std::array<std::vector<float>, 2> references{shootFixed(scene, from.frame, 4 * most, 1001).values,
                                                       shootFixed(scene, from.frame, 4 * most, 1002).values};
    std::vector<ErrorPoint> curve;
    std::vector<double> seconds;
    for (int spp = 1; spp <= most; spp = nextSampleCount(spp)) {
        double square = 0;
        double spent = 0;
        const int seeds = spp < 32 ? kSeeds : 1;
        for (int seed = 1; seed <= seeds; ++seed) {
            const Shot shot = shootFixed(scene, from.frame, spp, static_cast<std::uint32_t>(seed));
            square += sqr(trueError(shot.values, references)) / seeds;
            spent += shot.seconds / seeds;
        }
        curve.push_back({static_cast<double>(spp), std::sqrt(square)});
        seconds.push_back(spent);
    }
    Outcome outcome;
    outcome.name = from.name;
    for (std::size_t i = 0; i < kErrors.size(); ++i)
        for (const bool full : {false, true}) {
            const Shot shot = shootTo(scene, from.frame, kErrors[i], full, 17);
            Way &way = full ? outcome.samplesAlone[i] : outcome.planned[i];
            way = {trueError(shot.values, references), shot.told, shot.seconds, 0, shot.samples};
            way.fixed = fixedSeconds(curve, seconds, static_cast<double>(kErrors[i]));
        }
    return outcome;
}

double geometricMean(const std::vector<double> &values) {
    double sum = 0;
    for (const double value : values) sum += std::log(value) / static_cast<double>(values.size());
    return std::exp(sum);
}

/// Ratios of time over all scenes, of one asked error or of all.
std::vector<double> ratiosOf(const std::vector<Outcome> &outcomes, bool planned, std::optional<std::size_t> error) {
    std::vector<double> ratios;
    for (const Outcome &outcome : outcomes)
        for (std::size_t i = 0; i < kErrors.size(); ++i)
            if (!error || *error == i) ratios.push_back((planned ? outcome.planned : outcome.samplesAlone)[i].ratio());
    return ratios;
}

std::string asked(std::size_t i) {
    return "error " + digits(static_cast<double>(kErrors[i]));
}

} // namespace

Chart measurePlan(const ChartOptions &options) {
    const bool quick = options.effort == Effort::Quick;
    const int width = quick ? 48 : 96;
    std::vector<Outcome> outcomes;
    int number = 0;
    for (const ErrorScene &scene : errorScenes(width))
        if (!quick || number++ % 6 == 2) outcomes.push_back(outcomeOf(scene, quick ? 64 : 256));

    const std::string conditions = std::to_string(outcomes.size()) + " scenes, " + std::to_string(width) +
                                   " pixels wide; time of the process from the scene on: plan, pilots, topology, frame, samples";
    Panel honesty{"honesty", "Asked against true error, every scene", conditions, {"error that is asked for", ""},
                  {"true error of the picture, relative RMS", ""}, {}};
    honesty.hasFront = honesty.labelled = false;
    Panel time{"time", "Time over that of the full model with the best fixed samples", conditions,
               {"time to the asked error, full model with the best fixed samples 1", ""}, {"true error of the picture, relative RMS", ""}, {}};
    time.hasFront = time.labelled = false;
    Panel parts{"parts", "All scenes: what samples save, and what models save beside", conditions,
                {"time to the asked error, geometric mean", "", false}, {"error that is asked for", ""}, {}};
    parts.joined = true;
    parts.hasFront = false;
    Table table{"scenes", "Every scene", {"scene", "asked", "true error", "told", "samples a pixel", "time over full", "samples alone"}};
    std::size_t kept = 0;
    std::vector<double> shares;
    double slowest = 0;
    for (const Outcome &outcome : outcomes)
        for (std::size_t i = 0; i < kErrors.size(); ++i) {
            const Way &way = outcome.planned[i];
            const auto error = static_cast<double>(kErrors[i]);
            honesty.points.push_back({asked(i), outcome.name, {error}, {way.error}, false});
            time.points.push_back({asked(i), outcome.name, {way.ratio()}, {way.error}, false});
            table.rows.push_back({outcome.name, digits(error), digits(way.error), digits(way.told), digits(way.samples), digits(way.ratio()),
                                  digits(outcome.samplesAlone[i].ratio())});
            kept += way.error <= error ? 1 : 0;
            shares.push_back(way.error / error);
            slowest = std::max(slowest, way.ratio());
        }
    std::sort(shares.begin(), shares.end());
    for (std::size_t i = 0; i < kErrors.size(); ++i) {
        const Measured error{static_cast<double>(kErrors[i])};
        parts.points.push_back({"full model, fixed samples", asked(i), {1}, error, false});
        parts.points.push_back({"full model, samples where they are needed", asked(i), {geometricMean(ratiosOf(outcomes, false, i))}, error, false});
        parts.points.push_back({"plan, samples where they are needed", asked(i), {geometricMean(ratiosOf(outcomes, true, i))}, error, true});
    }
    Chart chart{"plan", "An error that is asked for",
                "Pictures rendered to a relative RMS error, bias and noise together, against the full model. The truth is the full model as two "
                "references without their noise; the best fixed number of samples is the first of 1, 2, 3, 4, 6, 8, 12, ... that reaches the asked error.",
                "In the first plot pictures below the diagonal keep what was asked, and those close to it waste nothing. In the others left saves "
                "time."};
    chart.panels = {honesty, time, parts};
    chart.tables = {table};
    const std::vector<double> all = ratiosOf(outcomes, true, std::nullopt);
    chart.choice = "The true error is at most the asked one in " + std::to_string(kept) + " of " + std::to_string(shares.size()) +
                   " pictures, and " + digits(shares[shares.size() / 2]) + " of it in the median (" + digits(shares.front()) + " to " +
                   digits(shares.back()) + "). Time for the same error over the full model with the best fixed samples: geometric mean " +
                   digits(geometricMean(all)) + ", slowest " + digits(slowest) + "; samples alone " +
                   digits(geometricMean(ratiosOf(outcomes, false, std::nullopt))) + ".";
    return chart;
}

} // namespace taut::chart
