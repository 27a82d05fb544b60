#pragma once
/// A chart's numbers as CSV (RFC 4180): CHART_PANEL.csv, a line per choice with units, conditions, repetitions and spread; CHART_MAP.csv,
/// a line per cell; CHART_TABLE.csv, as it stands. Numbers have nine digits; what is not finite is `inf` or `nan`.

#include "study/chart.h"

namespace taut::chart {

/// DIRECTORY/CHART_NAME.EXTENSION, of a panel or a map.
std::filesystem::path fileOf(const std::filesystem::path &directory, const Chart &chart, const std::string &name,
                             const std::string &extension);

/// Writes a file for every panel, map and table. Throws RunError.
void writeCsv(const Chart &chart, const std::filesystem::path &directory);

/// A panel that was written: name, conditions, axes without their scale, points. Throws InputError.
Panel readPanel(const std::filesystem::path &file);

} // namespace taut::chart
