#include "taut/render/render_frame.h"

#include "taut/base/parallel.h"
#include "taut/base/sobol.h"

#include <tbb/enumerable_thread_specific.h>

#include <algorithm>
#include <chrono>
#include <mutex>

namespace taut {

namespace {

constexpr int kTile = 16;
/// Samples a pass where time may run out between passes.
constexpr int kTimedPass = 4;

std::vector<Window> tilesOf(const Window &window) {
    std::vector<Window> tiles;
    for (int y = window.y0; y < window.y1; y += kTile)
        for (int x = window.x0; x < window.x1; x += kTile)
            tiles.push_back({x, y, std::min(x + kTile, window.x1), std::min(y + kTile, window.y1)});
    return tiles;
}

} // namespace

std::uint32_t frameSeed(std::uint32_t seed, int frame, bool fixed) {
    return fixed ? hash(seed, 0U) : hash(seed, static_cast<std::uint32_t>(frame) + 1U);
}

FrameResult renderFrame(const RenderScene &scene, const FrameOptions &options) {
    const RenderSettings &render = scene.scene().render;
    const Window window = options.window.width() > 0 ? options.window : Window{0, 0, render.width, render.height};
    const auto start = std::chrono::steady_clock::now();
    const auto elapsed = [&] { return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count(); };
    const std::vector<PreparedMaterial> materials = prepareMaterials(scene.scene(), scene.plan());
    const TraceSettings settings{render.width, render.height,  render.maxEvents, render.boxFilter,
                                 options.seed, options.record, options.oneByOne};

    struct Worker {
        PathTracer tracer;
        StageTimes times;
        RayCounts counts;
    };
    tbb::enumerable_thread_specific<Worker> workers([&] { return Worker{PathTracer(scene, materials, settings), {}, {}}; });

    FrameResult result{Film(window, options.aovs), {}, {}, 0};
    const std::vector<Window> tiles = tilesOf(window);
    const int passSamples = options.seconds ? kTimedPass : options.spp;
    std::mutex progressMutex;
    std::size_t tilesDone = 0;
    for (int first = 0; first < options.spp; first += passSamples) {
        const int last = std::min(first + passSamples, options.spp);
        parallelFor(tiles.size(), 1, [&](std::size_t i) {
            Worker &worker = workers.local();
            worker.tracer.traceTile(tiles[i], first, last, result.film, worker.times, worker.counts);
            const std::lock_guard lock(progressMutex);
            ++tilesDone;
            if (!options.progress) return;
            const double bySamples = (static_cast<double>(tilesDone) / static_cast<double>(tiles.size())) * passSamples / options.spp;
            options.progress(std::min(1.0, options.seconds ? std::max(bySamples, elapsed() / *options.seconds) : bySamples));
        });
        result.film.addSamples(last - first);
        if (options.seconds && elapsed() >= *options.seconds) break;
    }
    for (const Worker &worker : workers) {
        result.times += worker.times;
        result.counts += worker.counts;
    }
    result.seconds = elapsed();
    return result;
}

} // namespace taut
