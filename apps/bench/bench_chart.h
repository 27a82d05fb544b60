#pragma once
/// The benchmark's ratios as a chart.

#include "study/chart.h"

#include <nlohmann/json.hpp>

namespace taut::bench {

/// From what measure() gave for every scene. Panels of what was not measured (Cycles, equal error) are left out.
chart::Chart benchChart(const nlohmann::json &scenes, const std::string &conditions);

/// Writes CSV, SVG and PNG of every panel into a folder, made if it is not there, and a page that shows them, index.html. Throws
/// InputError where gnuplot cannot be started or the folder not be made, RunError where a file cannot be written.
void writeBenchChart(const chart::Chart &chart, const std::filesystem::path &directory);

} // namespace taut::bench
