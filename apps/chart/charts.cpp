#include "chart/charts.h"

namespace taut::chart {

std::span<const ChartEntry> allCharts() {
    static constexpr ChartEntry kCharts[] = {
        {"precision", "digits that float leaves to formulations of the microsurface", measurePrecision},
        {"sampling", "what samplers of reflections cost, reject and vary", measureSampling},
        {"multiscatter", "light that meets more than one facet: energy, directions, cost", measureMultiscatter},
    };
    return kCharts;
}

} // namespace taut::chart
