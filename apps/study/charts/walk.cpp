/// The walk from facet to facet: how noisy one evaluation is and what it costs, by next events and with heights integrated out; and what
/// that means in pictures.

#include "study/charts.h"
#include "study/measures/image_error.h"
#include "study/measures/render_image.h"
#include "study/measures/timing.h"
#include "study/scenes/bench_scenes.h"
#include "study/text.h"

#include "taut/microsurface/random_walk.h"

#include <cmath>

namespace taut::chart {

namespace {

struct Surface {
    const char *name;
    MicroTransform m;
};
std::vector<Surface> surfaces() {
    return {{"alpha 0.1", microTransformFromAlpha(0.1F, 0.1F)}, {"alpha 0.25", microTransformFromAlpha(0.25F, 0.25F)},
            {"alpha 0.5", microTransformFromAlpha(0.5F, 0.5F)}, {"alpha 1", microTransformFromAlpha(1, 1)},
            {"alpha 2", microTransformFromAlpha(2, 2)},         {"alpha (1, 0.05)", microTransformFromAlpha(1, 0.05F)},
            {"[1 2; 0 1]", microTransform(1, 2, 0, 1)},         {"[5 6; 0 1]", microTransform(5, 6, 0, 1)},
            {"leaning", microTransform(1.2F, 0.4F, 0, 0.9F, 0.4F, -0.3F)}};
}

struct Pair {
    Vec3 wo, wi;
};
/// Views and lights from above to grazing, on one side, across and opposite.
std::vector<Pair> pairs() {
    const auto direction = [](float theta, float turn) { return Vec3(std::sin(theta * kPi / 180) * unitCircle(turn), std::cos(theta * kPi / 180)); };
    std::vector<Pair> all;
    for (const float view : {5.0F, 40.0F, 75.0F})
        for (const float light : {10.0F, 50.0F, 80.0F})
            for (const float turn : {0.0F, 0.28F, 0.5F}) all.push_back({direction(view, 0.08F), direction(light, 0.08F + turn)});
    return all;
}

enum class Estimator { NextEvents, Integrated };

float evaluate(Estimator estimator, const MicroTransform &m, const Pair &pair, walk::Random &random) {
    const walk::UniformReflector mirror;
    const walk::Ends ends = walk::drawEnds(random);
    return estimator == Estimator::NextEvents ? walk::evaluateByNextEvents(m, pair.wo, pair.wi, mirror, ends.first, random).x
                                              : walk::evaluateMultiple(m, pair.wo, pair.wi, mirror, ends, random).x;
}

double varianceOf(Estimator estimator, const MicroTransform &m, const Pair &pair, int samples) {
    walk::Random random(17);
    double sum = 0;
    double squares = 0;
    for (int i = 0; i < samples; ++i) {
        const auto x = static_cast<double>(evaluate(estimator, m, pair, random));
        sum += x;
        squares += x * x;
    }
    return squares / samples - sum / samples * (sum / samples);
}

/// Geometric mean over the pairs of what is left of the variance of next events.
double varianceLeft(const MicroTransform &m, int samples) {
    double logarithms = 0;
    const std::vector<Pair> all = pairs();
    for (const Pair &pair : all)
        logarithms += std::log(varianceOf(Estimator::Integrated, m, pair, samples) / varianceOf(Estimator::NextEvents, m, pair, samples));
    return std::exp(logarithms / static_cast<double>(all.size()));
}

Table evaluations(const ChartOptions &options) {
    Table table{"evaluation", "One evaluation of the light of two and more facets, F = 1: heights integrated out over next events",
                {"M", "next events, ns", "integrated, ns", "variance left", "variance x time left"}, {}};
    const std::vector<Surface> all = surfaces();
    const std::vector<Pair> directions = pairs();
    std::vector<std::function<void()>> runs;
    for (const Surface &surface : all)
        for (const Estimator estimator : {Estimator::NextEvents, Estimator::Integrated})
            runs.emplace_back([&surface, &directions, estimator] {
                walk::Random random(3);
                volatile float sink = 0;
                float sum = 0;
                for (int i = 0; i < 200; ++i)
                    for (const Pair &pair : directions) sum += evaluate(estimator, surface.m, pair, random);
                sink = sum;
                (void)sink;
            });
    const std::vector<Measured> seconds = timeInterleaved(runs, options.pick(9, 61), Clock::Thread);
    const double scale = 1e9 / (200.0 * static_cast<double>(directions.size()));
    for (std::size_t i = 0; i < all.size(); ++i) {
        const double before = seconds[2 * i].value * scale;
        const double now = seconds[2 * i + 1].value * scale;
        const double left = varianceLeft(all[i].m, options.pick(20000, 400000));
        table.rows.push_back({all[i].name, printed("%.0f", before), printed("%.0f", now), printed("%.3f", left), printed("%.3f", left * now / before)});
    }
    return table;
}

/// A scene of the benchmark with another gloss.
Scene pictured(const std::string &name, Vec2 alpha, Multiscatter treatment, int size) {
    for (const BenchScene &bench : benchScenes()) {
        if (bench.name != name) continue;
        Scene scene = bench.make();
        Material &metal = scene.materials[0];
        metal.alphaX.value = alpha.x;
        metal.alphaY.value = alpha.y;
        metal.masking = Masking::Correlated;
        metal.multiscatter = treatment;
        scene.render.width = scene.render.height = size;
        return scene;
    }
    throw std::logic_error("no such scene");
}

Table pictures(const ChartOptions &options) {
    const int size = options.pick(64, 192);
    constexpr int kSamples = 16;
    Table table{"pictures", printed("Pictures of %d samples a pixel: mean squared error of two seeds, and seconds, all threads", kSamples),
                {"light", "alpha", "off", "compensation", "walk", "off, s", "compensation, s", "walk, s"}, {}};
    for (const char *light : {"area light", "HDR environment", "sky"})
        for (const Vec2 alpha : {Vec2(0.25F), Vec2(0.5F), Vec2(1), Vec2(0.1F, 1)}) {
            std::vector<std::string> errors;
            std::vector<std::string> times;
            for (const Multiscatter treatment : {Multiscatter::Off, Multiscatter::Compensation, Multiscatter::Walk}) {
                RenderScene ready(pictured(light, alpha, treatment, size), false);
                StageTimes stages;
                ready.setFrame(1, stages);
                const RenderedImage a = renderReady(ready, kSamples, 1);
                const RenderedImage b = renderReady(ready, kSamples, 2);
                errors.push_back(printed("%.5f", errorOfTwo(a.values, b.values)));
                times.push_back(printed("%.2f", (a.render + b.render) / 2));
            }
            std::vector<std::string> row{light, alpha.x == alpha.y ? printed("%g", static_cast<double>(alpha.x)) : "(0.1, 1)"};
            row.insert(row.end(), errors.begin(), errors.end());
            row.insert(row.end(), times.begin(), times.end());
            table.rows.push_back(std::move(row));
        }
    return table;
}

} // namespace

Chart measureWalk(const ChartOptions &options) {
    Chart chart{"walk", "The noise of the walk",
                "Light that meets more than one facet, evaluated for one pair of directions by a random walk: by next events at every "
                "facet (Heitz et al. 2016), and with heights integrated out and the last facet found from both sides, which is what "
                "renders. Means over 27 pairs of directions; and a brushed torus on its ground under three lights.",
                "Less is better. Variance times time does not change with the number of samples."};
    chart.tables.push_back(evaluations(options));
    chart.tables.push_back(pictures(options));
    return chart;
}

} // namespace taut::chart
