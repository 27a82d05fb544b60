/// taut chart interpolation: schemes of interpolation of the surface gradient, time a hit against the error of V and of the image.

#include "study/charts.h"
#include "study/gradient_error.h"
#include "study/render_image.h"
#include "study/text.h"
#include "study/timing.h"

#include "taut/mesh/shapes.h"

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

const Axis kTimeAxis{"V at a hit, from what is stored", "ns"};
const Axis kTensorAxis{"RMS error of V, relative", ""};
const Axis kImageAxis{"RMS error of the image, relative", ""};
/// Triangles of the timed mesh: 2 kTimed^2, within the caches, as neighbouring hits find them.
constexpr int kTimed = 64;

std::vector<Measured> timesOfHits(int rounds) {
    const std::vector<GradientCase> cases = gradientCases();
    const GradientCase &timed = *std::find_if(cases.begin(), cases.end(), [](const GradientCase &c) { return c.name == "twist on torus"; });
    constexpr int kRepeats = 8;
    std::vector<std::unique_ptr<HitStretches>> runs;
    std::vector<std::function<void()>> rows;
    for (const GradientInterpolation scheme : kSchemes) {
        runs.push_back(std::make_unique<HitStretches>(timed, scheme, kTimed));
        rows.emplace_back([run = runs.back().get()] {
            for (int i = 0; i < kRepeats; ++i) run->evaluate();
        });
    }
    std::vector<Measured> times = timeInterleaved(rows, rounds, Clock::Thread);
    for (Measured &t : times) t = t * (1e9 / kRepeats / (2.0 * kTimed * kTimed));
    return times;
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

Panel tensorPanel(bool flat, const std::vector<Measured> &times) {
    const std::vector<GradientCase> cases = casesOn(flat);
    constexpr int kQuads = 32;
    Panel panel{flat ? "plane" : "curved",
                flat ? "Plane: the corners' rest frames agree" : "Curved surfaces: the corners' rest frames differ",
                "",
                kTimeAxis,
                kTensorAxis,
                {}};
    panel.conditions = "error: " + std::to_string(cases.size()) +
                       " closed forms, 32 x 32 quads, a point inside every triangle; time: one thread, 8192 triangles in turn";
    for (std::size_t i = 0; i < times.size(); ++i)
        panel.points.push_back({nameOf(kSchemes[i]), "", times[i], {rmsOver(cases, kSchemes[i], kQuads)}, isDefault(kSchemes[i])});
    return panel;
}

Panel convergencePanel() {
    Panel panel{"convergence", "Error of V as meshes are refined", "", {"quads along a side", ""}, kTensorAxis, {}};
    panel.conditions = "RMS over the closed forms on curved surfaces";
    panel.hasFront = false;
    panel.joined = true;
    panel.labelled = false;
    for (const GradientInterpolation scheme : kSchemes)
        for (const int n : {4, 8, 16, 32, 64})
            panel.points.push_back(
                {nameOf(scheme), std::to_string(n), {static_cast<double>(n)}, {rmsOver(casesOn(false), scheme, n)}, isDefault(scheme)});
    return panel;
}

/// A plate whose points are pushed along it, x by a wave over y: strongly stretched and sheared, flat all the while.
Scene flatScene(int quads) {
    Object plate = objectOf(makeGrid(quads, quads, 1.7F));
    DeformerKeys wave = constantDeformer(DeformerType::Wave, 0.12, 1, 0);
    plate.deformers = {wave};
    return studyScene(std::move(plate), brushedMetal(0.1F, 0.3F), 64);
}
Scene curvedScene(int quads) {
    Object torus = objectOf(makeTorus(quads, quads / 2, 0.7F, 0.3F));
    torus.deformers = {constantDeformer(DeformerType::Wave, 0.12, 1, 0)};
    return studyScene(std::move(torus), brushedMetal(0.1F, 0.3F), 64);
}

/// The reference is seen on a mesh so fine that schemes agree; normals of the coarse one are its own.
Panel imagePanel(bool flat, const std::vector<Measured> &times, int seeds) {
    constexpr int kSpp = 256;
    Panel panel{flat ? "image-plane" : "image-curved",
                flat ? "Images of a plate waved in its plane" : "Images of a waved torus",
                "",
                kTimeAxis,
                kImageAxis,
                {}};
    const int quads = flat ? 12 : 96;
    panel.conditions = (flat ? "12 x 12 quads; reference: 192 x 192" : "96 x 48 quads; reference: 384 x 192") +
                       std::string(", the same random numbers; 64 x 64 pixels, 256 samples");
    const auto render = [&](const Scene &scene, GradientInterpolation scheme, int seed) {
        ScenePlan plan = fullPlan(scene);
        plan.meshes[0].interpolation = scheme;
        return renderImage(scene, std::move(plan), 1, kSpp, static_cast<std::uint32_t>(seed + 1)).values;
    };
    const Scene coarse = flat ? flatScene(quads) : curvedScene(quads);
    const Scene fine = flat ? flatScene(192) : curvedScene(384);
    std::vector<std::vector<double>> errors(times.size());
    for (int seed = 0; seed < seeds; ++seed) {
        const std::vector<float> reference = render(fine, MeshPlan{}.interpolation, seed);
        for (std::size_t i = 0; i < times.size(); ++i) errors[i].push_back(relativeRms(render(coarse, kSchemes[i], seed), reference));
    }
    for (std::size_t i = 0; i < times.size(); ++i)
        panel.points.push_back({nameOf(kSchemes[i]), "", times[i], medianOf(errors[i]), isDefault(kSchemes[i])});
    return panel;
}

} // namespace

Chart measureInterpolation(const ChartOptions &options) {
    const bool quick = options.effort == Effort::Quick;
    Chart chart;
    chart.name = "interpolation";
    chart.title = "Interpolation of the surface gradient";
    chart.compared =
        "What is stored at the corners of a triangle, and how the stretch V is had at a hit between them: V itself, the vectors "
        "ds and dt, the Cholesky factor of V V, the logarithm of V, and one V for each face. Corners hold exact values. The truth is "
        "a closed form; for images, the same deformation of a mesh so fine that the schemes agree.";
    chart.howToRead =
        "Down is more exact, left is faster. Images of the plate differ by V alone; those of the torus by the normals of the coarse "
        "mesh as well, which no scheme mends. V, its logarithm and the Cholesky factor lie on one another in the plot of refined meshes.";
    const std::vector<Measured> times = timesOfHits(quick ? 25 : 201);
    chart.panels.push_back(tensorPanel(true, times));
    chart.panels.push_back(tensorPanel(false, times));
    chart.panels.push_back(convergencePanel());
    chart.panels.push_back(imagePanel(true, times, quick ? 3 : 9));
    chart.panels.push_back(imagePanel(false, times, quick ? 3 : 9));
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
