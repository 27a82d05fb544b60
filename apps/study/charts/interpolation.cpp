/// taut chart interpolation: schemes of interpolation of the surface gradient, time a hit against the error of V and of the image.

#include "study/charts.h"
#include "study/measures/gradient_error.h"
#include "study/measures/render_image.h"
#include "study/measures/timing.h"
#include "study/scenes/scenes.h"
#include "study/text.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>

namespace taut::chart {

namespace {

constexpr GradientInterpolation kSchemes[] = {GradientInterpolation::Face, GradientInterpolation::Stretch, GradientInterpolation::DsDt,
                                              GradientInterpolation::Cholesky, GradientInterpolation::LogEuclidean};

bool isDefault(GradientInterpolation scheme) {
    return scheme == MeshPlan{}.interpolation;
}

const Axis kHitAxis{"V at a hit, from what is stored", "ns"};
const Axis kStretchAxis{"RMS error of V, relative", ""};
const Axis kPictureAxis{"RMS error of the image, relative", ""};
/// Triangles of the timed mesh: 2 kTimed^2, within the caches, as neighbouring hits find them.
constexpr int kTimed = 64;

/// Every scheme with its time a hit; errors are still to be filled in.
std::vector<Point> timesOfHits(int rounds) {
    const std::vector<GradientCase> cases = gradientCases();
    const GradientCase &timed = *std::find_if(cases.begin(), cases.end(), [](const GradientCase &c) { return c.name == "twist on torus"; });
    constexpr int kRepeats = 8;
    std::vector<Choice> choices;
    for (const GradientInterpolation scheme : kSchemes)
        choices.push_back(
            {nameOf(scheme), "", isDefault(scheme), [run = std::make_shared<HitStretches>(timed, scheme, kTimed)](std::uint32_t) {
                 for (int i = 0; i < kRepeats; ++i) run->evaluate();
                 return 0.0;
             }});
    return timeChoices(choices, rounds, Threads::One, 1e-9 * kRepeats * 2.0 * kTimed * kTimed);
}

std::vector<GradientCase> casesOn(bool flat) {
    std::vector<GradientCase> cases;
    for (const GradientCase &c : gradientCases())
        if ((c.shape == Shape::Plane) == flat) cases.push_back(c);
    return cases;
}

double rmsOver(const std::vector<GradientCase> &cases, GradientInterpolation scheme, int n) {
    double sum = 0;
    for (const GradientCase &c : cases) sum += sqr(interpolationError(c, scheme, n).rms);
    return std::sqrt(sum / static_cast<double>(cases.size()));
}

Panel tensorPanel(bool flat, std::vector<Point> points) {
    const std::vector<GradientCase> cases = casesOn(flat);
    for (std::size_t i = 0; i < points.size(); ++i) points[i].y = {rmsOver(cases, kSchemes[i], 32)};
    return {flat ? "plane" : "curved",
            flat ? "Plane: the corners' rest frames agree" : "Curved surfaces: the corners' rest frames differ",
            "error: " + std::to_string(cases.size()) +
                " closed forms, 32 x 32 quads, a point inside every triangle; time: one thread, 8192 triangles in turn",
            kHitAxis,
            kStretchAxis,
            std::move(points)};
}

Panel refinementPanel() {
    Panel panel = lines({"convergence",
                         "Error of V as meshes are refined",
                         "RMS over the closed forms on curved surfaces",
                         {"quads along a side", ""},
                         kStretchAxis,
                         {}});
    for (const GradientInterpolation scheme : kSchemes)
        for (const int n : {4, 8, 16, 32, 64})
            panel.points.push_back(
                {nameOf(scheme), std::to_string(n), {static_cast<double>(n)}, {rmsOver(casesOn(false), scheme, n)}, isDefault(scheme)});
    return panel;
}

/// A plate whose points are pushed along it, x by a wave over y: strongly stretched and sheared, flat all the while; or a torus.
Scene wavedScene(bool flat, int quads) {
    Object object = objectOf(flat ? makeGrid(quads, quads, 1.7F) : makeTorus(quads, quads / 2, 0.7F, 0.3F));
    object.deformers = {deformer(DeformerType::Wave, 0.12, 1, 0)};
    return studyScene(std::move(object), brushedMetal(0.1F, 0.3F), 64);
}

/// The reference is seen on a mesh so fine that schemes agree; normals of the coarse one are its own.
Panel imagePanel(bool flat, std::vector<Point> points, int seeds) {
    constexpr int kSpp = 256;
    const Scene coarse = wavedScene(flat, flat ? 12 : 96);
    const Scene fine = wavedScene(flat, flat ? 192 : 384);
    const auto renderer = [](const Scene &scene, GradientInterpolation scheme) {
        return ImageOf([&scene, scheme](std::uint32_t seed) {
            ScenePlan plan = fullPlan(scene);
            plan.meshes[0].interpolation = scheme;
            return renderImage(scene, std::move(plan), 1, kSpp, seed).values;
        });
    };
    std::vector<ImageOf> ways;
    for (const GradientInterpolation scheme : kSchemes) ways.push_back(renderer(coarse, scheme));
    const std::vector<Measured> errors = imageErrors(ways, renderer(fine, MeshPlan{}.interpolation), seeds);
    for (std::size_t i = 0; i < points.size(); ++i) points[i].y = errors[i];
    return {flat ? "image-plane" : "image-curved",
            flat ? "Images of a plate waved in its plane" : "Images of a waved torus",
            (flat ? "12 x 12 quads; reference: 192 x 192" : "96 x 48 quads; reference: 384 x 192") +
                std::string(", the same random numbers; 64 x 64 pixels, 256 samples"),
            kHitAxis,
            kPictureAxis,
            std::move(points)};
}

} // namespace

Chart measureInterpolation(const ChartOptions &options) {
    Chart chart{
        "interpolation", "Interpolation of the surface gradient",
        "What is stored at the corners of a triangle, and how the stretch V is had at a hit between them: V itself, the "
        "vectors ds and dt, the Cholesky factor of V V, the logarithm of V, and one V for each face. Corners hold exact "
        "values. The truth is a closed form; for images, the same deformation of a mesh so fine that the schemes agree.",
        "Down is more exact, left is faster. Images of the plate differ by V alone; those of the torus by the normals of the coarse mesh "
        "as well, which no scheme mends. V, its logarithm and the Cholesky factor lie on one another in the plot of refined meshes."};
    const std::vector<Point> times = timesOfHits(options.pick(25, 201));
    const int seeds = options.pick(3, 9);
    chart.panels = {tensorPanel(true, times), tensorPanel(false, times), refinementPanel(), imagePanel(true, times, seeds),
                    imagePanel(false, times, seeds)};
    const std::string ours = nameOf(MeshPlan{}.interpolation);
    const auto error = [&](std::size_t panel, const std::string &series) { return pointOf(chart.panels[panel], series).y.value; };
    const std::string vectors = nameOf(GradientInterpolation::DsDt);
    chart.choice = "Default: " + ours + ", at " + digits(pointOf(chart.panels[0], ours).x.value) +
                   " ns the quickest scheme of second order. Where rest frames agree, ds and dt are as good or better (" +
                   digits(error(0, vectors), 2) + " against " + digits(error(0, ours), 2) + "); on curved meshes they are not (" +
                   digits(error(1, vectors), 2) + " against " + digits(error(1, ours), 2) +
                   "), and only schemes without the rest frame leave a curved mesh's gloss alone where nothing is deformed.";
    return chart;
}

} // namespace taut::chart
