#pragma once
/// Every chart of `taut chart`, by name; each is measured by a function of its own in NAME_chart.cpp.

#include "study/chart.h"

#include <span>

namespace taut::chart {

Chart measurePrecision(const ChartOptions &options);
Chart measureSampling(const ChartOptions &options);
Chart measureGradient(const ChartOptions &options);
Chart measureInterpolation(const ChartOptions &options);
Chart measureSubdivision(const ChartOptions &options);
Chart measureMultiscatter(const ChartOptions &options);
Chart measureBvh(const ChartOptions &options);
Chart measurePlan(const ChartOptions &options);
Chart measureRender(const ChartOptions &options);
Chart measureMicrogeometry(const ChartOptions &options);
Chart measureTalk(const ChartOptions &options);

struct ChartEntry {
    const char *name;
    const char *what; ///< half a line for --help
    Chart (*measure)(const ChartOptions &);
};
/// In the order of the report.
std::span<const ChartEntry> allCharts();

} // namespace taut::chart
