#include "taut/render/integrator.h"

#include "taut/render/denoise_sums.h"
#include "taut/render/path_state.h"

#include "taut/base/stopwatch.h"

#include <algorithm>

namespace taut {

namespace {

/// Most paths in flight a thread.
constexpr int kMostPaths = 2048;

} // namespace

RayCounts &RayCounts::operator+=(const RayCounts &other) {
    paths += other.paths;
    camera += other.camera;
    scattered += other.scattered;
    shadow += other.shadow;
    notFinite += other.notFinite;
    return *this;
}

PathTracer::PathTracer(const RenderScene &scene, const std::vector<PreparedMaterial> &materials, const TraceSettings &settings)
    : state_(std::make_unique<State>(scene, materials, settings)) {
    State &s = *state_;
    for (const PreparedMaterial &material : materials) s.laneMaterials.push_back(laneMaterial(material));
    for (const RenderObject &object : scene.objects()) {
        using Way = State::LaneObject;
        const bool still = object.steps.size() == 1 && object.placements.size() <= 1;
        const Way plain = still ? Way::Still : Way::Moving;
        const Way other = object.storedPoisson.empty() ? Way::Other : Way::Stored;
        s.laneObjects.push_back(settings.oneByOne ? Way::Alone : isPlain(object) ? plain : other);
    }
    s.waiting.resize(materials.size());
    for (const PreparedMaterial &material : materials) s.hasMedia |= material.extinction != Vec3(0);
    for (const PreparedMaterial &material : materials) s.hasCones |= material.filters;
    for (const RenderObject &object : scene.objects()) s.hasEmitters |= emits(*object.object);
}
PathTracer::~PathTracer() = default;

void PathTracer::State::shadeAll(int event, const FirstHitOutputs &outputs) {
    nextRays.clear();
    stillActive.clear();
    shadowRays.clear();
    shadowTests.clear();
    shadowGroups.clear();
    const bool hasIds = event == 0 && settings.layers != nullptr && settings.layers->hasIds;
    const bool lightsMayBeMet = !scene.lights().parts.empty();
    for (std::size_t i = 0; i < active.size(); ++i) {
        Path &path = paths[active[i]];
        if (lightsMayBeMet && meetLights(path, rays[i], hits[i].t)) continue;
        if (hasIds && hits[i].geometry != kNone) noteFirstHit(i);
        if (hits[i].geometry == kNone)
            escape(i);
        else if (!waits(event, i))
            shade(event, active[i], rays[i], hits[i], outputs);
    }
    lookUpEscaped();
    for (std::size_t m = 0; m < waiting.size(); ++m) {
        const std::span<const Index> all = waiting[m];
        for (std::size_t begin = 0; begin < all.size(); begin += HitLanes::kSize)
            shadeAtOnce(event, laneMaterials[m], all.subspan(begin, std::min<std::size_t>(HitLanes::kSize, all.size() - begin)), outputs);
        waiting[m].clear();
    }
    active.swap(stillActive);
    rays.swap(nextRays);
}

void PathTracer::State::intersect(int event) {
    hits.resize(rays.size());
    if (!scene.surfacesMayBeAbsent()) return scene.embree().intersect(rays, event == 0, hits);
    const Surfaces test(*this, false, dimensionOf(event, kSurfaces));
    scene.embree().intersect(rays, event == 0, hits, &test);
}

/// Beer's law on the way to the next surface; what finds none was never inside of one.
void PathTracer::State::attenuate() {
    for (std::size_t i = 0; i < active.size(); ++i) {
        Path &path = paths[active[i]];
        if (path.extinction != Vec3(0) && hits[i].geometry != kNone) path.throughput *= glm::exp(-path.extinction * hits[i].t);
    }
}

void PathTracer::State::testShadows(int event) {
    blocked.resize(shadowRays.size());
    if (scene.surfacesMayBeAbsent()) {
        const Surfaces test(*this, true, dimensionOf(event, kShadowSurfaces));
        scene.embree().occluded(shadowRays, blocked, &test);
    } else {
        scene.embree().occluded(shadowRays, blocked);
    }
    for (std::size_t i = 0; i < shadowTests.size(); ++i)
        if (blocked[i] == 0) addLight(paths[shadowTests[i].path], shadowTests[i].contribution, [&] { return shadowGroups[i]; });
}

int PathTracer::samplesABatch(const Window &tile) {
    return std::max(1, kMostPaths / std::max(1, tile.width() * tile.height()));
}

bool PathTracer::traceTile(const Window &tile, int firstSample, int lastSample, const FilmAccess &access, StageTimes &times,
                           RayCounts &counts) {
    State &s = *state_;
    const int step = samplesABatch(tile);
    Film &film = access.film;
    const FirstHitOutputs outputs{film.aovs(), static_cast<std::size_t>(film.aovChannels())};
    if (film.denoiseSums() != nullptr) s.probeTile(tile, access, times);
    for (int first = firstSample; first < lastSample; first += step) {
        Stopwatch watch;
        s.startPaths(tile, first, std::min(first + step, lastSample));
        s.aovs.assign(s.paths.size() * outputs.channels, 0.0F);
        s.startLayers();
        counts.paths += s.paths.size();
        for (int event = 0; !s.active.empty(); ++event) {
            if (access.stop.load(std::memory_order_relaxed)) return false;
            (event == 0 ? counts.camera : counts.scattered) += s.rays.size();
            if (s.settings.record != nullptr) {
                auto &into = event == 0 ? s.settings.record->camera : s.settings.record->scattered;
                into.insert(into.end(), s.rays.begin(), s.rays.end());
            }
            times.shading += watch.lap();
            s.intersect(event);
            (event == 0 ? times.cameraRays : times.scatteredRays) += watch.lap();
            if (s.hasMedia) s.attenuate();
            s.shadeAll(event, outputs);
            times.shading += watch.lap();
            counts.shadow += s.shadowRays.size();
            if (s.settings.record != nullptr)
                s.settings.record->shadow.insert(s.settings.record->shadow.end(), s.shadowRays.begin(), s.shadowRays.end());
            s.testShadows(event);
            times.shadowRays += watch.lap();
        }
        const std::lock_guard lock(access.lock);
        for (std::size_t i = 0; i < s.paths.size(); ++i) {
            Path &path = s.paths[i];
            if (!isFinite(path.radiance)) {
                ++counts.notFinite;
                path.radiance = Vec3(0);
            }
            film.add(path.x, path.y, path.radiance, path.alpha, path.hasAovs ? s.aovs.data() + i * outputs.channels : nullptr);
            if (s.settings.layers != nullptr) film.addLayers(path.x, path.y, path.radiance, s.layerSample(i));
            if (DenoiseSums *sums = film.denoiseSums(); sums != nullptr)
                sums->add(path.x, path.y, path.sample, path.radiance, path.alpha > 0);
            if (SharedSums *sums = film.sharedSums(); sums != nullptr && s.settings.shared)
                sums->add(path.x, path.y, sharedSample(*s.settings.shared, path.x, path.y, s.places[i]), path.radiance, path.alpha);
        }
        times.film += watch.lap();
    }
    return true;
}

} // namespace taut
