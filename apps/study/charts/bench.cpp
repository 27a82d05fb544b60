/// The benchmark's ratios as a chart: from what measureBench() gave for every scene.

#include "study/charts.h"
#include "study/text.h"

#include <nlohmann/json.hpp>

namespace taut::chart {

namespace {

using nlohmann::json;

/// A median and half the distance of its quartiles; what has none is its own.
Measured measured(const json &scene, const char *name, double factor = 1) {
    Measured m{factor * scene[name].get<double>(), 0, scene["rounds"].get<int>()};
    const json &spread = scene["spread"];
    if (spread.contains(name)) m.spread = factor * 0.5 * (spread[name][2].get<double>() - spread[name][0].get<double>());
    return m;
}

/// A field on each axis, a point a scene.
Panel panelOf(const json &scenes, const std::string &conditions, const std::vector<std::string> &words, Axis x, const char *xField, Axis y,
              const char *yField, double factor = 1) {
    Panel panel{words[0], words[1], conditions, std::move(x), std::move(y), {}, false};
    for (const json &scene : scenes)
        panel.points.push_back({scene["name"].get<std::string>(), "", measured(scene, xField, factor), measured(scene, yField, factor)});
    return panel;
}

} // namespace

Chart benchChart(const json &scenes, const std::string &conditions) {
    Chart chart{"bench", "Samples and rays per second",
                "The renderer, the same rays sent through bare Embree calls (packets of 16 for camera rays, of 8 for scattered ones, "
                "for shadow rays a stream, or packets of 16 by Embree 4) and, where it was measured, Cycles on the same scenes: all in turn, round by round.",
                "A mark is a scene: median of the rounds, bars half the distance of the quartiles. Rays through the renderer are "
                "over tracing alone, shading included; samples are over whole frames, updates of moving meshes included.",
                "Nothing is chosen here. docs/benchmark.md says how it is measured."};
    chart.panels.push_back(panelOf(scenes, conditions, {"rays", "Rays through the renderer against bare Embree"},
                                   {"bare Embree", "Mrays/s"}, "embree_rays_per_s", {"the renderer", "Mrays/s"}, "rays_per_s", 1e-6));
    const auto all = [&](const char *field) {
        return std::all_of(scenes.begin(), scenes.end(), [&](const json &s) { return s.contains(field) && !s[field].is_null(); });
    };
    if (all("ratio_to_cycles")) {
        chart.panels.push_back(panelOf(scenes, conditions, {"ratios", "Samples over Cycles' against rays over bare Embree's"},
                                       {"rays over bare Embree's", "", false}, "ratio_to_embree", {"samples over Cycles'", "", false},
                                       "ratio_to_cycles"));
        chart.panels.push_back(panelOf(scenes, conditions, {"memory", "Peak memory of the process"}, {"Cycles, Blender included", "MB"},
                                       "cycles_peak_mb", {"the renderer", "MB"}, "peak_mb"));
    }
    if (all("equal_error")) {
        Panel time = lines({"equal_error",
                            "Time to the error that Cycles has, over its time",
                            conditions,
                            {"Cycles' samples per pixel", ""},
                            {"time over Cycles'", "", false},
                            {}});
        for (const json &scene : scenes)
            for (const json &e : scene["equal_error"])
                time.points.push_back({scene["name"].get<std::string>(),
                                       digits(e["cycles_spp"].get<double>()),
                                       {e["cycles_spp"].get<double>()},
                                       {e["time_ratio"].get<double>()}});
        chart.panels.push_back(std::move(time));
    }
    return chart;
}

} // namespace taut::chart
