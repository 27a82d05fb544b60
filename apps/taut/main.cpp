/// taut: renders deforming meshes whose gloss follows the deformation. One file a subcommand.

#include "command_line.h"

#include <string_view>

int main(int argc, char **argv) {
    // What follows `chart` is another program's.
    const bool isChart = argc > 1 && std::string_view(argv[1]) == "chart";
    const int parsed = isChart ? 2 : argc;
    return taut::app::runCommandLine(parsed, argv, [&](CLI::App &app, taut::app::Run &run) {
        taut::app::addRender(app, run);
        taut::app::addMerge(app, run);
        taut::app::addFarm(app, run);
        taut::app::addCompare(app, run);
        taut::app::addSheet(app, run);
        taut::app::addInfo(app, run);
        taut::app::addExport(app, run);
        taut::app::addProbe(app, run);
        taut::app::addView(app, run);
        taut::app::addChart(app, run, {argv + parsed, argv + argc});
    });
}
