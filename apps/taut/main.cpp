/// taut: renders deforming meshes whose gloss follows the deformation. One file a subcommand.

#include "command_line.h"

int main(int argc, char **argv) {
    return taut::app::runCommandLine(argc, argv, [](CLI::App &app, taut::app::Run &run) {
        taut::app::addRender(app, run);
        taut::app::addMerge(app, run);
        taut::app::addFarm(app, run);
        taut::app::addCompare(app, run);
        taut::app::addSheet(app, run);
        taut::app::addInfo(app, run);
        taut::app::addExport(app, run);
        taut::app::addProbe(app, run);
        taut::app::addView(app, run);
        taut::app::addChart(app, run);
    });
}
