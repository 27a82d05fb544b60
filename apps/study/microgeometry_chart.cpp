/// Explicit micro-geometry against M: its normals counted, and its highlight rendered facet by facet.

#include "study/charts.h"
#include "study/facet_highlight.h"
#include "study/pictures.h"
#include "study/render_image.h"
#include "study/text.h"
#include "study/timing.h"

#include "study/micro_geometry.h"
#include "taut/render/image_file.h"

namespace taut::chart {

namespace {

/// A deformation of the plane, [a b; 0 d], of a microsurface of alpha 1.
struct Deformation {
    const char *name, *title;
    float a, b, d;
    [[nodiscard]] MicroTransform m() const { return microTransform(a, b, 0, d); }
};
constexpr Deformation kDeformations[] = {{"stretched", "stretched, M = [3 0; 0 1]", 3, 0, 1},
                                         {"sheared", "sheared, M = [2 3; 0 2]", 2, 3, 2}};

constexpr int kBins = 32;

/// Counting takes time and leaves an error; the closed form is the other choice.
void addHistogram(Chart &chart, const Deformation &deformation, const std::vector<std::size_t> &facets, int rounds) {
    const MicroTransform m = deformation.m();
    Panel panel;
    panel.name = std::string("normals_") + deformation.name;
    panel.title = std::string("Normals, ") + deformation.title;
    panel.conditions =
        "Heightfields of real facets whose normals are those of alpha = 1, deformed as a mesh is, normals counted by projected area in " +
        std::to_string(kBins) + " x " + std::to_string(kBins) +
        " cells. Time of making, deforming and counting, or of the closed form in all cells, one thread; error: total variation from D_M "
        "cos.";
    panel.x = {"time", "s"};
    panel.y = {"total variation", ""};
    panel.joined = true;
    const NormalHistogram expected = expectedNormals(m, kBins);
    std::vector<std::function<void()>> runs;
    std::vector<std::vector<double>> errors(facets.size());
    NormalHistogram closed;
    runs.emplace_back([&] { closed = expectedNormals(m, kBins); });
    for (std::size_t i = 0; i < facets.size(); ++i)
        runs.emplace_back([&, i] {
            // Another heightfield every round.
            Mesh mesh = makeGgxHeightfield(facets[i], static_cast<std::uint32_t>(errors[i].size() + 1));
            deformPositions(mesh, deformersOf(m));
            errors[i].push_back(totalVariation(countNormals(mesh, kBins), expected));
        });
    const std::vector<Measured> seconds = timeOnOneThread(runs, rounds);
    panel.points.push_back({"M, closed form", "", seconds[0], {totalVariation(closed, expected), 0, 1}, true});
    for (std::size_t i = 0; i < facets.size(); ++i)
        panel.points.push_back({"facets, counted", count(static_cast<double>(facets[i])), seconds[i + 1], medianOf(errors[i])});
    chart.panels.push_back(std::move(panel));
}

/// Counted beside closed, as the talk draws it.
void addHistogramPicture(Chart &chart, const Deformation &deformation, std::size_t facets, const std::filesystem::path &directory) {
    Mesh mesh = makeGgxHeightfield(facets, 1);
    deformPositions(mesh, deformersOf(deformation.m()));
    const NormalImage painted = paintNormals(mesh, deformation.m(), 256);
    const std::filesystem::path file = directory / (std::string("microgeometry_normals_") + deformation.name + "_disk.png");
    writeImage(file.string(), {{0, 0, painted.width, painted.height}, painted.width, painted.height, {"R", "G", "B"}, painted.rgb}, {});
    chart.pictures.push_back({std::string("Normals on the disk (n.x, n.y), ") + deformation.title + ": left counted on " +
                                  count(static_cast<double>(mesh.faceCount())) + " facets, right D_M cos.",
                              file});
}

constexpr int kBlock = 2; ///< pixels that are averaged before pictures are compared

/// The same highlight from facets and from M, light of one bounce or of all.
void addHighlight(Chart &chart, const Deformation &deformation, const std::vector<std::size_t> &facets, bool allBounces,
                  const ChartOptions &options) {
    const bool quick = options.effort == Effort::Quick;
    const int samples = quick ? 256 : 4096;
    const MicroTransform m = deformation.m();
    const auto patchOf = [&](std::size_t count, std::uint32_t seed) {
        Mesh mesh = makeGgxHeightfield(count, seed);
        deformPositions(mesh, deformersOf(m));
        return FacetPatch(mesh, m);
    };
    const auto filtered = [](const Pixels &image) { return blockMeans(image, kHighlightSize, kBlock); };
    const std::size_t most = facets.back() * 4;
    const Pixels truth = patchOf(most, 100).render(4 * samples, allBounces, 100);
    Panel panel;
    panel.name = std::string(allBounces ? "highlight_all_" : "highlight_") + deformation.name;
    panel.title = std::string(allBounces ? "Highlight, all bounces, " : "Highlight, one bounce, ") + deformation.title;
    panel.conditions = "A plate of 24 x 24 pixels, each a whole patch seen from where it is; " + std::to_string(samples) +
                       " samples a pixel, compared as means of 2 x 2 pixels with a patch of " + count(static_cast<double>(most)) +
                       " other facets at 4 times the samples. M: " + (allBounces ? "the random walk." : "single scattering.") +
                       " Time: making, deforming, BVH and picture.";
    panel.x = {"time", "s"};
    panel.y = {"relative RMS difference", ""};
    panel.joined = true;
    Pixels fromM;
    std::vector<std::function<void()>> runs;
    std::vector<std::vector<double>> errors(facets.size() + 1);
    const auto roundOf = [&](std::size_t i) { return static_cast<std::uint32_t>(errors[i].size() + 1); };
    runs.emplace_back([&] {
        fromM = renderMicrosurface(m, samples, allBounces, roundOf(0));
        errors[0].push_back(relativeRms(filtered(fromM), filtered(truth)));
    });
    for (std::size_t i = 0; i < facets.size(); ++i)
        runs.emplace_back([&, i] {
            const Pixels explicitly = patchOf(facets[i], roundOf(i + 1)).render(samples, allBounces, roundOf(i + 1));
            errors[i + 1].push_back(relativeRms(filtered(explicitly), filtered(truth)));
        });
    const std::vector<Measured> seconds = timeInterleaved(runs, quick ? 5 : 9);
    panel.points.push_back({"M", "", seconds[0], medianOf(errors[0]), true});
    for (std::size_t i = 0; i < facets.size(); ++i)
        panel.points.push_back({"facets", count(static_cast<double>(facets[i])), seconds[i + 1], medianOf(errors[i + 1])});
    chart.pictures.push_back(writeStrip(options.directory, "microgeometry_" + panel.name + "_picture",
                                        panel.title + ". From left: " + count(static_cast<double>(most)) +
                                            " facets traced one by one; M; their difference times 2.",
                                        {truth, fromM, difference(truth, fromM, 2)}, kHighlightSize, exposureOf(truth), 10));
    chart.panels.push_back(std::move(panel));
}

} // namespace

Chart measureMicrogeometry(const ChartOptions &options) {
    const bool quick = options.effort == Effort::Quick;
    Chart chart;
    chart.name = "microgeometry";
    chart.title = "Real facets against M";
    chart.compared =
        "A heightfield of real facets whose normals are those of GGX at alpha 1 is deformed like any mesh. Its normals are counted and set "
        "beside "
        "D_M cos; and it is rendered, mirror by mirror, beside a flat plate whose microsurface M follows the same deformation. Nothing of "
        "M enters the truth.";
    chart.howToRead = "Left is faster, down is nearer to the closed form, or to a picture of more facets of another heightfield.";
    chart.choice = "M: its normals are those that facets converge to, at once and without noise, and its highlight lies where theirs does, "
                   "as long and as "
                   "skewed. What is left between the pictures is the noise of both and the masking: Smith's takes heights and slopes for "
                   "independent, which "
                   "those of a heightfield are not quite.";
    const std::vector<std::size_t> facets =
        quick ? std::vector<std::size_t>{50000, 100000, 250000} : std::vector<std::size_t>{10000, 100000, 1000000, 4000000};
    for (const Deformation &deformation : kDeformations) {
        addHistogram(chart, deformation, facets, quick ? 15 : 31);
        addHistogramPicture(chart, deformation, quick ? 1000000 : 10000000, options.directory);
        addHighlight(chart, deformation, facets, false, options);
    }
    addHighlight(chart, kDeformations[1], facets, true, options);
    return chart;
}

} // namespace taut::chart
