/// taut chart gradient: estimators of the surface gradient, time against the error of V and of the image.

#include "study/charts.h"
#include "study/measures/gradient_error.h"
#include "study/measures/render_image.h"
#include "study/measures/timing.h"
#include "study/scenes/scenes.h"
#include "study/text.h"

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
GradientCase twistOnTorus() {
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

/// Estimators that take turns on surfaces of their own, made by `make`, `repeats` frames each; time a vertex.
template <class Make>
std::vector<Point> timesOf(std::span<const GradientEstimator> estimators, GradientEstimator chosen, int rounds, int repeats,
                           const Make &make) {
    std::vector<Choice> choices;
    std::vector<double> vertices;
    for (const GradientEstimator e : estimators) {
        const auto run = std::shared_ptr(make(e));
        vertices.push_back(static_cast<double>(run->surface().vertexCount()));
        choices.push_back({nameOf(e), "", e == chosen, [run, repeats](std::uint32_t) {
                               for (int i = 0; i < repeats; ++i) run->evaluate();
                               return 0.0;
                           }});
    }
    std::vector<Point> points = timeChoices(choices, rounds, Threads::One, 1e-9 * repeats);
    for (std::size_t i = 0; i < points.size(); ++i) points[i].x = points[i].x * (1 / vertices[i]);
    return points;
}

Panel meshPanel(const std::string &name, const std::string &title, const std::vector<GradientCase> &cases, const GradientCase &timed,
                int rounds) {
    Panel panel{name, title, "", kTimeAxis, kTensorAxis, {}};
    panel.conditions = "error: " + std::to_string(cases.size()) + (cases.size() == 1 ? " closed form" : " closed forms") +
                       " on 64 x 64 quads, borders left out; time: " + timed.name + ", 256 x 256 quads, one thread";
    panel.points =
        timesOf(kOfMeshes, chosenFor(0), rounds, 1, [&](GradientEstimator e) { return std::make_unique<SurfaceStretches>(timed, e, 256); });
    for (std::size_t i = 0; i < panel.points.size(); ++i)
        panel.points[i].y = {rmsOver(cases, [&](const GradientCase &c) { return estimatorError(c, kOfMeshes[i], 64).rms; })};
    return panel;
}

Panel limitPanel(int rounds) {
    Panel panel{"limit", "Limit surfaces under deformers", "", kTimeAxis, kTensorAxis, {}};
    panel.conditions = "error: 16 closed forms, cages of 16 x 16 quads, 3 levels, against derivatives of B-splines; time: twist on torus, "
                       "cage of 32 x 32 quads, 3 levels, one thread";
    panel.points = timesOf(kOfLimits, chosenFor(3), rounds, 1,
                           [&](GradientEstimator e) { return std::make_unique<SurfaceStretches>(twistOnTorus(), e, 32, 3); });
    for (std::size_t i = 0; i < panel.points.size(); ++i)
        panel.points[i].y = {rmsOver(deformerCases(), [&](const GradientCase &c) { return estimatorError(c, kOfLimits[i], 16, 3).rms; })};
    return panel;
}

Panel convergencePanel() {
    Panel panel =
        lines({"convergence", "Error of V as meshes are refined", "RMS over 16 closed forms", {"quads along a side", ""}, kTensorAxis, {}});
    for (const GradientEstimator e : kOfMeshes)
        for (const int n : {8, 16, 32, 64}) {
            const double error = rmsOver(deformerCases(), [&](const GradientCase &c) { return estimatorError(c, e, n).rms; });
            panel.points.push_back({nameOf(e), std::to_string(n), {static_cast<double>(n)}, {error}, e == chosenFor(0)});
        }
    return panel;
}

/// The study scene with a torus twisted about x and waved: `quads` around, half of that across.
Scene twistedScene(int quads, int level) {
    Object torus = twistedTorus(makeTorus(quads, quads / 2, 0.7F, 0.3F), 1.1, 0.08);
    torus.subdivision.level = level;
    return studyScene(std::move(torus), brushedMetal(0.1F, 0.3F), 96);
}

ScenePlan planOf(const Scene &scene, GradientEstimator e) {
    ScenePlan plan = fullPlan(scene);
    plan.meshes[0].estimator = e;
    return plan;
}

/// An object that is brought to its frame.
class MovedObject {
  public:
    MovedObject(const Scene &scene, GradientEstimator e) : fps_(scene.render.fps) {
        prepareRenderObject(scene.objects[0], scene.render, planOf(scene, e).meshes[0], 1, true, object_);
    }
    void evaluate() {
        double ignored = 0;
        moveObject(object_, 0, 1, fps_, DMat4(1), ignored, ignored);
    }
    [[nodiscard]] const Surface &surface() const { return object_.surface; }

  private:
    double fps_;
    RenderObject object_;
};

/// Image error of estimators on one scene against the same seen on a finer mesh, where only the tessellation is left to differ for a
/// perfect gradient. The same random numbers in both.
Panel imagePanel(const std::string &name, const std::string &title, const Scene &scene, const Scene &fine,
                 std::span<const GradientEstimator> estimators, int rounds, int seeds) {
    constexpr int kSpp = 64;
    Panel panel{name, title, "", kTimeAxis, kImageAxis, {}};
    panel.conditions = "twisted and waved brushed torus, 96 x 96 pixels, " + std::to_string(kSpp) +
                       " samples; reference: a finer mesh, the full model, the same random numbers; one thread";
    panel.points = timesOf(estimators, defaultEstimator(scene.objects[0]), rounds, 8,
                           [&](GradientEstimator e) { return std::make_unique<MovedObject>(scene, e); });
    const auto renderer = [](const Scene &s, GradientEstimator e) {
        return ImageOf([&s, e](std::uint32_t seed) { return renderImage(s, planOf(s, e), 1, kSpp, seed).values; });
    };
    std::vector<ImageOf> ways;
    for (const GradientEstimator e : estimators) ways.push_back(renderer(scene, e));
    const std::vector<Measured> errors = imageErrors(ways, renderer(fine, defaultEstimator(fine.objects[0])), seeds);
    for (std::size_t i = 0; i < errors.size(); ++i) panel.points[i].y = errors[i];
    return panel;
}

} // namespace

Chart measureGradient(const ChartOptions &options) {
    const int rounds = options.pick(15, 101);
    const int seeds = options.pick(3, 9);
    Chart chart{
        "gradient", "Estimators of the surface gradient",
        "Ways to get the stretch V of a deformed surface: carried through skin and deformers (analytic), as derivatives of "
        "the limit surface (limit), from final positions as the mean of the faces around a vertex by area or angle or as the "
        "linear map that fits its neighbours best, and constant on each face. The truth is a closed form: deformers' "
        "Jacobians on a plane, cylinder, sphere and torus; derivatives of the B-spline that a regular cage has for its limit; "
        "for images, the same deformation of a mesh of 16 times as many faces.",
        "Down is more exact, left is faster. Time is all that a frame does for V: positions, gradient, normals. The plot of convergence "
        "has the number of quads along a side instead: first order for face, second for the fits, and analytic at the rounding of floats."};
    chart.panels.push_back(meshPanel("deformers", "Meshes under deformers", deformerCases(), twistOnTorus(), rounds));
    chart.panels.push_back(meshPanel("skin", "A skinned mesh", {skinnedCase()}, skinnedCase(), rounds));
    chart.panels.push_back(limitPanel(rounds));
    chart.panels.push_back(convergencePanel());
    chart.panels.push_back(imagePanel("image", "Images of a mesh", twistedScene(96, 0), twistedScene(384, 0), kOfMeshes, rounds, seeds));
    chart.panels.push_back(
        imagePanel("image-limit", "Images of a limit surface", twistedScene(32, 2), twistedScene(32, 4), kOfLimits, rounds, seeds));
    const auto against = [](const Panel &panel, GradientEstimator ours) {
        const Point chosen = pointOf(panel, nameOf(ours));
        const Point fit = pointOf(panel, nameOf(GradientEstimator::Area));
        return nameOf(ours) + " takes " + digits(chosen.x.value / fit.x.value, 2) + " of the area fit's time, at an error of " +
               digits(chosen.y.value, 2) + " against " + digits(fit.y.value, 2);
    };
    chart.choice = "Default: " + nameOf(chosenFor(0)) + " for meshes, " + nameOf(chosenFor(1)) + " for subdivided ones. Under deformers " +
                   against(chart.panels[0], chosenFor(0)) + "; on limit surfaces " + against(chart.panels[2], chosenFor(1)) +
                   ", for one pass over its rows gives positions and derivatives. With a skin the derivative of the weights is a fit's, "
                   "and the error is of second order. Fits serve where points move without a formula: morphs, sequences, caches.";
    return chart;
}

} // namespace taut::chart
