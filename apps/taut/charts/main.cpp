/// taut_charts, which `taut chart` becomes: measures speed against accuracy on this machine and writes CSV, plots and one page. Documented
/// in docs/charts.md.

#include "../command_line.h"

#include "study/charts.h"
#include "study/drawing/csv.h"
#include "study/drawing/front.h"
#include "study/drawing/report.h"
#include "study/text.h"

#include "taut/base/stopwatch.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <iostream>
#include <memory>
#include <string>
#include <vector>

namespace {

using namespace taut;

namespace fs = std::filesystem;

struct ChartArguments {
    std::vector<std::string> names;
    std::string output = "report";
    std::string against;
    bool quick = false, full = false, check = false;
};

std::vector<chart::ChartEntry> chosenCharts(const std::vector<std::string> &names) {
    std::vector<std::string_view> valid;
    for (const chart::ChartEntry &entry : chart::allCharts()) valid.emplace_back(entry.name);
    valid.emplace_back("all");
    for (const std::string &name : names)
        if (std::find(valid.begin(), valid.end(), name) == valid.end()) failUnknownName({"chart"}, name, valid);
    std::vector<chart::ChartEntry> chosen;
    for (const chart::ChartEntry &entry : chart::allCharts())
        for (const std::string &name : names)
            if (name == "all" || name == entry.name) {
                chosen.push_back(entry);
                break;
            }
    return chosen;
}

/// Prints how the panels of a chart were ordered by an earlier report, and returns the number of pairs that changed places.
std::size_t compareWith(const fs::path &earlier, const chart::Chart &now) {
    std::size_t turned = 0;
    std::size_t pairs = 0;
    for (const chart::Panel &panel : now.panels) {
        const chart::Ranking ranking = compareRankings(chart::readPanel(fileOf(earlier, now, panel.name, "csv")), panel);
        for (const std::string &line : ranking.turned) std::cout << now.name << "/" << line << std::endl;
        pairs += ranking.pairs;
        turned += ranking.turned.size();
    }
    std::cout << fmt::format("{}: {} of {} pairs change places against {}", now.name, turned, pairs, earlier.string()) << std::endl;
    return turned;
}

chart::Chart besideEarlier(const fs::path &earlier, chart::Chart chart) {
    for (chart::Panel &panel : chart.panels) panel = beside(std::move(panel), chart::readPanel(fileOf(earlier, chart, panel.name, "csv")));
    return chart;
}

int run(const ChartArguments &arguments) {
    const auto entries = chosenCharts(arguments.names);
    chart::requireGnuplot();
    const chart::ChartOptions options{arguments.full ? chart::Effort::Full : chart::Effort::Quick, arguments.output};
    chart::makeFolder(options.directory, "--output");
    std::vector<chart::Section> sections;
    std::vector<std::string> off;
    std::size_t turned = 0;
    for (const chart::ChartEntry &entry : entries) {
        Stopwatch watch;
        const chart::Chart measured = entry.measure(options);
        const double seconds = watch.lap();
        if (!arguments.against.empty()) turned += compareWith(arguments.against, measured);
        writeCsv(measured, options.directory);
        sections.push_back(draw(arguments.against.empty() ? measured : besideEarlier(arguments.against, measured), options.directory));
        std::cout << fmt::format("{}: measured in {:.1f} s, drawn in {:.1f} s", entry.name, seconds, watch.lap()) << std::endl;
        for (const chart::Table &table : measured.tables) std::cout << fmt::format("\n{}\n\n{}\n", table.title, markdownOf(table));
        for (std::string &line : checkDefaults(measured)) off.push_back(std::move(line));
    }
    std::cout << writeReport(sections, options.effort, options.directory).string() << std::endl;
    for (const std::string &line : off) std::cout << line << std::endl;
    if (arguments.check) std::cout << (off.empty() ? "every default is on its front" : "some defaults are off their fronts") << std::endl;
    return (arguments.check && !off.empty()) || turned > 0 ? 1 : 0;
}

void addMeasurements(CLI::App &parent, app::Run &run_) {
    auto arguments = std::make_shared<ChartArguments>();
    CLI::App *command = parent.add_subcommand("chart", "Measures speed against accuracy and writes a report");
    std::string names;
    for (const chart::ChartEntry &entry : chart::allCharts()) names += fmt::format("\n{}: {}", entry.name, entry.what);
    command->add_option("charts", arguments->names, "Which; all: every one." + names)->required();
    command->add_option("-o,--output", arguments->output, "Folder of the report (default: report)");
    CLI::Option *full = command->add_flag("--full", arguments->full, "As long as it needs");
    command->add_flag("--quick", arguments->quick, "All of them in ten minutes (default)")->excludes(full);
    command->add_flag("--check", arguments->check, "Exit 1 where a default is off its front by more than the measured spread");
    command->add_option("--against", arguments->against, "An earlier report: drawn beside; exit 1 where choices have changed places")
        ->check(CLI::ExistingDirectory);
    command->callback([&run_, arguments] { run_ = [arguments] { return run(*arguments); }; });
}

} // namespace

int main(int argc, char **argv) {
    return app::runCommandLine(argc, argv, addMeasurements);
}
