/// taut chart plan: what the plan's tolerance saves, and whether it is kept.

#include "study/charts.h"
#include "study/measures/image_error.h"
#include "study/measures/render_image.h"
#include "study/measures/timing.h"
#include "study/scenes/plan_scenes.h"
#include "study/text.h"

#include "taut/base/stopwatch.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <optional>

namespace taut::chart {

namespace {

/// The last: none is given.
constexpr std::array<std::optional<float>, 6> kTolerances{0.1F, 0.03F, kDefaultTolerance, 0.003F, 0.001F, std::nullopt};
constexpr std::size_t kCount = kTolerances.size();
constexpr int kSize = 24;
constexpr int kTimedSpp = 16;
constexpr int kErrorSpp = 64;
constexpr std::uint32_t kErrorSeeds = 4;

/// What one plan of a scene costs and loses.
struct Run {
    ScenePlan plan;
    Measured seconds;    ///< three frames
    double variance = 0; ///< of an image at kTimedSpp samples, relative
    Measured error;      ///< RMS from the full model, relative, without what is noise
};

/// One scene under the plan of every tolerance and in full.
struct Outcome {
    std::string name;
    std::vector<Run> runs; ///< different ones; the full model is the last
    std::array<std::size_t, kCount> runOf{};
    std::array<double, kCount> predicted{};
    double planning = 0; ///< s, making one plan

    [[nodiscard]] const Run &at(std::size_t tolerance) const { return runs[runOf[tolerance]]; }
    [[nodiscard]] const Run &full() const { return runs.back(); }
    /// Time over that of the full model: at the same samples, or to the same noise.
    [[nodiscard]] Measured time(std::size_t tolerance, bool equalNoise) const {
        const Run &run = at(tolerance);
        const double noise = equalNoise ? run.variance / full().variance : 1;
        Measured m = run.seconds * (noise / full().seconds.value);
        if (&run != &full()) m.spread = std::hypot(m.spread, m.value * full().seconds.spread / full().seconds.value);
        return m;
    }
};

/// Errors against the last run, from all pairs of seeds; without noise, a square may come out below zero where there is nothing else.
void measureErrors(const PlanScene &scene, std::vector<Run> &runs) {
    std::vector<std::vector<std::vector<float>>> images(runs.size()); // [runs][seeds]
    for (std::size_t i = 0; i < runs.size(); ++i)
        for (std::uint32_t seed = 1; seed <= kErrorSeeds; ++seed)
            images[i].push_back(renderImage(scene.scene, runs[i].plan, scene.frame, kErrorSpp, seed).values);
    for (std::size_t i = 0; i + 1 < runs.size(); ++i) {
        std::vector<double> squares;
        double mean = 0;
        for (std::size_t a = 0; a < kErrorSeeds; ++a)
            for (std::size_t b = 0; b < a; ++b) {
                const double e = expectedDifference(images[i][a], images[i][b], images.back()[a], images.back()[b]);
                squares.push_back(std::copysign(e * e, e));
                mean += squares.back();
            }
        mean /= static_cast<double>(squares.size());
        const Measured square = medianOf(squares);
        const double error = std::sqrt(std::max(mean, 0.0));
        runs[i].error = {error, std::sqrt(std::max(mean + square.spread, 0.0)) - error, static_cast<int>(kErrorSeeds)};
    }
}

Outcome outcomeOf(const PlanScene &scene, int rounds) {
    Outcome outcome;
    outcome.name = scene.name;
    std::vector<Run> &runs = outcome.runs;
    const ScenePlan full = fullPlan(scene.scene);
    Stopwatch watch;
    for (std::size_t i = 0; i < kCount; ++i) {
        Run run;
        run.plan = makePlan(scene.scene, kTolerances[i]);
        outcome.predicted[i] = static_cast<double>(run.plan.predictedError + run.plan.errorInNoise);
        const auto found = std::find_if(runs.begin(), runs.end(),
                                        [&](const Run &r) { return r.plan.bvh == run.plan.bvh && sameModels(r.plan, run.plan); });
        outcome.runOf[i] = static_cast<std::size_t>(found - runs.begin());
        if (found == runs.end()) runs.push_back(std::move(run));
    }
    outcome.planning = watch.lap() / kCount;
    runs.push_back({full, {}, 0, {}});

    std::vector<std::vector<std::vector<float>>> images(runs.size()); // [runs][seeds], of the last frame
    std::vector<std::function<void()>> rows;
    for (std::size_t i = 0; i < runs.size(); ++i)
        rows.emplace_back([&, i] {
            RenderScene ready(scene.scene, runs[i].plan, true);
            StageTimes ignored;
            const auto seed = static_cast<std::uint32_t>(images[i].size() + 1);
            for (const int frame : scene.scene.render.frames) {
                ready.setFrame(frame, ignored);
                const RenderedImage image = renderReady(ready, kTimedSpp, seed);
                if (frame == scene.scene.render.frames.back()) images[i].push_back(image.values);
            }
        });
    const std::vector<Measured> seconds = timeOnOneThread(rows, rounds);
    for (std::size_t i = 0; i < runs.size(); ++i) {
        runs[i].seconds = seconds[i];
        runs[i].variance = relativeVariance(images[i]);
    }
    measureErrors(scene, runs);
    return outcome;
}

bool isDefault(std::size_t i) {
    return !kTolerances[i];
}
std::string nameOf(std::size_t i) {
    return kTolerances[i] ? "tolerance " + digits(static_cast<double>(*kTolerances[i])) : "none given";
}

const Axis kErrorAxis{"RMS error of the image, relative", ""};
Axis timeAxis(bool equalNoise) {
    return {std::string(equalNoise ? "time to the same noise" : "time of the same samples") + ", full model 1", "", false};
}

/// All scenes together: the mean of their times over that of the full model, the worst of their errors.
Panel tolerancePanel(const std::vector<Outcome> &outcomes, bool equalNoise, const std::string &conditions) {
    Panel panel{equalNoise ? "noise" : "samples",
                equalNoise ? "All scenes, to the same noise" : "All scenes, the same samples",
                conditions,
                timeAxis(equalNoise),
                {"worst RMS error of the image, relative", ""},
                {}};
    panel.hasFront = equalNoise;
    panel.joined = true;
    for (std::size_t i = 0; i < kCount; ++i) {
        Measured time;
        Measured worst;
        for (const Outcome &outcome : outcomes) {
            const Measured t = outcome.time(i, equalNoise);
            time.value += t.value / static_cast<double>(outcomes.size());
            time.spread = std::hypot(time.spread, t.spread / static_cast<double>(outcomes.size()));
            time.repetitions = t.repetitions;
            if (outcome.at(i).error.value >= worst.value) worst = outcome.at(i).error;
        }
        panel.points.push_back({isDefault(i) ? "by the samples" : "plan", nameOf(i), time, worst, isDefault(i)});
    }
    return panel;
}

Panel honestyPanel(const std::vector<Outcome> &outcomes, const std::string &conditions) {
    Panel panel{"honesty", "Every scene: predicted against true error", conditions, {"predicted error", ""}, kErrorAxis, {}};
    panel.hasFront = false;
    panel.labelled = false;
    for (std::size_t i = 0; i < kCount; ++i)
        for (const Outcome &outcome : outcomes)
            panel.points.push_back({nameOf(i), outcome.name, {outcome.predicted[i]}, outcome.at(i).error, isDefault(i)});
    return panel;
}

} // namespace

Chart measurePlan(const ChartOptions &options) {
    const int rounds = options.effort == Effort::Quick ? 5 : 21;
    std::vector<Outcome> outcomes;
    for (const PlanScene &scene : planScenes(kSize)) outcomes.push_back(outcomeOf(scene, rounds));
    std::size_t kept = 0;
    double planning = 0;
    const Outcome *cheapest = &outcomes.front();
    std::size_t chosen = 0;
    while (!isDefault(chosen)) ++chosen;
    for (const Outcome &outcome : outcomes) {
        planning += 1e3 * outcome.planning / static_cast<double>(outcomes.size());
        for (std::size_t i = 0; i < kCount; ++i)
            if (kTolerances[i] && outcome.at(i).error.value <= static_cast<double>(*kTolerances[i])) ++kept;
        if (outcome.time(chosen, true).value < cheapest->time(chosen, true).value) cheapest = &outcome;
    }
    const std::string conditions = std::to_string(outcomes.size()) + " scenes, 24 x 24 pixels, " + std::to_string(kTimedSpp) +
                                   " samples, three frames, topology included, plan made beforehand; errors at " +
                                   std::to_string(kErrorSpp) + " samples, of four seeds, without their noise; one thread";
    Chart chart{"plan", "The plan: what a tolerance saves",
                "The cheapest model whose predicted error stays below a tolerance, against the full model, every saving off, with the "
                "same random numbers. Models of multiple scattering differ in noise as well: the first plot counts the time to the "
                "same noise, time by variance.",
                "Left saves time, down is closer to the full model. In the last plot honest plans lie below the diagonal: the true "
                "error is less than the predicted one."};
    chart.panels = {tolerancePanel(outcomes, true, conditions), tolerancePanel(outcomes, false, conditions),
                    honestyPanel(outcomes, conditions)};
    chart.choice = "Default: no tolerance, which is " + digits(static_cast<double>(kDefaultTolerance)) + " and, at the scene's " +
                   std::to_string(RenderSettings{}.spp) +
                   " samples, light of several facets only where it is more than the noise that it brings. Where a tolerance is given, the "
                   "true error is below it in " +
                   std::to_string(kept) + " of " + std::to_string((kCount - 1) * outcomes.size()) +
                   " plans. At the default the scenes take on average " + digits(100 * chart.panels[0].points[chosen].x.value) +
                   " % of the full model's time to the same noise, " + digits(100 * chart.panels[1].points[chosen].x.value) +
                   " % of its time for the same samples, and '" + cheapest->name + "' takes " +
                   digits(100 * cheapest->time(chosen, true).value) + " %. Making a plan takes " + digits(planning, 2) +
                   " ms a scene, once for all frames.";
    return chart;
}

} // namespace taut::chart
