/// taut chart mesostructure: mapped facets that lean beside bent normals and real facets; moments beside the map, over distance.

#include "study/charts.h"
#include "study/measures/render_image.h"
#include "study/measures/timing.h"
#include "study/scenes/relief.h"
#include "study/text.h"

#include <fmt/format.h>

#include <memory>

namespace taut::chart {

namespace {

constexpr float kAlpha = 0.2F;
const Axis kFrameAxis{"time of a frame", "s"};
const Axis kErrorAxis{"mean squared error over the mean square", ""};

struct Motion {
    const char *name, *title;
    DVec3 factor;
    double shear;
};
constexpr Motion kMotions[] = {{"stretched", "stretched by 1.8 and 0.8", {1.8, 0.8, 1}, 0},
                               {"thinned", "stretched by 1.5, thinned by 0.7", {1.5, 1, 0.7}, 0},
                               {"sheared", "sheared by 0.6", {1, 1, 1}, 0.6}};

std::vector<DeformerKeys> deformersOf(const Motion &motion) {
    DeformerKeys stretch;
    stretch.type = DeformerType::Stretch;
    stretch.factor = motion.factor;
    DeformerKeys shear;
    shear.type = DeformerType::Shear;
    shear.axis = 0;
    shear.axis2 = 1;
    shear.amount = motion.shear;
    return {stretch, shear};
}

double relativeSquare(const std::vector<float> &image, const std::vector<float> &truth) {
    double error = 0;
    double power = 0;
    for (std::size_t i = 0; i < image.size(); ++i) {
        error += sqr(static_cast<double>(image[i]) - static_cast<double>(truth[i]));
        power += sqr(static_cast<double>(truth[i]));
    }
    return error / power;
}

/// Brought to its frame once.
std::shared_ptr<RenderScene> ready(const Scene &scene) {
    auto made = std::make_shared<RenderScene>(scene, false);
    made->setFrame(1);
    return made;
}

/// Facets that lean, normals that bend and real facets, all against real facets of other random numbers.
Panel nearPanel(const Motion &motion, const ChartOptions &options) {
    const Relief relief;
    const int size = options.pick(64, 128);
    const auto real = ready(reliefScene(reliefMesh(relief, options.pick(724, 1024)), deformersOf(motion), kAlpha, size));
    const std::vector<float> truth = renderReady(*real, options.pick(1024, 8192), 1000).values;
    Panel panel{std::string("near_") + motion.name,
                std::string("Near, ") + motion.title,
                fmt::format("Crossed waves with slopes to {}, alpha {}, under the studio's lights, seen from above; truth: {} real facets.",
                            relief.steep, kAlpha, real->objects()[0].surface.triangles.size()),
                kFrameAxis,
                kErrorAxis,
                {}};
    panel.joined = true;
    std::vector<Choice> choices;
    const auto add = [&](const char *series, std::shared_ptr<RenderScene> scene, bool isDefault) {
        for (const int spp : {16, 64, 256})
            choices.push_back({series, std::to_string(spp) + " samples", isDefault && spp == 64,
                               [=, &truth](std::uint32_t seed) { return relativeSquare(renderReady(*scene, spp, seed).values, truth); }});
    };
    Scene mapped = mappedReliefScene(relief, deformersOf(motion), kAlpha, size);
    add("facets lean", ready(mapped), true);
    mapped.materials[0].facets = FacetModel::Bends;
    add("normals bend", ready(mapped), false);
    add("real facets", real, false);
    mapped.materials[0].slopes = {};
    add("no map", ready(mapped), false);
    panel.points = timeChoices(choices, options.pick(3, 7), Threads::All);
    return panel;
}

/// The map and its moments as the camera draws back: `waves` waves of the relief on the plate.
Panel farPanel(int waves, const ChartOptions &options) {
    const Relief relief{waves, 0.25F};
    const int size = options.pick(32, 64);
    Scene scene = mappedReliefScene(relief, deformersOf(kMotions[0]), kAlpha, size);
    const auto map = ready(scene);
    scene.materials[0].detail = TextureDetail::Moments;
    const auto moments = ready(scene);
    const std::vector<float> truth = renderReady(*map, options.pick(8192, 65536), 1000).values;
    const double pixels = 1.2 / size / (2.0 * kMotions[0].factor.x / waves);
    Panel panel{fmt::format("far_{}", waves),
                fmt::format("Far: {:.2g} waves in a pixel", pixels),
                "As above, stretched; truth: the map at many samples. What moments are off by however many samples: their fit.",
                kFrameAxis,
                kErrorAxis,
                {}};
    panel.joined = true;
    std::vector<Choice> choices;
    for (const int spp : {1, 4, 16, 64, 256})
        for (const bool far : {false, true})
            choices.push_back(
                {far ? "moments" : "map", std::to_string(spp) + " samples", !far && spp == 64,
                 [=, &truth](std::uint32_t seed) { return relativeSquare(renderReady(far ? *moments : *map, spp, seed).values, truth); }});
    panel.points = timeChoices(choices, options.pick(3, 7), Threads::All);
    std::stable_sort(panel.points.begin(), panel.points.end(), [](const Point &a, const Point &b) { return a.series < b.series; });
    return panel;
}

/// What a map costs, per frame and hit.
Table costTable(const ChartOptions &options) {
    const int size = options.pick(128, 256);
    const int spp = 64;
    Scene scene = mappedReliefScene({}, deformersOf(kMotions[0]), kAlpha, size);
    std::vector<std::shared_ptr<RenderScene>> scenes{ready(scene)};
    scene.materials[0].detail = TextureDetail::Moments;
    scenes.push_back(ready(scene));
    scene.materials[0].slopes = {};
    scenes.push_back(ready(scene));
    std::vector<std::function<void()>> rows;
    for (const auto &each : scenes) rows.emplace_back([=] { renderReady(*each, spp, 1); });
    const std::vector<Measured> seconds = timeOnOneThread(rows, options.pick(3, 9));
    Table table{
        "cost", "Cost of a map: a frame of one event a path on a plate that leans, one thread", {"surface", "s a frame", "ns a hit"}};
    const char *names[] = {"mapped", "mapped, moments", "unmapped"};
    for (std::size_t i = 0; i < scenes.size(); ++i)
        table.rows.push_back({names[i], fmt::format("{:.3g}", seconds[i].value),
                              fmt::format("{:.0f}", 1e9 * seconds[i].value / (static_cast<double>(size) * size * spp))});
    return table;
}

} // namespace

Chart measureMesostructure(const ChartOptions &options) {
    Chart chart;
    chart.name = "mesostructure";
    chart.title = "Mesostructure";
    chart.compared = "A normal map on a deformed plate: facets that lean with the deformation, normals that bend while the gloss stays the "
                     "mesh's, and the relief itself as a million real facets, which is the truth. From afar: moments of the map's slopes "
                     "against the map.";
    chart.howToRead = "Lines join numbers of samples: they fall as noise does, until what remains is the model's own error.";
    chart.choice = "Facets lean: their line follows that of the real facets. The map is the default from afar, because its error goes away "
                   "with samples; moments pay off at few, and where a tolerance allows their fit.";
    for (const Motion &motion : kMotions) chart.panels.push_back(nearPanel(motion, options));
    for (const int waves : {16, 64}) chart.panels.push_back(farPanel(waves, options));
    chart.tables.push_back(costTable(options));
    return chart;
}

} // namespace taut::chart
