#pragma once
/// The report: one HTML page with everything in it, no other file and no address needed, legible from 400 pixels up.

#include "study/plots.h"

namespace taut::chart {

/// A chart and what was drawn of it, in the order of its panels and maps.
struct Section {
    Chart chart;
    std::vector<Drawing> panels, maps;
};

/// Processor, threads, compiler: what the times hold for.
std::string describeMachine();

/// The page as text. Throws RunError where a picture cannot be read.
std::string reportPage(const std::vector<Section> &sections, Effort effort, const std::string &machine, const std::string &date);

} // namespace taut::chart
