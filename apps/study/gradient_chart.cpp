/// taut chart gradient: estimators of the surface gradient, time against the error of V and of the image.

#include "study/charts.h"
#include "study/limit_error.h"
#include "study/render_image.h"
#include "study/text.h"
#include "study/timing.h"

#include "taut/mesh/shapes.h"

#include <cmath>
#include <functional>
#include <memory>

namespace taut::chart {

namespace {

constexpr GradientEstimator kOfMeshes[] = {GradientEstimator::Face, GradientEstimator::Area, GradientEstimator::Angle,
                                           GradientEstimator::LeastSquares, GradientEstimator::Analytic};
constexpr GradientEstimator kOfLimits[] = {GradientEstimator::Face, GradientEstimator::Area, GradientEstimator::Angle,
                                           GradientEstimator::LeastSquares, GradientEstimator::Limit};

/// The estimator that an object has where nobody asks for one.
GradientEstimator chosenFor(int level) {
    Object object;
    object.mesh = std::make_shared<const Mesh>();
    object.subdivision.level = level;
    return defaultEstimator(object);
}

std::vector<GradientCase> deformerCases() {
    std::vector<GradientCase> cases;
    for (const GradientCase &c : gradientCases())
        if (!c.skinned) cases.push_back(c);
    return cases;
}
GradientCase skinnedCase() {
    return gradientCases().back();
}
GradientCase twistedTorus() {
    for (const GradientCase &c : gradientCases())
        if (c.name == "twist on torus") return c;
    return gradientCases().front();
}

double rmsOver(const std::vector<GradientCase> &cases, const std::function<double(const GradientCase &)> &error) {
    double sum = 0;
    for (const GradientCase &c : cases) sum += sqr(error(c));
    return std::sqrt(sum / static_cast<double>(cases.size()));
}

const Axis kTimeAxis{"deformation, gradient and V", "ns a vertex"};
const Axis kTensorAxis{"RMS error of V, relative", ""};
const Axis kImageAxis{"RMS error of the image, relative", ""};

/// Time a vertex of each estimator on a case, n x n quads.
std::vector<Measured> timesOnMesh(const GradientCase &c, int n, int rounds) {
    std::vector<std::unique_ptr<VertexStretches>> runs;
    std::vector<std::function<void()>> rows;
    for (const GradientEstimator e : kOfMeshes) {
        runs.push_back(std::make_unique<VertexStretches>(c, e, n));
        rows.emplace_back([run = runs.back().get()] { run->evaluate(); });
    }
    std::vector<Measured> times = timeOnOneThread(rows, rounds);
    for (Measured &t : times) t = t * (1e9 / sqr(n + 1.0));
    return times;
}

Panel meshPanel(const std::string &name, const std::string &title, const std::vector<GradientCase> &cases, const GradientCase &timed,
                int rounds) {
    constexpr int kError = 64;
    constexpr int kTimed = 256;
    Panel panel{name, title, "", kTimeAxis, kTensorAxis, {}};
    panel.conditions = "error: " + std::to_string(cases.size()) + (cases.size() == 1 ? " closed form" : " closed forms") +
                       " on 64 x 64 quads, borders left out; time: " + timed.name + ", 256 x 256 quads, one thread";
    const std::vector<Measured> times = timesOnMesh(timed, kTimed, rounds);
    for (std::size_t i = 0; i < times.size(); ++i) {
        const GradientEstimator e = kOfMeshes[i];
        const double error = rmsOver(cases, [&](const GradientCase &c) { return estimatorError(c, e, kError).rms; });
        panel.points.push_back({nameOf(e), "", times[i], {error, 0, 1}, e == chosenFor(0)});
    }
    return panel;
}

Panel limitPanel(int rounds) {
    Panel panel{"limit", "Limit surfaces under deformers", "", kTimeAxis, kTensorAxis, {}};
    panel.conditions = "error: 16 closed forms, cages of 16 x 16 quads, 3 levels, against derivatives of B-splines; time: twist on torus, "
                       "cage of 32 x 32 quads, 3 levels, one thread";
    std::vector<std::unique_ptr<LimitStretches>> runs;
    std::vector<std::function<void()>> rows;
    for (const GradientEstimator e : kOfLimits) {
        runs.push_back(std::make_unique<LimitStretches>(twistedTorus(), e, 32, 3));
        rows.emplace_back([run = runs.back().get()] { run->evaluate(); });
    }
    const std::vector<Measured> times = timeOnOneThread(rows, rounds);
    for (std::size_t i = 0; i < times.size(); ++i) {
        const GradientEstimator e = kOfLimits[i];
        const double error = rmsOver(deformerCases(), [&](const GradientCase &c) {
            LimitStretches run(c, e, 16, 3);
            run.evaluate();
            return run.error().rms;
        });
        const Measured time = times[i] * (1e9 / static_cast<double>(runs[i]->vertexCount()));
        panel.points.push_back({nameOf(e), "", time, {error, 0, 1}, e == chosenFor(3)});
    }
    return panel;
}

Panel convergencePanel() {
    Panel panel{"convergence", "Error of V as meshes are refined", "", {"quads along a side", ""}, kTensorAxis, {}};
    panel.conditions = "RMS over 16 closed forms";
    panel.hasFront = false;
    panel.joined = true;
    panel.labelled = false;
    for (const GradientEstimator e : kOfMeshes)
        for (const int n : {8, 16, 32, 64}) {
            const double error = rmsOver(deformerCases(), [&](const GradientCase &c) { return estimatorError(c, e, n).rms; });
            panel.points.push_back({nameOf(e), std::to_string(n), {static_cast<double>(n)}, {error}, e == chosenFor(0)});
        }
    return panel;
}

/// The study scene with a torus twisted about x and waved: `quads` around, half of that across.
Scene twistedScene(int quads, int level) {
    Object torus = objectOf(makeTorus(quads, quads / 2, 0.7F, 0.3F));
    torus.deformers = {constantDeformer(DeformerType::Twist, 1.1, 0, 2), constantDeformer(DeformerType::Wave, 0.08, 1, 2)};
    torus.subdivision.level = level;
    return studyScene(std::move(torus), brushedMetal(0.1F, 0.3F), 96);
}

/// Image error of estimators on one scene against the same seen on a finer mesh, where only the tessellation is left to differ for a
/// perfect gradient. The same random numbers in both.
Panel imagePanel(const std::string &name, const std::string &title, const Scene &scene, const Scene &fine,
                 std::span<const GradientEstimator> estimators, int rounds, int seeds) {
    constexpr int kSpp = 64;
    Panel panel{name, title, "", kTimeAxis, kImageAxis, {}};
    panel.conditions = "twisted and waved brushed torus, 96 x 96 pixels, " + std::to_string(kSpp) +
                       " samples; reference: a finer mesh, the full model, the same random numbers; one thread";
    const auto planOf = [](const Scene &s, GradientEstimator e) {
        ScenePlan plan = fullPlan(s);
        plan.meshes[0].estimator = e;
        return plan;
    };
    std::vector<std::unique_ptr<RenderObject>> objects;
    std::vector<std::function<void()>> rows;
    double ignored = 0;
    for (const GradientEstimator e : estimators) {
        objects.push_back(std::make_unique<RenderObject>());
        prepareRenderObject(scene.objects[0], scene.render, planOf(scene, e).meshes[0], 1, true, *objects.back());
        rows.emplace_back([&, object = objects.back().get()] {
            for (int i = 0; i < 8; ++i) moveObject(*object, 0, 1, scene.render.fps, DMat4(1), ignored, ignored);
        });
    }
    const std::vector<Measured> times = timeOnOneThread(rows, rounds);
    std::vector<std::vector<double>> errors(estimators.size());
    for (int seed = 0; seed < seeds; ++seed) {
        const auto render = [&](const Scene &s, GradientEstimator e) {
            return renderImage(s, planOf(s, e), 1, kSpp, static_cast<std::uint32_t>(seed + 1)).values;
        };
        const std::vector<float> reference = render(fine, defaultEstimator(fine.objects[0]));
        for (std::size_t i = 0; i < estimators.size(); ++i) errors[i].push_back(relativeRms(render(scene, estimators[i]), reference));
    }
    for (std::size_t i = 0; i < estimators.size(); ++i) {
        const Measured time = times[i] * (1e9 / 8 / static_cast<double>(objects[i]->surface.vertexCount()));
        panel.points.push_back({nameOf(estimators[i]), "", time, medianOf(errors[i]), estimators[i] == defaultEstimator(scene.objects[0])});
    }
    return panel;
}

} // namespace

Chart measureGradient(const ChartOptions &options) {
    const bool quick = options.effort == Effort::Quick;
    const int rounds = quick ? 15 : 101;
    const int seeds = quick ? 3 : 9;
    Chart chart;
    chart.name = "gradient";
    chart.title = "Estimators of the surface gradient";
    chart.compared =
        "Ways to get the stretch V of a deformed surface: carried through skin and deformers (analytic), as derivatives of the "
        "limit surface (limit), from final positions as the mean of the faces around a vertex by area or angle or as the linear "
        "map that fits its neighbours best, and constant on each face. The truth is a closed form: deformers' Jacobians on a "
        "plane, cylinder, sphere and torus; derivatives of the B-spline that a regular cage has for its limit; for images, the "
        "same deformation of a mesh of 16 times as many faces.";
    chart.howToRead =
        "Down is more exact, left is faster. Time is all that a frame does for V: positions, gradient, normals. The plot of "
        "convergence has the number of quads along a side instead: first order for face, second for the fits, and analytic at "
        "the rounding of floats.";
    chart.panels.push_back(meshPanel("deformers", "Meshes under deformers", deformerCases(), twistedTorus(), rounds));
    chart.panels.push_back(meshPanel("skin", "A skinned mesh", {skinnedCase()}, skinnedCase(), rounds));
    chart.panels.push_back(limitPanel(rounds));
    chart.panels.push_back(convergencePanel());
    chart.panels.push_back(imagePanel("image", "Images of a mesh", twistedScene(96, 0), twistedScene(384, 0), kOfMeshes, rounds, seeds));
    chart.panels.push_back(
        imagePanel("image-limit", "Images of a limit surface", twistedScene(32, 2), twistedScene(32, 4), kOfLimits, rounds, seeds));
    const auto against = [](const Panel &panel, GradientEstimator ours) {
        const Point &chosen = pointOf(panel, nameOf(ours));
        const Point &fit = pointOf(panel, nameOf(GradientEstimator::Area));
        return nameOf(ours) + " takes " + digits(chosen.x.value / fit.x.value, 2) +
               " of the area fit's time, at an error of " + digits(chosen.y.value, 2) + " against " + digits(fit.y.value, 2);
    };
    chart.choice =
        "Default: " + nameOf(chosenFor(0)) + " for meshes, " + nameOf(chosenFor(1)) +
        " for subdivided ones. Under deformers " + against(chart.panels[0], chosenFor(0)) + "; on limit surfaces " +
        against(chart.panels[2], chosenFor(1)) +
        ", for one pass over its rows gives positions and derivatives. With a skin the derivative of the weights is a fit's, and the "
        "error is of second order. Fits serve where points move without a formula: morphs, sequences, caches.";
    return chart;
}

} // namespace taut::chart
