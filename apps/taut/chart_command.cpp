/// taut chart: a program of its own, taut_charts (charts/main.cpp), so that who renders need not build what measures.

#include "commands.h"
#include "this_program.h"

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <string>
#include <unistd.h>
#include <utility>
#include <vector>

namespace taut::app {

namespace {

namespace fs = std::filesystem;

/// Becomes the program, with all that follows `chart`; its exit code is that of the subcommand.
int run(const std::vector<std::string> &rest) {
    const fs::path folder = thisProgram().parent_path();
    if (folder.empty()) throw RunError("chart: where this program is could not be found out, and taut_charts is beside it");
    const fs::path program = folder / "taut_charts";
    std::error_code error;
    if (!fs::exists(program, error))
        throw RunError("chart: found no program " + program.string() +
                       ", which measures (in a build of taut it is the target taut_charts)");
    std::vector<std::string> words{"taut", "chart"};
    words.insert(words.end(), rest.begin(), rest.end());
    std::vector<char *> pointers;
    for (std::string &word : words) pointers.push_back(word.data());
    pointers.push_back(nullptr);
    execv(program.c_str(), pointers.data());
    throw RunError("chart: " + program.string() + " could not be run: " + std::strerror(errno));
}

} // namespace

void addChart(CLI::App &parent, Run &run_, std::vector<std::string> rest) {
    CLI::App *command = parent.add_subcommand("chart", "Measures speed against accuracy and writes a report");
    command->footer("taut chart --help lists the charts and the options");
    command->callback([&run_, rest = std::move(rest)] { run_ = [rest] { return run(rest); }; });
}

} // namespace taut::app
