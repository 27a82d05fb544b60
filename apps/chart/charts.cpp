#include "chart/charts.h"

namespace taut::chart {

std::span<const ChartEntry> allCharts() {
    static constexpr ChartEntry kCharts[] = {
        {"precision", "digits that float leaves to formulations of the microsurface", measurePrecision},
    };
    return kCharts;
}

} // namespace taut::chart
