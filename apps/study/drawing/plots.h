#pragma once
/// Plots by gnuplot (Debian: gnuplot-nox): SVG and PNG files beside the CSV, and the two shapes, wide and narrow, that the report shows.

#include "study/chart.h"

namespace taut::chart {

/// Throws InputError where gnuplot cannot be started: the report needs it.
void requireGnuplot();

/// What the report shows of a panel or map, as SVG text.
struct Drawing {
    std::string wide;
    std::string narrow; ///< for 400 pixels; empty where `wide` serves
};

/// Writes CHART_PANEL.svg and .png. Throws RunError.
Drawing drawPanel(const Chart &chart, const Panel &panel, const std::filesystem::path &directory);
Drawing drawMap(const Chart &chart, const Map &map, const std::filesystem::path &directory);

} // namespace taut::chart
