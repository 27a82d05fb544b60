/// taut chart plan: what an error that is asked for costs, and whether it is kept.

#include "study/charts.h"
#include "study/measures/image_error.h"
#include "study/measures/render_image.h"
#include "study/scenes/error_scenes.h"
#include "study/text.h"

#include "taut/base/error.h"
#include "taut/pilot/plan_by_pilots.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <ctime>
#include <iostream>
#include <map>
#include <optional>

namespace taut::chart {

namespace {

constexpr std::array<float, 3> kErrors{0.1F, 0.03F, 0.01F};
constexpr std::array<int, 3> kByHand{16, 64, 256}; // samples a pixel
constexpr int kMost = 1 << 15;

/// Of this process, all its threads: what a busy machine disturbs least.
double processSeconds() {
    timespec time{};
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
    return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

/// How the full model is left behind, step by step.
enum class Means { SamplesWhereNeeded, SharedByPixels, Planned };
constexpr std::array kMeans{Means::SamplesWhereNeeded, Means::SharedByPixels, Means::Planned};

/// A picture with the time of all that it took from the scene on.
struct Shot {
    std::vector<float> values;
    double seconds = 0;
    double samples = 0;
    double told = 0; ///< error that the frame says it has reached
    ScenePlan plan;
};

std::vector<float> valuesOf(const Film &film) {
    const std::vector<float> values = film.resolve();
    std::vector<float> colours;
    for (std::size_t i = 0; i < values.size(); i += 4) colours.insert(colours.end(), {values[i], values[i + 1], values[i + 2]});
    return colours;
}

Shot shoot(const Scene &scene, double frame, PlannedScene planned, FrameOptions options, bool shares, double began) {
    Shot shot;
    shot.plan = planned.plan;
    if (planned.plan.budget) {
        options.picture = PictureGoal{static_cast<double>(planned.plan.budget->noise), planned.plan.budget->firstSamples};
        options.spp = kMost;
        options.shares = shares && mayShare(options, scene.render);
    }
    RenderScene ready(scene, std::move(planned.plan), false, std::move(planned.surfaces));
    ready.setFrame(frame);
    const FrameResult result = renderFrame(ready, options);
    shot.seconds = processSeconds() - began;
    shot.values = valuesOf(result.film);
    shot.samples = result.film.meanSamples();
    if (shot.plan.budget) shot.told = std::hypot(result.reached->error, static_cast<double>(shot.plan.budget->bias));
    return shot;
}

Shot shootTo(const Scene &scene, double frame, float error, Means way, std::uint32_t seed) {
    const double began = processSeconds();
    PlanOptions options;
    options.error = error;
    options.full = way != Means::Planned;
    FrameOptions frameOptions;
    frameOptions.seed = seed;
    return shoot(scene, frame, planByPilots(scene, options), frameOptions, way != Means::SamplesWhereNeeded, began);
}

Shot shootFixed(const Scene &scene, double frame, int spp, std::uint32_t seed) {
    const double began = processSeconds();
    PlannedScene planned;
    planned.plan = fullPlan(scene);
    FrameOptions options;
    options.spp = spp;
    options.seed = seed;
    return shoot(scene, frame, std::move(planned), options, false, began);
}

/// Two pictures of the full model that know nothing of each other: means over all samples that were ever taken of it.
class References {
  public:
    void add(std::size_t which, const std::vector<float> &values, int samples) {
        Sum &sum = sums_[which];
        sum.values.resize(values.size(), 0.0);
        for (std::size_t i = 0; i < values.size(); ++i) sum.values[i] += static_cast<double>(values[i]) * samples;
        sum.samples += samples;
    }
    /// Error against what they would be without their noise: E (I - R1) (I - R2) = (I - R)^2.
    [[nodiscard]] double trueError(const std::vector<float> &image) const {
        double square = 0;
        double all = 0;
        for (std::size_t i = 0; i < image.size(); ++i) {
            const auto value = static_cast<double>(image[i]);
            const double first = sums_[0].values[i] / sums_[0].samples;
            const double second = sums_[1].values[i] / sums_[1].samples;
            square += (value - first) * (value - second);
            all += first * second;
        }
        return std::sqrt(std::max(square, 0.0) / all);
    }
    /// Of either of the two.
    [[nodiscard]] double ownError() const {
        double square = 0;
        double all = 0;
        for (std::size_t i = 0; i < sums_[0].values.size(); ++i) {
            const double first = sums_[0].values[i] / sums_[0].samples;
            const double second = sums_[1].values[i] / sums_[1].samples;
            square += 0.5 * sqr(first - second);
            all += first * second;
        }
        return std::sqrt(square / all);
    }

  private:
    struct Sum {
        std::vector<double> values;
        double samples = 0;
    };
    std::array<Sum, 2> sums_;
};

/// The full model with as many samples in every pixel: its error by two pictures that know nothing of each other, and what one takes.
/// Numbers of samples are tried when they are asked for.
class FixedSamples {
  public:
    FixedSamples(const Scene &scene, double frame, int most) : scene_(scene), frame_(frame), most_(most) {}

    struct Tried {
        double error = 0, seconds = 0;
    };
    const Tried &at(int samples) {
        const auto [place, isNew] = tried_.try_emplace(samples);
        if (!isNew) return place->second;
        std::array<Shot, 2> shots;
        for (std::size_t i = 0; i < 2; ++i) {
            shots[i] = shootFixed(scene_, frame_, samples, static_cast<std::uint32_t>(1000 * (i + 1) + static_cast<std::size_t>(samples)));
            references_.add(i, shots[i].values, samples);
            place->second.seconds += shots[i].seconds / 2;
        }
        double square = 0;
        double all = 0;
        for (std::size_t i = 0; i < shots[0].values.size(); ++i) {
            square += 0.5 * sqr(static_cast<double>(shots[0].values[i]) - static_cast<double>(shots[1].values[i]));
            all += static_cast<double>(shots[0].values[i]) * static_cast<double>(shots[1].values[i]);
        }
        place->second.error = std::sqrt(square / all);
        return place->second;
    }
    /// Seconds with the fewest samples, of 1, 2, 3, 4, 6, 8, ..., that reach an error; beyond the most that are tried, as many as the last
    /// part of the curve foresees, in proportion.
    double secondsTo(double error) {
        int samples = 1;
        while (samples < most_ && at(samples).error > error) samples *= 2;
        const Tried &last = at(samples);
        if (last.error <= error) return samples > 2 && at(samples / 4 * 3).error <= error ? at(samples / 4 * 3).seconds : last.seconds;
        const std::array<ErrorPoint, 2> curve{ErrorPoint{samples / 4.0, at(samples / 4).error}, {static_cast<double>(samples), last.error}};
        const double rate = (last.seconds - at(samples / 4).seconds) / (0.75 * samples);
        return last.seconds + rate * (samplesToReach(curve, error) - samples);
    }
    /// Sharp enough to tell an error from: samples are added, twice as many each time, until either is no further off than that.
    const References &referencesFor(double error) {
        for (int samples = 2 * most_; references_.ownError() > error && samples <= kMost; samples *= 2)
            for (std::size_t i = 0; i < 2; ++i)
                references_.add(
                    i,
                    shootFixed(scene_, frame_, samples, static_cast<std::uint32_t>(1000 * (i + 1)) + static_cast<std::uint32_t>(samples))
                        .values,
                    samples);
        return references_;
    }

  private:
    const Scene &scene_;
    double frame_;
    int most_;
    std::map<int, Tried> tried_;
    References references_;
};

/// What a way to render to an error came to.
struct Reached {
    double error = 0, told = 0;
    double seconds = 0;
    double fixed = 0; ///< s of the full model with the fewest samples, the same in every pixel, that reach the asked error
    double samples = 0;
    [[nodiscard]] double ratio() const { return seconds / fixed; }
};

struct Outcome {
    std::string name;
    std::array<std::array<Reached, kErrors.size()>, kMeans.size()> ways;
    [[nodiscard]] const Reached &of(Means way, std::size_t error) const { return ways[static_cast<std::size_t>(way)][error]; }
    std::array<FixedSamples::Tried, kByHand.size()> byHand;
};

Outcome outcomeOf(const ErrorScene &from, int most) {
    const Scene scene = from.make();
    FixedSamples fixed(scene, from.frame, most);
    Outcome outcome;
    outcome.name = from.name;
    std::array<double, kErrors.size()> seconds{};
    for (std::size_t i = 0; i < kErrors.size(); ++i) seconds[i] = fixed.secondsTo(static_cast<double>(kErrors[i]));
    for (std::size_t i = 0; i < kByHand.size(); ++i) outcome.byHand[i] = fixed.at(std::min(kByHand[i], most));
    const References &references = fixed.referencesFor(static_cast<double>(kErrors.back()));
    for (std::size_t i = 0; i < kErrors.size(); ++i)
        for (const Means way : kMeans) {
            const Shot shot = shootTo(scene, from.frame, kErrors[i], way, 17);
            outcome.ways[static_cast<std::size_t>(way)][i] = {references.trueError(shot.values), shot.told, shot.seconds, seconds[i],
                                                              shot.samples};
        }
    return outcome;
}

double geometricMean(const std::vector<double> &values) {
    double sum = 0;
    for (const double value : values) sum += std::log(value) / static_cast<double>(values.size());
    return std::exp(sum);
}

/// Ratios of time over all scenes, of one asked error or of all.
std::vector<double> ratiosOf(const std::vector<Outcome> &outcomes, Means way, std::optional<std::size_t> error) {
    std::vector<double> ratios;
    for (const Outcome &outcome : outcomes)
        for (std::size_t i = 0; i < kErrors.size(); ++i)
            if (!error || *error == i) ratios.push_back(outcome.of(way, i).ratio());
    return ratios;
}

std::string asked(std::size_t i) {
    return "error " + digits(static_cast<double>(kErrors[i]));
}

/// A chart of many minutes says how far it is.
void tell(const Outcome &outcome) {
    std::cerr << outcome.name;
    for (std::size_t i = 0; i < kErrors.size(); ++i) {
        const Reached &way = outcome.of(Means::Planned, i);
        std::cerr << "; " << kErrors[i] << ": true " << digits(way.error) << ", told " << digits(way.told) << ", time "
                  << digits(way.ratio()) << ", full model " << digits(outcome.of(Means::SharedByPixels, i).ratio()) << ", not shared "
                  << digits(outcome.of(Means::SamplesWhereNeeded, i).ratio());
    }
    std::cerr << std::endl;
}

} // namespace

Chart measurePlan(const ChartOptions &options) {
    const bool quick = options.effort == Effort::Quick;
    const char *wanted = std::getenv("TAUT_PLAN_WIDTH");
    const int width = wanted != nullptr ? std::clamp(std::atoi(wanted), 16, 1024) : quick ? 48 : 96;
    const char *only = std::getenv("TAUT_PLAN_SCENES");
    const std::string named = only != nullptr ? ':' + std::string(only) + ':' : "";
    std::vector<Outcome> outcomes;
    int number = 0;
    for (const ErrorScene &scene : errorScenes(width))
        if (only != nullptr ? named.find(':' + scene.name + ':') != std::string::npos : !quick || number++ % 6 == 2) {
            outcomes.push_back(outcomeOf(scene, quick ? 64 : 1024));
            tell(outcomes.back());
        }

    if (outcomes.empty())
        throw InputError("TAUT_PLAN_SCENES: found " + quoted(std::string(only)) + ", expected names of scenes, separated by colons");

    const std::string conditions = std::to_string(outcomes.size()) + " scenes, " + std::to_string(width) +
                                   " pixels wide; time of the process from the scene on: plan, pilots, topology, frame, samples";
    Panel honesty{"honesty",
                  "Asked against true error, every scene",
                  conditions,
                  {"error that is asked for", ""},
                  {"true error of the picture, relative RMS", ""},
                  {}};
    honesty.hasFront = honesty.labelled = false;
    Panel time{"time",
               "Time over that of the full model with the best fixed samples",
               conditions,
               {"time to the asked error, full model with the best fixed samples 1", ""},
               {"true error of the picture, relative RMS", ""},
               {}};
    time.hasFront = time.labelled = false;
    Panel hand{"hand", "By hand and by an error", conditions, {"time", "s"}, {"true error of the picture, relative RMS", ""}, {}};
    hand.hasFront = hand.labelled = false;
    Panel parts{"parts",
                "All scenes: what samples, shares and models save, one beside the other",
                conditions,
                {"time to the asked error, geometric mean", "", false},
                {"error that is asked for", ""},
                {}};
    parts.joined = true;
    parts.hasFront = false;
    Table table{
        "scenes", "Every scene", {"scene", "asked", "true error", "told", "samples a pixel", "time over full", "full model", "not shared"}};
    std::size_t kept = 0;
    std::vector<double> shares;
    double slowest = 0;
    for (const Outcome &outcome : outcomes)
        for (std::size_t i = 0; i < kByHand.size(); ++i)
            hand.points.push_back({"full model, " + std::to_string(kByHand[i]) + " samples",
                                   outcome.name,
                                   {outcome.byHand[i].seconds},
                                   {outcome.byHand[i].error},
                                   false});
    for (const Outcome &outcome : outcomes)
        for (std::size_t i = 0; i < kErrors.size(); ++i) {
            const Reached &way = outcome.of(Means::Planned, i);
            hand.points.push_back({asked(i), outcome.name, {way.seconds}, {way.error}, false});
            const auto error = static_cast<double>(kErrors[i]);
            honesty.points.push_back({asked(i), outcome.name, {error}, {way.error}, false});
            time.points.push_back({asked(i), outcome.name, {way.ratio()}, {way.error}, false});
            table.rows.push_back({outcome.name, digits(error), digits(way.error), digits(way.told), digits(way.samples),
                                  digits(way.ratio()), digits(outcome.of(Means::SharedByPixels, i).ratio()),
                                  digits(outcome.of(Means::SamplesWhereNeeded, i).ratio())});
            kept += way.error <= error ? 1 : 0;
            shares.push_back(way.error / error);
            slowest = std::max(slowest, way.ratio());
        }
    std::sort(shares.begin(), shares.end());
    for (std::size_t i = 0; i < kErrors.size(); ++i) {
        const Measured error{static_cast<double>(kErrors[i])};
        parts.points.push_back({"full model, fixed samples", asked(i), {1}, error, false});
        const auto add = [&](const char *name, Means way) {
            parts.points.push_back({name, asked(i), {geometricMean(ratiosOf(outcomes, way, i))}, error, way == Means::Planned});
        };
        add("full model, samples where they are needed", Means::SamplesWhereNeeded);
        add("and shared by pixels", Means::SharedByPixels);
        add("plan", Means::Planned);
    }
    Chart chart{
        "plan", "An error that is asked for",
        "Pictures rendered to a relative RMS error, bias and noise together, against the full model. The truth is the full model without "
        "its noise, by two references of all its samples; the best fixed number of samples is the first of 1, 2, 3, 4, 6, 8, 12, ... that "
        "reaches the asked error.",
        "In the first plot pictures below the diagonal keep what was asked, and those close to it waste nothing. In the others left saves "
        "time."};
    chart.panels = {honesty, time, hand, parts};
    chart.tables = {table};
    const std::vector<double> all = ratiosOf(outcomes, Means::Planned, std::nullopt);
    chart.choice = "The true error is at most the asked one in " + std::to_string(kept) + " of " + std::to_string(shares.size()) +
                   " pictures, and " + digits(shares[shares.size() / 2]) + " of it in the median (" + digits(shares.front()) + " to " +
                   digits(shares.back()) + "). Time for the same error over the full model with the best fixed samples: geometric mean " +
                   digits(geometricMean(all)) + ", slowest " + digits(slowest) + "; the full model " +
                   digits(geometricMean(ratiosOf(outcomes, Means::SharedByPixels, std::nullopt))) + ", and without sharing " +
                   digits(geometricMean(ratiosOf(outcomes, Means::SamplesWhereNeeded, std::nullopt))) + ".";
    return chart;
}

} // namespace taut::chart
