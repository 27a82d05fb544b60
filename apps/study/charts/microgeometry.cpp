/// Explicit micro-geometry against M: its normals counted, and its highlight rendered facet by facet.

#include "study/charts.h"
#include "study/drawing/pictures.h"
#include "study/measures/image_error.h"
#include "study/measures/timing.h"
#include "study/microsurface/micro_geometry.h"
#include "study/scenes/facet_highlight.h"
#include "study/text.h"

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

Mesh deformedHeightfield(std::size_t facets, std::uint32_t seed, const MicroTransform &m) {
    Mesh mesh = makeGgxHeightfield(facets, seed);
    deformPositions(mesh, deformersOf(m));
    return mesh;
}

std::string labelOf(std::size_t facets) {
    return count(static_cast<double>(facets));
}

/// Counting takes time and leaves an error; the closed form is the other choice.
Panel histogramPanel(const Deformation &deformation, const std::vector<std::size_t> &facets, int rounds) {
    const MicroTransform m = deformation.m();
    Panel panel{
        std::string("normals_") + deformation.name,
        std::string("Normals, ") + deformation.title,
        "Heightfields of real facets whose normals are those of alpha = 1, deformed as a mesh is, normals counted by projected area in " +
            std::to_string(kBins) + " x " + std::to_string(kBins) +
            " cells. Time of making, deforming and counting, or of the closed form in all cells, one thread; error: total variation from "
            "D_M cos.",
        {"time", "s"},
        {"total variation", ""},
        {}};
    panel.joined = true;
    const NormalHistogram expected = expectedNormals(m, kBins);
    std::vector<Choice> choices{
        {"M, closed form", "", true, [&](std::uint32_t) { return totalVariation(expectedNormals(m, kBins), expected); }}};
    for (const std::size_t each : facets)
        choices.push_back({"facets, counted", labelOf(each), false, [&, each](std::uint32_t seed) {
                               return totalVariation(countNormals(deformedHeightfield(each, seed, m), kBins), expected);
                           }});
    panel.points = timeChoices(choices, rounds, Threads::One);
    return panel;
}

/// Counted beside closed, as the talk draws it.
Picture histogramPicture(const Deformation &deformation, std::size_t facets, const std::filesystem::path &directory) {
    const Mesh mesh = deformedHeightfield(facets, 1, deformation.m());
    const NormalImage painted = paintNormals(mesh, deformation.m(), 256);
    return writeStrip(directory, std::string("microgeometry_normals_") + deformation.name + "_disk",
                      std::string("Normals on the disk (n.x, n.y), ") + deformation.title + ": left counted on " +
                          labelOf(mesh.faceCount()) + " facets, right D_M cos.",
                      {painted.rgb}, painted.width, 1);
}

constexpr int kBlock = 2; ///< pixels that are averaged before pictures are compared

/// One highlight from facets and from M, light of one bounce or of all.
void addHighlight(Chart &chart, const Deformation &deformation, const std::vector<std::size_t> &facets, bool allBounces,
                  const ChartOptions &options) {
    const int samples = options.pick(256, 4096);
    const MicroTransform m = deformation.m();
    const auto patch = [&](std::size_t count, std::uint32_t seed) { return FacetPatch(deformedHeightfield(count, seed, m), m); };
    const std::size_t most = facets.back() * 4;
    const Pixels truth = patch(most, 100).render(4 * samples, allBounces, 100);
    const auto errorOf = [&](const Pixels &image) {
        return relativeRms(blockMeans(image, kHighlightSize, kBlock), blockMeans(truth, kHighlightSize, kBlock));
    };
    Panel panel{std::string(allBounces ? "highlight_all_" : "highlight_") + deformation.name,
                std::string(allBounces ? "Highlight, all bounces, " : "Highlight, one bounce, ") + deformation.title,
                "A plate of 24 x 24 pixels, each a whole patch seen from where it is; " + std::to_string(samples) +
                    " samples a pixel, compared as means of 2 x 2 pixels with a patch of " + labelOf(most) +
                    " other facets at 4 times the samples. M: " + (allBounces ? "the random walk." : "single scattering.") +
                    " Time: making, deforming, BVH and picture.",
                {"time", "s"},
                {"relative RMS difference", ""},
                {}};
    panel.joined = true;
    Pixels fromM;
    std::vector<Choice> choices{{"M", "", true, [&](std::uint32_t seed) {
                                     fromM = renderMicrosurface(m, samples, allBounces, seed);
                                     return errorOf(fromM);
                                 }}};
    for (const std::size_t each : facets)
        choices.push_back({"facets", labelOf(each), false,
                           [&, each](std::uint32_t seed) { return errorOf(patch(each, seed).render(samples, allBounces, seed)); }});
    panel.points = timeChoices(choices, options.pick(5, 9), Threads::All);
    chart.pictures.push_back(
        writeStrip(options.directory, "microgeometry_" + panel.name + "_picture",
                   panel.title + ". From left: " + labelOf(most) + " facets traced one by one; M; their difference times 2.",
                   {truth, fromM, difference(truth, fromM, 2)}, kHighlightSize, exposureOf(truth), 10));
    chart.panels.push_back(std::move(panel));
}

} // namespace

Chart measureMicrogeometry(const ChartOptions &options) {
    Chart chart{"microgeometry", "Real facets against M",
                "A heightfield of real facets whose normals are those of GGX at alpha 1 is deformed like any mesh. Its normals are "
                "counted and set beside D_M cos; and it is rendered, mirror by mirror, beside a flat plate whose microsurface M "
                "follows the same deformation. Nothing of M enters the truth.",
                "Left is faster, down is nearer to the closed form, or to a picture of more facets of another heightfield.",
                "M: its normals are those that facets converge to, at once and without noise, and its highlight lies where theirs does, "
                "as long and as skewed. What is left between the pictures is the noise of both and the masking: Smith's takes heights "
                "and slopes for independent, which those of a heightfield are not quite."};
    const std::vector<std::size_t> facets = options.effort == Effort::Quick ? std::vector<std::size_t>{50000, 100000, 250000}
                                                                            : std::vector<std::size_t>{10000, 100000, 1000000, 4000000};
    for (const Deformation &deformation : kDeformations) {
        chart.panels.push_back(histogramPanel(deformation, facets, options.pick(15, 31)));
        chart.pictures.push_back(
            histogramPicture(deformation, static_cast<std::size_t>(options.pick(1000000, 10000000)), options.directory));
        addHighlight(chart, deformation, facets, false, options);
    }
    addHighlight(chart, kDeformations[1], facets, true, options);
    return chart;
}

} // namespace taut::chart
