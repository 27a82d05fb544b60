#include "measure.h"

#include "study/cycles_peer.h"
#include "study/equal_error.h"

#include "taut/base/error.h"
#include "taut/render/image_file.h"
#include "taut/render/memory_use.h"
#include "taut/render/frame_render.h"
#include "study/replay.h"

#include <tbb/global_control.h>

#include <sys/resource.h>
#include <unistd.h>

#include <array>
#include <optional>

namespace taut::bench {

namespace fs = std::filesystem;
using namespace taut::chart;
using nlohmann::json;

namespace {

double peakMegabytes() {
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    return static_cast<double>(usage.ru_maxrss) / 1024;
}

/// A folder of its own, removed with everything in it at the end.
class ScratchFolder {
  public:
    ScratchFolder() {
        std::string name = (fs::temp_directory_path() / "taut_bench.XXXXXX").string();
        if (mkdtemp(name.data()) == nullptr) throw RunError("can't make a folder in " + fs::temp_directory_path().string());
        path_ = name;
    }
    ~ScratchFolder() {
        std::error_code ignored;
        fs::remove_all(path_, ignored);
    }
    ScratchFolder(const ScratchFolder &) = delete;
    ScratchFolder &operator=(const ScratchFolder &) = delete;
    [[nodiscard]] const fs::path &path() const { return path_; }

  private:
    fs::path path_;
};

/// All frames of the scene, rendered once; a single frame is set already.
struct Ours {
    StageTimes stages;
    RayCounts counts;
    double traced = 0; ///< wall clock
    [[nodiscard]] double updates() const { return stages.deformation + stages.gradient + stages.bvh; }
    [[nodiscard]] double seconds() const { return updates() + traced; }
};

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

/// Rays of the frame that `ready` is at, in the order in which one thread traces them.
RayRecord recordRays(const RenderScene &ready, int spp) {
    RayRecord record;
    const tbb::global_control oneThread(tbb::global_control::max_allowed_parallelism, 1);
    FrameOptions options;
    options.spp = spp;
    options.seed = frameSeed(0, ready.scene().render.frames.back(), false);
    options.record = &record;
    renderFrame(ready, options);
    return record;
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
    CyclesRequest request{0, spp, 0, render.width, render.height, {}};
    CyclesTimes last;
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

/// Red, green and blue of a frame of `size` x `size` pixels by us; a scene of the same meshes and lights.
std::vector<float> ourImage(const RenderScene &ready, int spp, std::uint32_t seed) {
    FrameOptions options;
    options.spp = spp;
    options.seed = frameSeed(seed, 1, false);
    const std::vector<float> values = renderFrame(ready, options).film.resolve();
    std::vector<float> rgb;
    for (std::size_t i = 0; i < values.size(); i += 4)
        rgb.insert(rgb.end(), values.begin() + static_cast<std::ptrdiff_t>(i), values.begin() + static_cast<std::ptrdiff_t>(i) + 3);
    return rgb;
}

std::vector<float> cyclesImage(CyclesPeer &cycles, CyclesRequest request, const fs::path &folder) {
    request.output = folder / "cycles.exr";
    cycles.render(request);
    return readCyclesImage(request.output);
}

double meanOf(const std::vector<float> &values) {
    double sum = 0;
    for (const float v : values) sum += static_cast<double>(v);
    return sum / static_cast<double>(values.size());
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
FrameCost costAtSamples(Scene scene, int spp, RenderScene &ready, const MeasureOptions &options, const FrameCost &timed) {
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
    return {timed.fixed * spreadOf(updates).median, timed.perSample * spreadOf(traced).median};
}

/// Errors of both renderers from two seeds each, over the samples; the times to equal error; how far the images agree. `ours`: for
/// every number of samples that is compared.
void measureEqualError(const BenchScene &bench, const MeasureOptions &options, CyclesPeer &cycles, const fs::path &folder,
                       const std::array<FrameCost, kCompared.size()> &ours, const FrameCost &theirs, json &out) {
    Scene scene = bench.make();
    scene.render.width = scene.render.height = options.errorSize;
    for (Object &object : scene.objects) object.follow = false; // as Cycles sees it
    RenderScene ready(scene, false);
    StageTimes ignored;
    ready.setFrame(scene.render.frames.back(), ignored);
    std::vector<ErrorPoint> theirCurve;
    std::vector<float> theirs1;
    std::vector<float> theirs2;
    for (const int spp : kCompared) {
        CyclesRequest request{bench.frames - 1, spp, 1, options.errorSize, options.errorSize, {}};
        theirs1 = cyclesImage(cycles, request, folder);
        request.seed = 2;
        theirs2 = cyclesImage(cycles, request, folder);
        theirCurve.push_back({static_cast<double>(spp), errorOfTwo(theirs1, theirs2)});
    }
    std::vector<ErrorPoint> ourCurve;
    std::vector<float> ours1;
    std::vector<float> ours2;
    const double least = theirCurve.back().error;
    for (int spp = 4; spp <= 256 || (spp <= kMostSamples && ourCurve.back().error > least); spp *= 4) {
        ours1 = ourImage(ready, spp, 1);
        ours2 = ourImage(ready, spp, 2);
        ourCurve.push_back({static_cast<double>(spp), errorOfTwo(ours1, ours2)});
    }
    double worst = 0;
    out["equal_error"] = json::array();
    for (std::size_t i = 0; i < theirCurve.size(); ++i) {
        const ErrorPoint &point = theirCurve[i];
        const double samples = samplesToReach(ourCurve, point.error);
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
    for (const ErrorPoint &point : ourCurve) out["our_errors"].push_back({{"spp", point.samples}, {"mse", point.error}});
    out["equal_error_time_ratio_to_cycles"] = worst;
    out["images"] = {{"mean_ratio", (meanOf(ours1) + meanOf(ours2)) / (meanOf(theirs1) + meanOf(theirs2))},
                     {"relative_difference", expectedDifference(ours1, ours2, theirs1, theirs2)}};
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

json spreadJson(const Spread &spread) {
    return {spread.lower, spread.median, spread.upper};
}

} // namespace

json measure(const BenchScene &bench, const MeasureOptions &options) {
    Scene scene = bench.make();
    scene.render.spp = options.spp; // what a plan reckons with
    const auto frames = static_cast<double>(scene.render.frames.size());
    RenderScene ready(scene, frames > 1);
    StageTimes building;
    ready.setFrame(scene.render.frames.front(), building);
    renderAll(ready, 1); // memory is touched, caches are warm
    std::vector<double> samplesPerSecond;
    std::vector<double> raysPerSecond;
    std::vector<double> embreeRaysPerSecond;
    std::vector<double> toEmbree;
    std::vector<double> toCycles;
    std::vector<double> cyclesSamplesPerSecond;
    std::vector<double> cyclesFixed;
    std::vector<double> cyclesPerSample;
    double peak = 0;
    Ours total;
    std::optional<RayRecord> record;
    std::optional<ScratchFolder> folder;
    std::optional<CyclesPeer> cycles;
    double cyclesPeak = 0;
    for (int round = 0; round < options.rounds; ++round) {
        const Ours ours = renderAll(ready, options.spp);
        if (round == 0) {
            peak = peakMegabytes();
            if (options.cycles) {
                folder.emplace();
                writeCyclesScene(ready, options.threads, folder->path());
                cycles.emplace(folder->path());
                renderAll(*cycles, scene.render, 1);
            }
            record = recordRays(ready, options.recordSpp);
        }
        total.stages += ours.stages;
        total.counts += ours.counts;
        total.traced += ours.traced;
        const auto rays = static_cast<double>(record->camera.size() + record->scattered.size() + record->shadow.size());
        samplesPerSecond.push_back(static_cast<double>(ours.counts.paths) / ours.seconds());
        raysPerSecond.push_back(static_cast<double>(ours.counts.rays()) / ours.traced);
        embreeRaysPerSecond.push_back(rays / replayRays(ready.embree(), *record, 1).total());
        toEmbree.push_back(raysPerSecond.back() / embreeRaysPerSecond.back());
        if (!cycles) continue;
        const Theirs theirs = renderAll(*cycles, scene.render, options.spp);
        cyclesSamplesPerSecond.push_back(static_cast<double>(ours.counts.paths) / theirs.seconds);
        toCycles.push_back(samplesPerSecond.back() / cyclesSamplesPerSecond.back());
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
             {"samples_per_s", spreadOf(samplesPerSecond).median},
             {"rays_per_s", spreadOf(raysPerSecond).median},
             {"rays_per_sample", static_cast<double>(total.counts.rays()) / static_cast<double>(total.counts.paths)},
             {"embree_rays_per_s", spreadOf(embreeRaysPerSecond).median},
             {"ratio_to_embree", spreadOf(toEmbree).median},
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
             {"cycles_peak_mb", nullptr},
             {"memory", memoryJson(memoryUse(ready))},
             {"spread",
              {{"samples_per_s", spreadJson(spreadOf(samplesPerSecond))},
               {"rays_per_s", spreadJson(spreadOf(raysPerSecond))},
               {"ratio_to_embree", spreadJson(spreadOf(toEmbree))}}}};
    if (!cycles) return out;
    out["ratio_to_cycles"] = spreadOf(toCycles).median;
    out["cycles_samples_per_s"] = spreadOf(cyclesSamplesPerSecond).median;
    out["spread"]["ratio_to_cycles"] = spreadJson(spreadOf(toCycles));
    out["cycles_peak_mb"] = cyclesPeak;
    if (options.equalError) {
        // What a frame of ours costs: the update, unless there is one frame, which is built once and not counted in either.
        const double pixels = static_cast<double>(scene.render.width) * scene.render.height;
        const double update = frames > 1 ? total.updates() / measuredFrames : 0;
        const FrameCost timed{update, pixels * total.traced / static_cast<double>(total.counts.paths)};
        std::array<FrameCost, kCompared.size()> ours;
        for (std::size_t i = 0; i < ours.size(); ++i)
            ours[i] = frames > 1 ? costAtSamples(scene, kCompared[i], ready, options, timed) : timed;
        const FrameCost theirs{std::max(0.0, spreadOf(cyclesFixed).median), spreadOf(cyclesPerSample).median};
        measureEqualError(bench, options, *cycles, folder->path(), ours, theirs, out);
    }
    return out;
}

} // namespace taut::bench
