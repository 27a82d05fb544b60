#include "taut/render/render_frame.h"

#include "taut/base/parallel.h"
#include "taut/base/sobol.h"
#include "taut/render/adaptive.h"

#include <tbb/enumerable_thread_specific.h>

#include <algorithm>
#include <chrono>
#include <mutex>

namespace taut {

namespace {

constexpr int kTile = 16;
/// Samples a pass where time may run out between passes.
constexpr int kTimedPass = 4;
/// Blocks of adaptive sampling that one task traces.
constexpr std::size_t kBlocksATask = 8;

std::vector<Window> tilesOf(const Window &window) {
    std::vector<Window> tiles;
    for (int y = window.y0; y < window.y1; y += kTile)
        for (int x = window.x0; x < window.x1; x += kTile)
            tiles.push_back({x, y, std::min(x + kTile, window.x1), std::min(y + kTile, window.y1)});
    return tiles;
}

struct Worker {
    PathTracer tracer;
    StageTimes times;
    RayCounts counts;
    BlockScratch scratch;
};
using Workers = tbb::enumerable_thread_specific<Worker>;

/// What the passes over a frame have in common.
struct Passes {
    const FrameOptions &options;
    Workers &workers;
    FrameResult &result;
    std::chrono::steady_clock::time_point start = std::chrono::steady_clock::now();
    std::mutex progressMutex{};

    [[nodiscard]] double elapsed() const { return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count(); }
    [[nodiscard]] bool timeIsOver() const { return options.seconds && elapsed() >= *options.seconds; }
    /// `share` of the samples is done.
    void tell(double share) {
        if (!options.progress) return;
        options.progress(std::min(1.0, options.seconds ? std::max(share, elapsed() / *options.seconds) : share));
    }
};

/// The same number of samples for every pixel.
void renderEvenly(Passes &passes) {
    const FrameOptions &options = passes.options;
    const std::vector<Window> tiles = tilesOf(passes.result.film.window());
    const int passSamples = options.seconds ? kTimedPass : options.spp;
    std::size_t tilesDone = 0;
    for (int first = 0; first < options.spp; first += passSamples) {
        const int last = std::min(first + passSamples, options.spp);
        parallelFor(tiles.size(), 1, [&](std::size_t i) {
            Worker &worker = passes.workers.local();
            worker.tracer.traceTile(tiles[i], first, last, passes.result.film, worker.times, worker.counts);
            const std::lock_guard lock(passes.progressMutex);
            ++tilesDone;
            passes.tell((static_cast<double>(tilesDone) / static_cast<double>(tiles.size())) * passSamples / options.spp);
        });
        if (passes.timeIsOver()) break;
    }
}

/// As many samples for each block as the noise of others asks for.
void renderAdaptively(Passes &passes) {
    Film &film = passes.result.film;
    AdaptiveBlocks blocks(film.window(), *passes.options.noise, passes.options.spp);
    while (!blocks.active().empty() && !passes.timeIsOver()) {
        parallelFor(blocks.active().size(), kBlocksATask, [&](std::size_t i) {
            Worker &worker = passes.workers.local();
            samplePass(blocks, blocks.active()[i], film, worker.scratch, [&](const Window &window, int first, int last) {
                worker.tracer.traceTile(window, first, last, film, worker.times, worker.counts);
            });
        });
        blocks.decide();
        passes.tell(blocks.done());
    }
}

} // namespace

std::uint32_t frameSeed(std::uint32_t seed, int frame, bool fixed) {
    return fixed ? hash(seed, 0U) : hash(seed, static_cast<std::uint32_t>(frame) + 1U);
}

FrameResult renderFrame(const RenderScene &scene, const FrameOptions &options) {
    const RenderSettings &render = scene.scene().render;
    const Window window = options.window.width() > 0 ? options.window : Window{0, 0, render.width, render.height};
    const std::vector<PreparedMaterial> materials = prepareMaterials(scene.scene(), scene.plan());
    const TraceSettings settings{render.width, render.height,  render.maxEvents, render.boxFilter,
                                 options.seed, options.record, options.oneByOne};
    Workers workers([&] { return Worker{PathTracer(scene, materials, settings), {}, {}, {}}; });
    FrameResult result{Film(window, options.aovs), {}, {}, 0};
    Passes passes{options, workers, result};
    if (options.noise)
        renderAdaptively(passes);
    else
        renderEvenly(passes);
    for (const Worker &worker : workers) {
        result.times += worker.times;
        result.counts += worker.counts;
    }
    result.seconds = passes.elapsed();
    return result;
}

} // namespace taut
