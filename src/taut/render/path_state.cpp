#include "taut/render/path_state.h"

namespace taut {

namespace {

/// Pixels are visited in blocks of this side, one sample each, so that 16 neighbouring camera rays make one packet.
constexpr int kPixelBlock = 4;

} // namespace

void PathTracer::State::startPaths(const Window &tile, int firstSample, int lastSample) {
    paths.clear();
    places.clear();
    rays.clear();
    active.clear();
    CameraLanes &l = *cameraLanes;
    l.count = 0;
    for (int sample = firstSample; sample < lastSample; ++sample)
        for (int by = tile.y0; by < tile.y1; by += kPixelBlock)
            for (int bx = tile.x0; bx < tile.x1; bx += kPixelBlock)
                for (int y = by; y < std::min(by + kPixelBlock, tile.y1); ++y)
                    for (int x = bx; x < std::min(bx + kPixelBlock, tile.x1); ++x) {
                        l.x[l.count] = x;
                        l.y[l.count] = y;
                        l.sample[l.count] = static_cast<std::uint32_t>(sample);
                        if (++l.count == CameraLanes::kSize) addPaths();
                    }
    addPaths();
}

/// Starts what the camera's lanes hold and empties them.
void PathTracer::State::addPaths() {
    CameraLanes &l = *cameraLanes;
    cameraRays(scene, settings, l);
    const std::size_t first = paths.size();
    const auto count = static_cast<std::size_t>(l.count);
    paths.resize(first + count);
    rays.resize(first + count);
    active.resize(first + count);
    for (std::size_t i = 0; i < count; ++i) {
        Path &path = paths[first + i];
        path.x = l.x[i];
        path.y = l.y[i];
        path.sample = l.sample[i];
        path.seed = l.seed[i];
        path.time = l.time[i];
        if (hasCones) path.cone = pixelCone(scene.camera(), settings.height);
        Ray &ray = rays[first + i];
        ray.origin = l.origin.at(i);
        ray.direction = l.direction.at(i);
        ray.time = l.time[i];
        active[first + i] = static_cast<Index>(first + i);
    }
    if (settings.shared)
        for (std::size_t i = 0; i < count; ++i) places.emplace_back(l.filterU[i], l.filterV[i]);
    l.count = 0;
}

void PathTracer::State::startLayers() {
    if (settings.layers == nullptr) return;
    groupLight.assign(paths.size() * settings.layers->groups, Vec3(0));
    if (settings.layers->hasIds) firstHits.assign(paths.size(), {});
}

/// Of camera ray `i`, which nothing hides from its hit.
void PathTracer::State::noteFirstHit(std::size_t i) {
    const Index owner = scene.objectOfGeometry(hits[i].geometry);
    const std::vector<std::uint32_t> &materialIds = settings.layers->materialIds;
    const Index material = materialOfTriangle(scene.objects()[owner], hits[i].primitive);
    firstHits[active[i]] = {settings.layers->objectIds[owner], materialIds[std::min<std::size_t>(material, materialIds.size() - 1)]};
}

Index PathTracer::State::groupOf(Index object, Index triangle) const {
    const std::vector<Index> &slots = settings.layers->objects[object];
    return slots[std::min<std::size_t>(slotOfTriangle(scene.objects()[object], triangle), slots.size() - 1)];
}

LayerSample PathTracer::State::layerSample(std::size_t path) const {
    LayerSample sample = settings.layers->hasIds ? firstHits[path] : LayerSample();
    if (hasGroups() && paths[path].radiance != Vec3(0)) sample.lights = &groupLight[path * settings.layers->groups];
    return sample;
}

/// Path `i` of the active leaves the scene.
void PathTracer::State::escape(std::size_t i) {
    const Environment *environment = scene.lights().environment;
    Path &path = paths[active[i]];
    if (environment == nullptr || (path.scatterPdf == 0 && !environment->cameraVisible)) return;
    if (environment->constant)
        seeEnvironment(path, environment->texels[0], 0); // no light samples go there
    else
        escaped.push_back(static_cast<Index>(i));
}

void PathTracer::State::seeEnvironment(Path &path, const Vec3 &radiance, float lightPdf) {
    if (path.scatterPdf == 0) path.alpha = 1;
    addLight(path, path.throughput * radiance * (path.scatterPdf == 0 ? 1.0F : powerHeuristic(path.scatterPdf, lightPdf)),
             [&] { return settings.layers->environment; });
}

void PathTracer::State::lookUpEscaped() {
    const LightTable &lights = scene.lights();
    for (std::size_t begin = 0; begin < escaped.size(); begin += EnvironmentLanes::kSize) {
        const std::size_t count = std::min<std::size_t>(EnvironmentLanes::kSize, escaped.size() - begin);
        sky.count = static_cast<int>(count);
        for (std::size_t k = 0; k < count; ++k) sky.direction.set(k, lights.worldFromRender * rays[escaped[begin + k]].direction);
        lookUpEnvironment(*lights.environment, sky);
        for (std::size_t k = 0; k < count; ++k) {
            const Index i = escaped[begin + k];
            const float choice = choiceProbability(lights, {lights.environmentEntry, 0}, paths[active[i]].receiver(rays[i].origin));
            seeEnvironment(paths[active[i]], sky.radiance.at(k), sky.pdf[k] * choice);
        }
    }
    escaped.clear();
}

bool PathTracer::State::meetLights(Path &path, const Ray &ray, float farthest) {
    const LightTable &lights = scene.lights();
    const bool cameraRay = path.scatterPdf == 0;
    LightHit nearest;
    const auto meet = [&](Index i, float end) {
        const LightEntry &entry = lights.entries[i];
        if (cameraRay && !entry.cameraVisible) return end;
        const LightHit hit = intersectLight(lights, i, ray.origin, ray.direction, end);
        if (hit.entry == kNone) return end;
        if (cameraRay) {
            nearest = hit;
            return hit.t;
        }
        const float weight = powerHeuristic(path.scatterPdf, lightHitPdf(lights, hit, path.receiver(ray.origin)));
        addLight(path, path.throughput * entry.radiance * weight, [&] { return groupOfEntry(i); });
        return end;
    };
    visitLightsMet(lights, ray.origin, ray.direction, farthest, meet);
    if (nearest.entry == kNone) return false;
    addLight(path, path.throughput * lights.entries[nearest.entry].radiance, [&] { return groupOfEntry(nearest.entry); });
    path.alpha = 1;
    return true;
}

} // namespace taut
