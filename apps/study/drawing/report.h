#pragma once
/// The report: one HTML page with everything in it, no other file and no address needed, legible from 400 pixels up.

#include "study/drawing/plots.h"

namespace taut::chart {

/// A chart and what was drawn of it, in the order of its panels and maps.
struct Section {
    Chart chart;
    std::vector<Drawing> panels, maps;
};

/// Draws every panel and map into a folder.
Section draw(const Chart &chart, const std::filesystem::path &directory);

/// Processor, threads, compiler: what the times hold for.
std::string describeMachine();

/// The page as text. Throws RunError where a picture cannot be read.
std::string reportPage(const std::vector<Section> &sections, Effort effort, const std::string &machine, const std::string &date);

/// Makes the folder. Throws InputError, naming the option that asked for it.
void makeFolder(const std::filesystem::path &directory, const std::string &option);
/// DIRECTORY/index.html, of this machine and now; returns its path.
std::filesystem::path writeReport(const std::vector<Section> &sections, Effort effort, const std::filesystem::path &directory);

} // namespace taut::chart
