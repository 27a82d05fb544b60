#pragma once
/// Every chart of `taut chart`, by name; each is measured by a function of its own in charts/NAME.cpp.

#include "study/chart.h"

#include <nlohmann/json_fwd.hpp>

#include <span>

namespace taut::chart {

Chart measurePrecision(const ChartOptions &options);
Chart measureSampling(const ChartOptions &options);
Chart measureGradient(const ChartOptions &options);
Chart measureInterpolation(const ChartOptions &options);
Chart measureSubdivision(const ChartOptions &options);
Chart measureMultiscatter(const ChartOptions &options);
Chart measureWalk(const ChartOptions &options);
Chart measureBvh(const ChartOptions &options);
Chart measurePlan(const ChartOptions &options);
Chart measureRender(const ChartOptions &options);
Chart measureMicrogeometry(const ChartOptions &options);
Chart measureMesostructure(const ChartOptions &options);
Chart measureTalk(const ChartOptions &options);
Chart measureMicrosurface(const ChartOptions &options);
Chart measureLights(const ChartOptions &options);
Chart measureExport(const ChartOptions &options);
Chart measureDenoise(const ChartOptions &options);

/// The benchmark's ratios, from what measureBench() gave for every scene. Panels of what was not measured (Cycles, equal error) are left
/// out.
Chart benchChart(const nlohmann::json &scenes, const std::string &conditions);

/// What docs/precision.md and docs/stability.md tabulate.
std::vector<Table> precisionTables();

struct ChartEntry {
    const char *name;
    const char *what; ///< half a line for --help
    Chart (*measure)(const ChartOptions &);
};
/// In the order of the report.
std::span<const ChartEntry> allCharts();

} // namespace taut::chart
