#include "taut/render/frame_render.h"

#include "taut/base/error.h"
#include "taut/base/parallel.h"
#include "taut/base/sobol.h"
#include "taut/render/frame_window.h"
#include "taut/render/light_groups.h"

#include <tbb/enumerable_thread_specific.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <istream>
#include <mutex>
#include <ostream>

namespace taut {

namespace {

using Clock = std::chrono::steady_clock;

constexpr int kTile = AdaptivePasses::kTile;
/// What the seed of random numbers beside the film's is hashed with.
constexpr std::uint32_t kOtherNumbers = 0x0c047201;
constexpr std::string_view kFrameMagic = "taut frame 1\n";

struct Worker {
    PathTracer tracer;
    StageTimes times;
    RayCounts counts;
    PassScratch scratch;
};

double secondsSince(Clock::time_point start) {
    return std::chrono::duration<double>(Clock::now() - start).count();
}

} // namespace

struct FrameRender::State {
    State(const RenderScene &scene_, const FrameOptions &options_)
        : options(options_), film(affordable(scene_.scene(), windowOf(options_, scene_.scene().render), options_.shares), options_.aovs,
                                  layersOf(options_.layers, scene_.scene()), options_.denoiseBlock, options_.shares),
          layers(layerTables(scene_, film.layers())), materials(prepareMaterials(scene_.scene(), scene_.plan())), workers([&scene_, this] {
              return Worker{PathTracer(scene_, materials, settingsOf(scene_, options.seed)), {}, {}, {}};
          }),
          otherWorkers([&scene_, this] {
              TraceSettings settings = settingsOf(scene_, hash(options.seed, kOtherNumbers));
              settings.record = nullptr;
              settings.layers = nullptr;
              settings.before = nullptr;
              return Worker{PathTracer(scene_, materials, settings), {}, {}, {}};
          }),
          tiles(tilesOf(film.window())), tileLocks(tiles.size()) {
        if (options.noise) passes.emplace(film.window(), *options.noise, options.spp);
        if (options.picture) passes.emplace(film.window(), *options.picture, options.spp, options.seed);
    }

    FrameOptions options;
    Film film;
    LayerTables layers;
    std::vector<PreparedMaterial> materials;
    tbb::enumerable_thread_specific<Worker> workers;
    tbb::enumerable_thread_specific<Worker> otherWorkers; ///< with other random numbers, for what is not in the film
    std::vector<Window> tiles;
    mutable std::vector<std::mutex> tileLocks; ///< [tiles], of the film's pixels; a block of adaptive sampling lies in one tile
    std::optional<AdaptivePasses> passes;
    std::vector<Film> again; ///< [controls] with other random numbers, as far as rendered

    mutable std::mutex running; ///< held by advance(), and by what must not go on beside it
    std::atomic<bool> stopAsked{false};
    std::atomic<std::uint64_t> pixelSamples{0}; ///< in the film, of frames that are not adaptive
    std::atomic<bool> telling{false};
    std::atomic<double> adaptiveShare{0};
    double seconds = 0;

    // Of the advance() that goes on.
    Clock::time_point deadline;
    bool hasDeadline = false;
    std::atomic<bool> gotFurther{false};

    [[nodiscard]] std::uint64_t pixels() const {
        return static_cast<std::uint64_t>(film.window().width()) * static_cast<std::uint64_t>(film.window().height());
    }
    [[nodiscard]] double share() const {
        if (passes) return adaptiveShare;
        return std::min(1.0, static_cast<double>(pixelSamples) / (static_cast<double>(pixels()) * options.spp));
    }
    [[nodiscard]] bool done() const { return passes ? passes->pieces().empty() : pixelSamples >= pixels() * options.spp; }

    /// Samples that a tile has.
    [[nodiscard]] int samplesOf(const Window &tile) const { return static_cast<int>(film.samplesAt(tile.x0, tile.y0)); }
    /// Whether work should not be started any more.
    [[nodiscard]] bool isOver() const { return stopAsked || (hasDeadline && gotFurther && Clock::now() >= deadline); }

    [[nodiscard]] TraceSettings settingsOf(const RenderScene &scene, std::uint32_t seed) const {
        const RenderSettings &render = scene.scene().render;
        const int limit = scene.plan().maxEvents;
        return {render.width,
                render.height,
                limit > 0 ? limit : render.maxEvents,
                render.boxFilter,
                seed,
                options.record,
                film.layers().hasSums() ? &layers : nullptr,
                options.independent,
                options.oneByOne,
                options.before,
                options.shares ? std::optional(film.window()) : std::nullopt};
    }
    void tell();
    [[nodiscard]] std::size_t tileAt(int x, int y) const {
        const Window &w = film.window();
        const int columns = (w.x1 - 1) / kTile - w.x0 / kTile + 1;
        return static_cast<std::size_t>((y / kTile - w.y0 / kTile) * columns + x / kTile - w.x0 / kTile);
    }
    void advanceEvenly(const FrameBudget &budget);
    void advanceTile(std::size_t i, int last);
    void advanceAdaptively(bool onePass);
    [[nodiscard]] std::vector<std::vector<double>> renderAgain(const std::vector<PassPiece> &pieces);
    void saveHead(std::ostream &out) const;
    void checkHead(std::istream &in) const;
};

/// Only one thread tells; the others do not wait for it.
void FrameRender::State::tell() {
    if (!options.progress || telling.exchange(true)) return;
    if (!options.progress(share())) stopAsked = true;
    telling = false;
}

/// A tile's samples up to number `last`, in batches.
void FrameRender::State::advanceTile(std::size_t i, int last) {
    const Window &tile = tiles[i];
    const std::uint64_t area = static_cast<std::uint64_t>(tile.width()) * static_cast<std::uint64_t>(tile.height());
    Worker &worker = workers.local();
    const int batch = PathTracer::samplesABatch(tile);
    for (int first = samplesOf(tile); first < last && !isOver(); first += batch) {
        const int end = std::min(first + batch, last);
        if (!worker.tracer.traceTile(tile, options.firstSample + first, options.firstSample + end, {film, tileLocks[i], stopAsked},
                                     worker.times, worker.counts))
            return;
        pixelSamples += area * static_cast<std::uint64_t>(end - first);
        gotFurther = true;
    }
}

/// Passes of as many samples for every pixel; 0: one pass with all.
void FrameRender::State::advanceEvenly(const FrameBudget &budget) {
    const int samples = budget.samples;
    int least = options.spp;
    for (const Window &tile : tiles) least = std::min(least, samplesOf(tile));
    const int last = samples > 0 ? std::min(least + samples, options.spp) : options.spp;
    const int pass = samples == 0 && hasDeadline && budget.evenly ? kTimedPass : last - least;
    for (int to = least; to < last && !isOver();) {
        to = std::min(to + pass, last);
        parallelFor(tiles.size(), 1, [&](std::size_t i) {
            advanceTile(i, to);
            tell();
        });
    }
}

/// Sums of pieces of the frame with other random numbers than the film's. None where it was stopped.
std::vector<std::vector<double>> FrameRender::State::renderAgain(const std::vector<PassPiece> &pieces) {
    if (again.size() != pieces.size()) {
        again.clear();
        for (const PassPiece &piece : pieces) again.emplace_back(piece.window, std::vector<Aov>{}, FilmLayers{}, 0, options.shares);
    }
    std::vector<std::vector<double>> sums(pieces.size());
    parallelFor(pieces.size(), 1, [&](std::size_t i) {
        const Window &window = pieces[i].window;
        const auto first = static_cast<int>(again[i].samplesAt(window.x0, window.y0));
        std::mutex lock;
        Worker &worker = otherWorkers.local();
        if (isOver() || !worker.tracer.traceTile(window, first, pieces[i].last, {again[i], lock, stopAsked}, worker.times, worker.counts))
            return;
        ColourSums::fill(again[i], window, sums[i]);
    });
    const bool whole = std::none_of(sums.begin(), sums.end(), [](const auto &s) { return s.empty(); });
    return whole ? sums : std::vector<std::vector<double>>{};
}

/// As many samples for each block as the noise of others asks for.
void FrameRender::State::advanceAdaptively(bool onePass) {
    const auto isMade = [&](const PassPiece &piece) {
        return film.samplesAt(piece.window.x0, piece.window.y0) >= static_cast<std::uint32_t>(piece.last);
    };
    while (!passes->pieces().empty() && !isOver()) {
        const std::vector<PassPiece> &pieces = passes->pieces();
        parallelFor(pieces.size(), passes->piecesATask(), [&](std::size_t i) {
            if (isOver() || isMade(pieces[i])) return; // a pass over a piece is made whole or not at all
            Worker &worker = workers.local();
            static const std::atomic<bool> kGoOn{false};
            passes->make(pieces[i], film, worker.scratch, [&](const Window &part, int first, int last) {
                const RayCounts before = worker.counts;
                worker.tracer.traceTile(part, first, last, {film, tileLocks[tileAt(part.x0, part.y0)], kGoOn}, worker.times, worker.counts);
                const std::uint64_t camera = worker.counts.camera - before.camera;
                return costOf(camera, worker.counts.rays() - before.rays() - camera);
            });
            gotFurther = true;
        });
        if (!std::all_of(pieces.begin(), pieces.end(), isMade)) return;
        const std::vector<PassPiece> controls = passes->drawControls(film);
        const std::vector<std::vector<double>> others = renderAgain(controls);
        if (others.size() < controls.size()) return;
        passes->decide(film, controls, others);
        adaptiveShare = passes->share();
        tell();
        if (onePass) return;
    }
}

FrameRender::FrameRender(const RenderScene &scene, const FrameOptions &options) {
    checkOptions(options, scene.scene().render);
    state_ = std::make_unique<State>(scene, options);
}
FrameRender::~FrameRender() = default;

FrameState FrameRender::advance(const FrameBudget &budget) {
    State &s = *state_;
    const std::lock_guard lock(s.running);
    const auto start = Clock::now();
    s.hasDeadline = budget.seconds > 0;
    if (s.hasDeadline) s.deadline = start + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(budget.seconds));
    s.gotFurther = false;
    if (s.passes)
        s.advanceAdaptively(budget.samples > 0);
    else
        s.advanceEvenly(budget);
    s.seconds += secondsSince(start);
    s.tell();
    const bool stopped = s.stopAsked.exchange(false);
    return s.done() ? FrameState::Done : stopped ? FrameState::Stopped : FrameState::Going;
}

void FrameRender::stop() noexcept {
    state_->stopAsked = true;
}

bool FrameRender::done() const {
    const std::lock_guard lock(state_->running);
    return state_->done();
}

double FrameRender::share() const {
    return state_->share();
}

Film FrameRender::film() const {
    const State &s = *state_;
    Film film(s.film.window(), s.film.aovs(), s.film.layers(), s.film.denoiseBlock(), s.options.shares);
    for (std::size_t i = 0; i < s.tiles.size(); ++i) {
        const std::lock_guard lock(s.tileLocks[i]);
        film.copy(s.film, s.tiles[i]);
    }
    return film;
}

const Film &FrameRender::filmAtRest() const {
    return state_->film;
}

Film FrameRender::takeFilm() && {
    const std::lock_guard lock(state_->running);
    return std::move(state_->film);
}

std::optional<PictureNoiseReached> FrameRender::reached() const {
    const std::lock_guard lock(state_->running);
    return state_->passes ? state_->passes->reached() : std::nullopt;
}

StageTimes FrameRender::times() const {
    const std::lock_guard lock(state_->running);
    StageTimes times;
    for (const auto *workers : {&state_->workers, &state_->otherWorkers})
        for (const Worker &worker : *workers) times += worker.times;
    return times;
}

RayCounts FrameRender::counts() const {
    const std::lock_guard lock(state_->running);
    RayCounts counts;
    for (const auto *workers : {&state_->workers, &state_->otherWorkers})
        for (const Worker &worker : *workers) counts += worker.counts;
    return counts;
}

double FrameRender::seconds() const {
    const std::lock_guard lock(state_->running);
    return state_->seconds;
}

namespace {

/// What a saved frame must share with the one that goes on.
struct PassesHead {
    std::uint32_t seed = 0;
    std::int32_t firstSample = 0;
    std::int32_t adaptive = 0; ///< 1: to the noise of every pixel; 3: of the picture
    std::int32_t most = 0;     ///< adaptive: samples a pixel
    double noise = 0;
};

PassesHead headOf(const FrameOptions &options) {
    if (options.picture) return {options.seed, options.picture->firstSamples, 3, options.spp, options.picture->noise};
    return {options.seed, options.firstSample, options.noise ? 1 : 0, options.noise ? options.spp : 0, options.noise.value_or(0)};
}

PassesHead readHead(std::istream &in) {
    std::string magic(kFrameMagic.size(), ' ');
    if (!in.read(magic.data(), static_cast<std::streamsize>(magic.size())) || magic != kFrameMagic)
        throw InputError("saved frame: found other bytes at its begin, expected 'taut frame 1'");
    PassesHead head;
    if (!in.read(reinterpret_cast<char *>(&head), sizeof head)) throw InputError("saved frame: found its end early, expected its head");
    return head;
}

template <class T> void expectSame(const char *what, T saved, T own) {
    if (saved != own)
        throw InputError(std::string("saved frame: found ") + what + ' ' + formatNumber(static_cast<double>(saved)) + ", expected " +
                         formatNumber(static_cast<double>(own)));
}

} // namespace

void FrameRender::State::saveHead(std::ostream &out) const {
    const PassesHead head = headOf(options);
    out << kFrameMagic;
    out.write(reinterpret_cast<const char *>(&head), sizeof head);
}

void FrameRender::State::checkHead(std::istream &in) const {
    const PassesHead head = readHead(in);
    const PassesHead own = headOf(options);
    expectSame("seed", head.seed, own.seed);
    expectSame("first sample", head.firstSample, own.firstSample);
    expectSame("adaptive", head.adaptive, own.adaptive);
    expectSame("samples a pixel", head.most, own.most);
    expectSame("noise", head.noise, own.noise);
}

void FrameRender::save(std::ostream &out) const {
    const State &s = *state_;
    const std::lock_guard lock(s.running);
    s.saveHead(out);
    s.film.save(out);
    if (s.passes) s.passes->save(out);
}

void FrameRender::restore(std::istream &in) {
    State &s = *state_;
    const std::lock_guard lock(s.running);
    s.checkHead(in);
    Film film = Film::load(in);
    if (film.window() != s.film.window()) throw InputError("saved frame: found other pixels, expected those of this frame's window");
    if (film.aovs() != s.film.aovs() || film.layers() != s.film.layers())
        throw InputError("saved frame: found other AOVs, expected those asked for");
    if (film.denoiseBlock() != s.film.denoiseBlock())
        throw InputError("saved frame: found other sums for denoising, expected those asked for");
    if ((film.sharedSums() != nullptr) != s.options.shares)
        throw InputError(std::string("saved frame: found pixels that ") + (s.options.shares ? "do not share" : "share") +
                         " their samples, expected the contrary");
    std::optional<AdaptivePasses> passes = s.passes;
    if (passes) passes->load(in);
    std::uint64_t pixelSamples = 0;
    for (const Window &tile : s.tiles)
        for (int y = tile.y0; y < tile.y1; ++y)
            for (int x = tile.x0; x < tile.x1; ++x) {
                const std::uint32_t samples = film.samplesAt(x, y);
                pixelSamples += samples;
                if (!passes && (samples != film.samplesAt(tile.x0, tile.y0) || samples > static_cast<std::uint32_t>(s.options.spp)))
                    throw InputError("saved frame: found " + std::to_string(samples) +
                                     " samples in one pixel of a tile, expected at most " + std::to_string(s.options.spp) +
                                     ", and as many in each");
            }
    s.film = std::move(film);
    s.passes = std::move(passes);
    s.again.clear();
    s.pixelSamples = pixelSamples;
    if (s.passes) s.adaptiveShare = s.passes->share();
}

Film FrameRender::savedFilm(std::istream &in) {
    readHead(in);
    return Film::load(in);
}

std::uint32_t frameSeed(std::uint32_t seed, int frame, bool fixed) {
    return fixed ? hash(seed, 0U) : hash(seed, static_cast<std::uint32_t>(frame) + 1U);
}

Image imageOf(const Film &film, const RenderSettings &render) {
    return {film.window(), render.width, render.height, film.channelNames(), film.resolve()};
}

} // namespace taut
