#pragma once
/// What programs with subcommands do around them.

#include "commands.h"

#include <functional>

namespace taut::app {

using AddCommands = std::function<void(CLI::App &parent, Run &run)>;

/// Parses the arguments of main() with the subcommands that are added, and runs the chosen one. Unknown names are answered with the
/// nearest, errors in one line. Returns the exit code: 0 done, 1 failed while running, 2 usage or bad input, 75 stopped and to be gone on
/// with.
int runCommandLine(int argc, char **argv, const AddCommands &addCommands);

} // namespace taut::app
