#pragma once
/// The subcommands of `taut`: each adds itself to the parser and runs when chosen.

#include "taut/base/error.h"

#include <CLI/CLI.hpp>

namespace taut::app {

/// A subcommand that was chosen runs here and returns the exit code.
using Run = std::function<int()>;

void addRender(CLI::App &parent, Run &run);
void addMerge(CLI::App &parent, Run &run);
void addFarm(CLI::App &parent, Run &run);
void addCompare(CLI::App &parent, Run &run);
void addSheet(CLI::App &parent, Run &run);
void addInfo(CLI::App &parent, Run &run);
void addExport(CLI::App &parent, Run &run);
void addProbe(CLI::App &parent, Run &run);
void addView(CLI::App &parent, Run &run);
/// `rest`: what follows `chart`, for the program that it becomes.
void addChart(CLI::App &parent, Run &run, std::vector<std::string> rest);

/// Prints each warning as one line on standard error.
void printWarnings(const Warnings &warnings);

} // namespace taut::app
