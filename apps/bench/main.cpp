/// taut_bench: samples and rays per second of the renderer, beside the same rays replayed through bare Embree calls and, where it
/// is asked for, Cycles on the same scenes; where the time goes; and time to equal error. Prints tables; --output writes JSON, --chart
/// plots.

#include "bench_chart.h"
#include "study/cycles_peer.h"
#include "study/plots.h"
#include "measure.h"

#include "taut/base/error.h"
#include "taut/render/image_file.h"

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <tbb/global_control.h>
#include <tbb/info.h>

#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <iostream>

namespace {

using namespace taut;
using namespace taut::bench;

/// Measures in a process of its own, so that the peak memory is this scene's. The parent must not have started threads.
nlohmann::json measureApart(const BenchScene &bench, const MeasureOptions &options) {
    int channel[2];
    if (pipe(channel) != 0) throw RunError("can't make a pipe");
    const pid_t child = fork();
    if (child < 0) throw RunError("can't start a process");
    if (child == 0) {
        close(channel[0]);
        int code = 0;
        try {
            const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(options.threads));
            const std::string text = measure(bench, options).dump();
            if (write(channel[1], text.data(), text.size()) != static_cast<ssize_t>(text.size())) code = 1;
        } catch (const std::exception &error) {
            std::cerr << "taut_bench: error: " << bench.name << ": " << error.what() << std::endl;
            code = 1;
        }
        std::_Exit(code);
    }
    close(channel[1]);
    std::string text;
    char buffer[4096];
    for (ssize_t got = 0; (got = read(channel[0], buffer, sizeof buffer)) > 0;) text.append(buffer, static_cast<std::size_t>(got));
    close(channel[0]);
    int status = 0;
    waitpid(child, &status, 0);
    if (status != 0) throw RunError("the measurement of '" + bench.name + "' failed");
    return nlohmann::json::parse(text);
}

std::string number(const nlohmann::json &value, int digits) {
    return value.is_number() ? fmt::format("{:.{}f}", value.get<double>(), digits) : "-";
}

/// The median and its quartiles.
std::string ratio(const nlohmann::json &scene, const char *name) {
    if (!scene[name].is_number()) return "-";
    const nlohmann::json &spread = scene["spread"][name];
    return fmt::format("{:.2f} ({:.2f}-{:.2f})", scene[name].get<double>(), spread[0].get<double>(), spread[2].get<double>());
}

double millions(const nlohmann::json &scene, const char *name) {
    return 1e-6 * scene[name].get<double>();
}

void printHeader() {
    fmt::print("{:<16} {:>8} {:>7} {:>7} {:>17} {:>17} {:>7} {:>7} |{:>6} {:>5} {:>5} {:>5} {:>5} {:>5} {:>9}\n", "scene", "Msampl/s",
               "Mrays/s", "Embree", "ratio (quartiles)", "to Cycles", "peak MB", "Cycles", "deform", "grad", "bvh", "trav", "shade", "film",
               "update ms");
    std::fflush(stdout);
}

void printRow(const nlohmann::json &s) {
    const auto share = [&](const char *name) { return 100 * s["share"][name].get<double>(); };
    fmt::print("{:<16} {:>8.3f} {:>7.2f} {:>7.2f} {:>17} {:>17} {:>7.0f} {:>7} |{:>5.1f}% {:>4.1f}% {:>4.1f}% {:>4.0f}% {:>4.0f}% "
               "{:>4.1f}% {:>9.1f}\n",
               s["name"].get<std::string>(), millions(s, "samples_per_s"), millions(s, "rays_per_s"), millions(s, "embree_rays_per_s"),
               ratio(s, "ratio_to_embree"), ratio(s, "ratio_to_cycles"), s["peak_mb"].get<double>(), number(s["cycles_peak_mb"], 0),
               share("deformation"), share("gradient"), share("bvh"), share("traversal"), share("shading"), share("film"),
               1e3 * s["update_seconds_per_frame"].get<double>());
    std::fflush(stdout);
}

void printMemory(const nlohmann::json &scenes) {
    fmt::print("\n{:<16} {:>10} {:>10} | {:>7} {:>7} {:>7} {:>7} {:>7} {:>7} {:>7} {:>6} {:>12}\n", "bytes a triangle", "triangles",
               "vertices", "Embree", "shown", "motion", "source", "policy", "total", "least", "ratio", "with source");
    for (const auto &s : scenes) {
        const nlohmann::json &memory = s["memory"];
        const auto bytes = [&](const char *name) { return memory["bytes_per_triangle"][name].get<double>(); };
        fmt::print("{:<16} {:>10} {:>10} | {:>7.1f} {:>7.1f} {:>7.1f} {:>7.1f} {:>7.1f} {:>7.1f} {:>7.1f} {:>6.2f} {:>12.2f}\n",
                   s["name"].get<std::string>(), memory["triangles"].get<std::size_t>(), memory["vertices"].get<std::size_t>(),
                   bytes("embree"), bytes("shown"), bytes("motion"), bytes("source"), bytes("policy"), bytes("total"), bytes("least"),
                   memory["ratio_to_least"].get<double>(), memory["ratio_with_source"].get<double>());
    }
}

void printEqualError(const nlohmann::json &scenes) {
    fmt::print("\n{:<16} {:>10} {:>10} {:>11} {:>9} {:>10} {:>10} {:>6}   {}\n", "equal error", "Cycles spp", "MSE", "Cycles s", "our spp",
               "our s", "time ratio", "", "images: ratio of means, RMS difference (relative)");
    for (const auto &s : scenes) {
        if (!s.contains("equal_error")) continue;
        std::string images =
            fmt::format("{:.4f}, {:.4f}", s["images"]["mean_ratio"].get<double>(), s["images"]["relative_difference"].get<double>());
        for (const auto &e : s["equal_error"]) {
            fmt::print("{:<16} {:>10.0f} {:>10.2e} {:>11.2f} {:>9.1f} {:>10.2f} {:>10.2f} {:>6}   {}\n", s["name"].get<std::string>(),
                       e["cycles_spp"].get<double>(), e["mse"].get<double>(), e["cycles_seconds"].get<double>(), e["our_spp"].get<double>(),
                       e["our_seconds"].get<double>(), e["time_ratio"].get<double>(), "", images);
            images.clear();
        }
    }
}

} // namespace

int main(int argc, char **argv) {
    CLI::App app("Measures the renderer beside bare Embree calls for the same rays and beside Cycles.", "taut_bench");
    std::string output;
    std::string chartFolder;
    std::vector<std::string> only;
    MeasureOptions options;
    options.threads = tbb::info::default_concurrency();
    bool quick = false;
    app.add_option("--output", output, "Write what was measured as JSON");
    app.add_option("--chart", chartFolder, "A folder for plots and a page of them");
    app.add_option("--scene", only, "Only these scenes");
    app.add_option("--spp", options.spp, "Samples per pixel of a timed frame")->check(CLI::Range(1, 4096));
    app.add_option("--record-spp", options.recordSpp, "Samples per pixel recorded for the replay")->check(CLI::Range(1, 64));
    app.add_option("--rounds", options.rounds, "Rounds in which all take turns")->check(CLI::Range(1, 99));
    app.add_option("-t,--threads", options.threads, "Threads (default: all)")->check(CLI::Range(1, 1024));
    app.add_flag("--cycles", options.cycles, "Measure Cycles as well, where blender is on the PATH");
    app.add_flag("--equal-error", options.equalError,
                 "With --cycles: errors at 16, 64 and 256 samples per pixel, and times to equal error");
    app.add_option("--error-size", options.errorSize, "Width and height of the images whose error is measured")
        ->check(CLI::Range(16, 4096));
    app.add_flag("--quick", quick, "One round of 4 samples per pixel");
    CLI11_PARSE(app, argc, argv);
    try {
        if (quick) {
            options.rounds = 1;
            options.spp = 4;
        }
        if (options.cycles && !chart::hasBlender()) {
            std::cerr << "taut_bench: blender is not on the PATH: Cycles is left out" << std::endl;
            options.cycles = false;
        }
        if (!chartFolder.empty()) chart::requireGnuplot(); // rather now than after the measurement
        std::vector<std::string_view> names;
        for (const BenchScene &bench : benchScenes()) names.push_back(bench.name);
        for (const std::string &name : only)
            if (std::find(names.begin(), names.end(), name) == names.end()) failUnknownName({"--scene"}, name, names);
        nlohmann::json scenes = nlohmann::json::array();
        printHeader();
        for (const BenchScene &bench : benchScenes()) {
            if (!only.empty() && std::find(only.begin(), only.end(), bench.name) == only.end()) continue;
            scenes.push_back(measureApart(bench, options));
            printRow(scenes.back());
        }
        printMemory(scenes);
        if (options.cycles && options.equalError) printEqualError(scenes);
        if (!output.empty()) writeTextFile(output, nlohmann::json{{"threads", options.threads}, {"scenes", scenes}}.dump(2) + "\n");
        if (!chartFolder.empty()) {
            const std::string conditions =
                fmt::format("{} threads, {} rounds, {} samples per pixel, 512 x 512 pixels.", options.threads, options.rounds, options.spp);
            writeBenchChart(benchChart(scenes, conditions), chartFolder);
        }
    } catch (const InputError &error) {
        std::cerr << "taut_bench: error: " << error.what() << std::endl;
        return 2;
    } catch (const std::exception &error) {
        std::cerr << "taut_bench: error: " << error.what() << std::endl;
        return 1;
    }
    return 0;
}
