#include "bench_chart.h"

#include "study/csv.h"
#include "study/plots.h"
#include "study/report.h"

#include "taut/base/error.h"
#include "taut/render/image_file.h"

#include <fmt/chrono.h>

#include <ctime>

namespace taut::bench {

namespace {

using namespace taut::chart;

/// A median with its quartiles; what has none is its own.
Measured measured(const nlohmann::json &scene, const char *name) {
    Measured m{scene[name].get<double>(), 0, scene["rounds"].get<int>()};
    const nlohmann::json &spread = scene["spread"];
    if (spread.contains(name)) m.spread = 0.5 * (spread[name][2].get<double>() - spread[name][0].get<double>());
    return m;
}

Measured millions(const nlohmann::json &scene, const char *name) {
    Measured m = measured(scene, name);
    m.value *= 1e-6;
    m.spread *= 1e-6;
    return m;
}

/// A point a scene, where both are known.
template <class X, class Y> void addScenes(Panel &panel, const nlohmann::json &scenes, const X &x, const Y &y) {
    for (const nlohmann::json &scene : scenes) panel.points.push_back({scene["name"].get<std::string>(), "", x(scene), y(scene)});
}

Panel plainPanel(const char *name, const char *title, std::string conditions, Axis x, Axis y) {
    Panel panel;
    panel.name = name;
    panel.title = title;
    panel.conditions = std::move(conditions);
    panel.x = std::move(x);
    panel.y = std::move(y);
    panel.hasFront = false;
    return panel;
}

} // namespace

Chart benchChart(const nlohmann::json &scenes, const std::string &conditions) {
    Chart chart;
    chart.name = "bench";
    chart.title = "Samples and rays per second";
    chart.compared =
        "The renderer, the same rays sent through bare Embree calls (packets of 16 for camera rays, of 8 for scattered ones, a "
        "stream for shadow rays) and, where it was measured, Cycles on the same scenes: all in turn, round by round.";
    chart.howToRead = "A mark is a scene: median of the rounds, bars half the distance of the quartiles. Rays through the renderer are "
                      "over tracing alone, shading included; samples are over whole frames, updates of moving meshes included.";
    chart.choice = "Nothing is chosen here. docs/benchmark.md says how it is measured.";
    Panel rays = plainPanel("rays", "Rays through the renderer against bare Embree", conditions, {"bare Embree", "Mrays/s"},
                            {"the renderer", "Mrays/s"});
    addScenes(
        rays, scenes, [](const auto &s) { return millions(s, "embree_rays_per_s"); },
        [](const auto &s) { return millions(s, "rays_per_s"); });
    chart.panels.push_back(std::move(rays));
    const auto all = [&](const char *field) {
        return std::all_of(scenes.begin(), scenes.end(), [&](const auto &s) { return s.contains(field) && !s[field].is_null(); });
    };
    if (all("ratio_to_cycles")) {
        Panel ratios = plainPanel("ratios", "Samples over Cycles' against rays over bare Embree's", conditions,
                                  {"rays over bare Embree's", "", false}, {"samples over Cycles'", "", false});
        addScenes(
            ratios, scenes, [](const auto &s) { return measured(s, "ratio_to_embree"); },
            [](const auto &s) { return measured(s, "ratio_to_cycles"); });
        chart.panels.push_back(std::move(ratios));
        Panel memory =
            plainPanel("memory", "Peak memory of the process", conditions, {"Cycles, Blender included", "MB"}, {"the renderer", "MB"});
        addScenes(
            memory, scenes, [](const auto &s) { return measured(s, "cycles_peak_mb"); },
            [](const auto &s) { return measured(s, "peak_mb"); });
        chart.panels.push_back(std::move(memory));
    }
    if (all("equal_error")) {
        Panel time = plainPanel("equal_error", "Time to the error that Cycles has, over its time", conditions,
                                {"Cycles' samples per pixel", ""}, {"time over Cycles'", "", false});
        time.joined = true;
        time.labelled = false;
        for (const nlohmann::json &scene : scenes)
            for (const nlohmann::json &e : scene["equal_error"]) {
                const double spp = e["cycles_spp"].get<double>();
                time.points.push_back(
                    {scene["name"].get<std::string>(), fmt::format("{:.0f}", spp), {spp, 0, 1}, {e["time_ratio"].get<double>(), 0, 1}});
            }
        chart.panels.push_back(std::move(time));
    }
    return chart;
}

void writeBenchChart(const Chart &chart, const std::filesystem::path &directory) {
    requireGnuplot();
    std::error_code error;
    std::filesystem::create_directories(directory, error);
    if (error) failInput({"--chart"}, quoted(directory.string()), "a folder that can be made");
    writeCsv(chart, directory);
    Section section{chart, {}, {}};
    for (const Panel &panel : chart.panels) section.panels.push_back(drawPanel(chart, panel, directory));
    const std::string date = fmt::format("{:%Y-%m-%d %H:%M} UTC", fmt::gmtime(std::time(nullptr)));
    writeTextFile((directory / "index.html").string(), reportPage({section}, Effort::Full, describeMachine(), date));
}

} // namespace taut::bench
