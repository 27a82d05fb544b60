#include "study/measures/bench.h"

#include "study/measures/cycles_peer.h"
#include "study/measures/image_error.h"
#include "study/measures/memory.h"
#include "study/measures/render_image.h"
#include "study/measures/replay.h"
#include "study/measures/timing.h"

#include "taut/base/error.h"
#include "taut/render/aov.h"
#include "taut/render/memory_use.h"

#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <iostream>
#include <map>
#include <optional>

namespace taut::chart {

using nlohmann::json;

namespace {

/// All frames of the scene, rendered once; a single frame is set already.
struct Ours {
    StageTimes stages;
    RayCounts counts;
    double traced = 0; ///< wall clock
    [[nodiscard]] double updates() const { return stages.deformation + stages.gradient + stages.bvh; }
    [[nodiscard]] double seconds() const { return updates() + traced; }
};

/// Share of camera rays that meet a surface.
double foregroundOf(const RenderScene &ready) {
    FrameOptions options;
    options.spp = 1;
    options.aovs = {*findAov("depth")};
    const FrameResult result = renderFrame(ready, options);
    const std::vector<float> values = result.film.resolve();
    const std::size_t stride = result.film.channelNames().size();
    std::size_t seen = 0;
    for (std::size_t i = 4; i < values.size(); i += stride) seen += values[i] > 0 ? 1 : 0;
    return static_cast<double>(seen) / static_cast<double>(values.size() / stride);
}

Ours renderAll(RenderScene &ready, int spp) {
    Ours total;
    const std::vector<int> &frames = ready.scene().render.frames;
    for (const int frame : frames) {
        if (frames.size() > 1) ready.setFrame(frame, total.stages);
        FrameOptions options;
        options.spp = spp;
        options.seed = frameSeed(0, frame, false);
        const FrameResult result = renderFrame(ready, options);
        total.stages += result.times;
        total.counts += result.counts;
        total.traced += result.seconds;
    }
    return total;
}

/// All frames by Cycles.
struct Theirs {
    double seconds = 0; ///< whole frames
    double traced = 0;  ///< of one frame, rendered again without a change
    double peakMb = 0;
};

Theirs renderAll(CyclesPeer &cycles, const RenderSettings &render, int spp) {
    Theirs total;
    const int frames = static_cast<int>(render.frames.size());
    CyclesRequest request{0, spp, 0, render.width, render.height};
    CyclesRender last;
    for (; request.frame < frames; ++request.frame) {
        last = cycles.render(request);
        total.seconds += last.seconds;
    }
    request.frame = frames - 1;
    if (frames > 1) last = cycles.render(request);
    total.traced = last.seconds;
    total.peakMb = last.peakMb;
    return total;
}

/// Seconds of a frame of the timed size: what does not depend on the samples, and a sample a pixel.
struct FrameCost {
    double fixed = 0, perSample = 0;
    [[nodiscard]] double at(double spp) const { return fixed + spp * perSample; }
};

constexpr std::array<int, 3> kCompared{16, 64, 256};
constexpr int kMostSamples = 4096;

/// What frames cost where the plan reckons with other samples than those they were timed with, which may make another kind of BVH
/// pay: `timed`, scaled by how the two compare in turn.
FrameCost costAtSamples(Scene scene, int spp, RenderScene &ready, const BenchOptions &options, const FrameCost &timed) {
    scene.render.spp = spp;
    RenderScene planned(scene, true);
    if (planned.refits() == ready.refits()) return timed;
    StageTimes ignored;
    planned.setFrame(scene.render.frames.front(), ignored);
    renderAll(planned, 1);
    std::vector<double> updates;
    std::vector<double> traced;
    for (int round = 0; round < options.rounds; ++round) {
        const Ours before = renderAll(ready, options.spp);
        const Ours after = renderAll(planned, options.spp);
        updates.push_back(after.updates() / before.updates());
        traced.push_back(after.traced / before.traced);
    }
    return {timed.fixed * quartilesOf(updates).median, timed.perSample * quartilesOf(traced).median};
}

/// Errors of both renderers from two seeds each, over the samples; the times to equal error; how far the images agree. `ours`: for
/// every number of samples that is compared.
void measureEqualError(const BenchScene &bench, const BenchOptions &options, CyclesPeer &cycles,
                       const std::array<FrameCost, kCompared.size()> &ours, const FrameCost &theirs, json &out) {
    Scene scene = bench.make();
    scene.render.width = scene.render.height = options.errorSize;
    for (Object &object : scene.objects) object.follow = false; // as Cycles sees it
    RenderScene ready(scene, false);
    StageTimes ignored;
    ready.setFrame(scene.render.frames.back(), ignored);
    /// Two images, of two seeds, at the last number of samples.
    struct Pair {
        std::array<std::vector<float>, 2> images;
        std::vector<ErrorPoint> curve;
        void add(int spp, const std::function<std::vector<float>(int seed)> &render) {
            images = {render(1), render(2)};
            curve.push_back({static_cast<double>(spp), errorOfTwo(images[0], images[1])});
        }
        [[nodiscard]] double mean() const { return meanOf(images[0]) + meanOf(images[1]); }
    } we, they;
    for (const int spp : kCompared)
        they.add(spp, [&](int seed) {
            return cycles.render({bench.frames - 1, spp, seed, options.errorSize, options.errorSize, true}).image;
        });
    const double least = they.curve.back().error;
    for (int spp = 4; spp <= 256 || (spp <= kMostSamples && we.curve.back().error > least); spp *= 4)
        we.add(spp, [&](int seed) { return renderReady(ready, spp, frameSeed(static_cast<std::uint32_t>(seed), 1, false)).values; });
    double worst = 0;
    out["equal_error"] = json::array();
    for (std::size_t i = 0; i < they.curve.size(); ++i) {
        const ErrorPoint &point = they.curve[i];
        const double samples = samplesToReach(we.curve, point.error);
        const double seconds = ours[i].at(samples);
        const double ratio = seconds / theirs.at(point.samples);
        worst = std::max(worst, ratio);
        out["equal_error"].push_back({{"cycles_spp", point.samples},
                                      {"mse", point.error},
                                      {"our_spp", samples},
                                      {"cycles_seconds", theirs.at(point.samples)},
                                      {"our_seconds", seconds},
                                      {"time_ratio", ratio}});
    }
    out["our_errors"] = json::array();
    for (const ErrorPoint &point : we.curve) out["our_errors"].push_back({{"spp", point.samples}, {"mse", point.error}});
    out["equal_error_time_ratio_to_cycles"] = worst;
    out["images"] = {{"mean_ratio", we.mean() / they.mean()},
                     {"relative_difference", expectedDifference(we.images[0], we.images[1], they.images[0], they.images[1])}};
}

json memoryJson(const MemoryUse &use) {
    const auto perTriangle = [&](std::size_t bytes) { return static_cast<double>(bytes) / static_cast<double>(use.triangles); };
    return {{"triangles", use.triangles},
            {"vertices", use.vertices},
            {"bytes_per_triangle",
             {{"embree", perTriangle(use.embree)},
              {"shown", perTriangle(use.shown)},
              {"motion", perTriangle(use.motion)},
              {"source", perTriangle(use.source)},
              {"policy", perTriangle(use.policy)},
              {"total", perTriangle(use.total())},
              {"least", perTriangle(use.least())}}},
            {"ratio_to_least", static_cast<double>(use.rendering()) / static_cast<double>(use.least())},
            {"ratio_with_source", static_cast<double>(use.total()) / static_cast<double>(use.least())}};
}

} // namespace

json measureBench(const BenchScene &bench, const BenchOptions &options) {
    Scene scene = bench.make();
    scene.render.spp = options.spp; // what a plan reckons with
    const auto frames = static_cast<double>(scene.render.frames.size());
    RenderScene ready(scene, frames > 1);
    StageTimes building;
    ready.setFrame(scene.render.frames.front(), building);
    renderAll(ready, 1);                              // memory is touched, caches are warm
    std::map<std::string, std::vector<double>> rates; // [rounds]
    std::vector<double> cyclesFixed;
    std::vector<double> cyclesPerSample;
    double peak = 0;
    Ours total;
    std::optional<RayRecord> record;
    std::optional<CyclesPeer> cycles;
    double cyclesPeak = 0;
    for (int round = 0; round < options.rounds; ++round) {
        const Ours ours = renderAll(ready, options.spp);
        if (round == 0) {
            peak = peakMegabytes();
            if (options.cycles) {
                cycles.emplace(ready, options.threads);
                renderAll(*cycles, scene.render, 1);
            }
            record = recordRays(ready, options.recordSpp, frameSeed(0, scene.render.frames.back(), false));
        }
        total.stages += ours.stages;
        total.counts += ours.counts;
        total.traced += ours.traced;
        const auto add = [&](const char *name, double rate) {
            rates[name].push_back(rate);
            return rate;
        };
        const auto recorded = static_cast<double>(record->camera.size() + record->scattered.size() + record->shadow.size());
        const auto paths = static_cast<double>(ours.counts.paths);
        const double samples = add("samples_per_s", paths / ours.seconds());
        const double rays = add("rays_per_s", static_cast<double>(ours.counts.rays()) / ours.traced);
        const double bare = add("embree_rays_per_s", recorded / replayRays(ready.embree(), *record, 1).total());
        add("ratio_to_embree", rays / bare);
        if (!cycles) continue;
        const Theirs theirs = renderAll(*cycles, scene.render, options.spp);
        add("ratio_to_cycles", samples / add("cycles_samples_per_s", paths / theirs.seconds));
        cyclesPerSample.push_back(theirs.traced / options.spp);
        cyclesFixed.push_back(theirs.seconds / frames - theirs.traced);
        cyclesPeak = theirs.peakMb;
    }
    const StageTimes &stages = total.stages;
    const double inThreads = stages.cameraRays + stages.scatteredRays + stages.shadowRays + stages.shading + stages.film;
    const double perThread = inThreads > 0 ? total.traced / inThreads : 0; // thread seconds to wall clock
    const double seconds = total.seconds();
    const double measuredFrames = frames * options.rounds;
    json out{{"name", bench.name},
             {"frames", frames},
             {"spp", options.spp},
             {"rounds", options.rounds},
             {"foreground", foregroundOf(ready)},
             {"rays_per_sample", static_cast<double>(total.counts.rays()) / static_cast<double>(total.counts.paths)},
             {"ratio_to_cycles", nullptr},
             {"cycles_samples_per_s", nullptr},
             {"equal_error_time_ratio_to_cycles", nullptr},
             {"share",
              {{"deformation", stages.deformation / seconds},
               {"gradient", stages.gradient / seconds},
               {"bvh", stages.bvh / seconds},
               {"traversal", (stages.cameraRays + stages.scatteredRays + stages.shadowRays) * perThread / seconds},
               {"shading", stages.shading * perThread / seconds},
               {"film", stages.film * perThread / seconds}}},
             {"seconds_per_frame", seconds / measuredFrames},
             {"update_seconds_per_frame", total.updates() / measuredFrames},
             {"peak_mb", peak},
             {"cycles_peak_mb", cycles ? json(cyclesPeak) : json(nullptr)},
             {"memory", memoryJson(memoryUse(ready))}};
    out["foreground_samples_per_s"] = out["foreground"].get<double>() * quartilesOf(rates["samples_per_s"]).median;
    for (const auto &[name, values] : rates) {
        const Quartiles q = quartilesOf(values);
        out[name] = q.median;
        out["spread"][name] = {q.lower, q.median, q.upper};
    }
    if (cycles && options.equalError) {
        // What a frame of ours costs: the update, unless there is one frame, which is built once and not counted in either.
        const double pixels = static_cast<double>(scene.render.width) * scene.render.height;
        const double update = frames > 1 ? total.updates() / measuredFrames : 0;
        const FrameCost timed{update, pixels * total.traced / static_cast<double>(total.counts.paths)};
        std::array<FrameCost, kCompared.size()> ours;
        for (std::size_t i = 0; i < ours.size(); ++i)
            ours[i] = frames > 1 ? costAtSamples(scene, kCompared[i], ready, options, timed) : timed;
        const FrameCost theirs{std::max(0.0, quartilesOf(cyclesFixed).median), quartilesOf(cyclesPerSample).median};
        measureEqualError(bench, options, *cycles, ours, theirs, out);
    }
    return out;
}

json measureApart(const BenchScene &bench, const BenchOptions &options) {
    int channel[2];
    if (pipe(channel) != 0) throw RunError("can't make a pipe");
    const pid_t child = fork();
    if (child < 0) throw RunError("can't start a process");
    if (child == 0) {
        close(channel[0]);
        int code = 0;
        try {
            const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(options.threads));
            const std::string text = measureBench(bench, options).dump();
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
    return json::parse(text);
}

} // namespace taut::chart
