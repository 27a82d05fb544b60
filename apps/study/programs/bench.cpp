/// taut_bench: samples and rays per second of the renderer, beside the same rays replayed through bare Embree calls and, where it
/// is asked for, Cycles on the same scenes; where the time goes; and time to equal error. Prints tables; --output writes JSON, --chart
/// plots.

#include "study/measures/bench.h"
#include "study/charts.h"
#include "study/drawing/csv.h"
#include "study/drawing/report.h"
#include "study/measures/cycles_peer.h"

#include "taut/base/error.h"
#include "taut/render/image_file.h"

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <tbb/info.h>

#include <filesystem>
#include <iostream>

namespace {

using namespace taut;
using namespace taut::chart;
using nlohmann::json;

/// A column of a printed table: what is at a place of the JSON.
struct Column {
    std::string head;
    int width; ///< negative: to the left
    std::function<std::string(const json &)> cell;
};

/// "-" where there is none.
Column number(const std::string &head, int width, const std::string &place, int digits, double factor = 1) {
    return {head, width, [=](const json &s) {
                const json value = s.value(json::json_pointer(place), json());
                return value.is_number() ? fmt::format("{:.{}f}", factor * value.get<double>(), digits) : "-";
            }};
}
Column name(const std::string &head) {
    return {head, -16, [](const json &s) { return s["name"].get<std::string>(); }};
}
/// The median and its quartiles.
Column ratio(const std::string &head, const std::string &field) {
    return {head, 17, [=](const json &s) {
                if (!s[field].is_number()) return std::string("-");
                const json &spread = s["spread"][field];
                return fmt::format("{:.2f} ({:.2f}-{:.2f})", s[field].get<double>(), spread[0].get<double>(), spread[2].get<double>());
            }};
}

void print(const std::vector<Column> &columns, const json *row) {
    std::string line;
    for (const Column &c : columns) {
        const std::string text = row == nullptr ? c.head : c.cell(*row);
        line += c.width < 0 ? fmt::format("{:<{}} ", text, -c.width) : fmt::format("{:>{}} ", text, c.width);
    }
    std::cout << line << std::endl;
}

const std::vector<Column> kScenes{name("scene"),
                                  number("Msampl/s", 8, "/samples_per_s", 3, 1e-6),
                                  number("Mrays/s", 7, "/rays_per_s", 2, 1e-6),
                                  number("Embree", 7, "/embree_rays_per_s", 2, 1e-6),
                                  ratio("ratio (quartiles)", "ratio_to_embree"),
                                  ratio("to Cycles", "ratio_to_cycles"),
                                  number("seen %", 6, "/foreground", 0, 100),
                                  number("peak MB", 7, "/peak_mb", 0),
                                  number("Cycles", 7, "/cycles_peak_mb", 0),
                                  number("deform %", 8, "/share/deformation", 1, 100),
                                  number("grad", 5, "/share/gradient", 1, 100),
                                  number("bvh", 5, "/share/bvh", 1, 100),
                                  number("trav", 5, "/share/traversal", 0, 100),
                                  number("shade", 5, "/share/shading", 0, 100),
                                  number("film", 5, "/share/film", 1, 100),
                                  number("update ms", 9, "/update_seconds_per_frame", 1, 1e3)};

std::vector<Column> memoryColumns() {
    std::vector<Column> columns{name("bytes a triangle"), number("triangles", 10, "/memory/triangles", 0),
                                number("vertices", 10, "/memory/vertices", 0)};
    for (const char *part : {"embree", "shown", "motion", "source", "policy", "total", "least"})
        columns.push_back(number(part, 7, std::string("/memory/bytes_per_triangle/") + part, 1));
    columns.push_back(number("ratio", 6, "/memory/ratio_to_least", 2));
    columns.push_back(number("with source", 12, "/memory/ratio_with_source", 2));
    return columns;
}

const std::vector<Column> kEqualError{name("equal error"),
                                      number("Cycles spp", 10, "/cycles_spp", 0),
                                      number("MSE x 1e6", 10, "/mse", 2, 1e6),
                                      number("Cycles s", 9, "/cycles_seconds", 2),
                                      number("our spp", 9, "/our_spp", 1),
                                      number("our s", 9, "/our_seconds", 2),
                                      number("time ratio", 10, "/time_ratio", 2),
                                      number("images: ratio of means", 22, "/images/mean_ratio", 4),
                                      number("RMS difference (relative)", 25, "/images/relative_difference", 4)};

struct Arguments {
    std::string output, chart;
    std::vector<std::string> only;
    std::vector<std::string> characters; ///< glTF files
    BenchOptions options;
    bool quick = false;
};

void run(Arguments arguments) {
    BenchOptions &options = arguments.options;
    if (arguments.quick) {
        options.rounds = 1;
        options.spp = 4;
    }
    if (options.cycles && !hasBlender()) {
        std::cerr << "taut_bench: blender is not on the PATH: Cycles is left out" << std::endl;
        options.cycles = false;
    }
    if (!arguments.chart.empty()) requireGnuplot(); // rather now than after the measurement
    std::vector<BenchScene> all = benchScenes();
    if (arguments.characters.empty())
        std::cerr << "taut_bench: SKIPPED: characters, for neither --characters nor TAUT_CHARACTERS names a file" << std::endl;
    for (const std::string &file : arguments.characters) {
        if (!std::filesystem::exists(file)) {
            std::cerr << "taut_bench: SKIPPED: " << file << " is not on this machine" << std::endl;
            continue;
        }
        for (BenchScene &scene : characterScenes(file)) all.push_back(std::move(scene));
    }
    std::vector<std::string_view> names;
    for (const BenchScene &bench : all) names.push_back(bench.name);
    for (const std::string &each : arguments.only)
        if (std::find(names.begin(), names.end(), each) == names.end()) failUnknownName({"--scene"}, each, names);
    json scenes = json::array();
    print(kScenes, nullptr);
    for (const BenchScene &bench : all) {
        const auto &only = arguments.only;
        if (!only.empty() && std::find(only.begin(), only.end(), bench.name) == only.end()) continue;
        scenes.push_back(measureApart(bench, options));
        print(kScenes, &scenes.back());
    }
    std::cout << '\n';
    print(memoryColumns(), nullptr);
    for (const json &scene : scenes) print(memoryColumns(), &scene);
    if (options.cycles && options.equalError) {
        std::cout << '\n';
        print(kEqualError, nullptr);
        for (const json &scene : scenes)
            for (json row : scene.value("equal_error", json::array())) {
                row["name"] = scene["name"];
                row["images"] = scene["images"];
                print(kEqualError, &row);
            }
    }
    if (!arguments.output.empty()) writeTextFile(arguments.output, json{{"threads", options.threads}, {"scenes", scenes}}.dump(2) + "\n");
    if (arguments.chart.empty()) return;
    const Chart chart = benchChart(scenes, fmt::format("{} threads, {} rounds, {} samples per pixel, 512 x 512 pixels.", options.threads,
                                                       options.rounds, options.spp));
    makeFolder(arguments.chart, "--chart");
    writeCsv(chart, arguments.chart);
    writeReport({draw(chart, arguments.chart)}, Effort::Full, arguments.chart);
}

} // namespace

int main(int argc, char **argv) {
    CLI::App app("Measures the renderer beside bare Embree calls for the same rays and beside Cycles.", "taut_bench");
    Arguments arguments;
    BenchOptions &options = arguments.options;
    options.threads = tbb::info::default_concurrency();
    app.add_option("--output", arguments.output, "Write what was measured as JSON");
    app.add_option("--chart", arguments.chart, "A folder for plots and a page of them");
    app.add_option("--scene", arguments.only, "Only these scenes");
    app.add_option("--characters", arguments.characters, "glTF files that are measured too, separated by colons")
        ->delimiter(':')
        ->envname("TAUT_CHARACTERS");
    app.add_option("--spp", options.spp, "Samples per pixel of a timed frame")->check(CLI::Range(1, 4096));
    app.add_option("--record-spp", options.recordSpp, "Samples per pixel recorded for the replay")->check(CLI::Range(1, 64));
    app.add_option("--rounds", options.rounds, "Rounds in which all take turns")->check(CLI::Range(1, 99));
    app.add_option("-t,--threads", options.threads, "Threads (default: all)")->check(CLI::Range(1, 1024));
    app.add_flag("--cycles", options.cycles, "Measure Cycles as well, where blender is on the PATH");
    app.add_flag("--equal-error", options.equalError,
                 "With --cycles: errors at 16, 64 and 256 samples per pixel, and times to equal error");
    app.add_option("--error-size", options.errorSize, "Width and height of the images whose error is measured")
        ->check(CLI::Range(16, 4096));
    app.add_flag("--quick", arguments.quick, "One round of 4 samples per pixel");
    CLI11_PARSE(app, argc, argv);
    try {
        run(arguments);
    } catch (const std::exception &error) {
        std::cerr << "taut_bench: error: " << error.what() << std::endl;
        return dynamic_cast<const InputError *>(&error) != nullptr ? 2 : 1;
    }
    return 0;
}
