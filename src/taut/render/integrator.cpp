#include "taut/render/integrator.h"

#include "taut/base/sobol.h"
#include "taut/render/aov.h"
#include "taut/render/camera_rays.h"
#include "taut/render/hit_lanes.h"
#include "taut/render/roulette.h"

#include <algorithm>
#include <chrono>

namespace taut {

namespace {

/// Pixels are visited in blocks of this side, one sample each, so that 16 neighbouring camera rays make one packet.
constexpr int kBlock = 4;
/// Most paths in flight a thread.
constexpr int kMostPaths = 2048;

/// Dimensions of the sample sequence that every event draws.
enum EventDimension : std::uint32_t { kScatterDirection, kScatterLobe, kLightPoint, kLightChoice, kRoulette, kPerEvent };

struct Path {
    Vec3 throughput{1};
    Vec3 radiance{0};
    float alpha = 0;
    float scatterPdf = 0; ///< of the ray under way; 0: a camera ray
    float etaScale = 1;
    float time = 0; ///< within the shutter
    int x = 0, y = 0;
    std::uint32_t sample = 0;
    std::uint32_t seed = 0; ///< of the pixel
    bool hasAovs = false;
};

struct ShadowTest {
    Index path;
    Vec3 contribution;
};

/// From `origin`, a little off `position`, to just before the point that lies at `distance` from the position: to that point, not
/// beside it, for a ray that grazes the plane of an emitter would enter it before its end.
Ray shadowRay(const Vec3 &origin, const Vec3 &position, const Vec3 &direction, float distance, float time) {
    Ray ray;
    ray.origin = origin;
    ray.time = time;
    const bool somewhere = distance < kInfinity;
    ray.direction = somewhere ? position + direction * distance - origin : direction;
    ray.farthest = somewhere ? 1 - 1e-4F : kInfinity;
    return ray;
}

double secondsSince(std::chrono::steady_clock::time_point &start) {
    const auto now = std::chrono::steady_clock::now();
    const double seconds = std::chrono::duration<double>(now - start).count();
    start = now;
    return seconds;
}

} // namespace

RayCounts &RayCounts::operator+=(const RayCounts &other) {
    paths += other.paths;
    camera += other.camera;
    scattered += other.scattered;
    shadow += other.shadow;
    notFinite += other.notFinite;
    return *this;
}

struct PathTracer::State {
    State(const RenderScene &scene_, const std::vector<PreparedMaterial> &materials_, const TraceSettings &settings_)
        : scene(scene_), materials(materials_), settings(settings_) {}

    const RenderScene &scene;
    const std::vector<PreparedMaterial> &materials;
    TraceSettings settings;

    std::unique_ptr<CameraLanes> cameraLanes = std::make_unique<CameraLanes>();
    std::vector<Path> paths;
    std::vector<float> aovs; ///< [paths x channels]
    std::vector<Index> active, stillActive;
    std::vector<Ray> rays, nextRays, shadowRays;
    std::vector<Hit> hits;
    std::vector<ShadowTest> shadowTests;
    std::vector<unsigned char> blocked;

    // Hits that are shaded at once.
    std::vector<PlainMaterial> plainMaterials; ///< [materials]
    std::vector<unsigned char> plainObjects;   ///< [objects]
    std::vector<std::vector<Index>> waiting;   ///< [materials] hits of this event
    std::unique_ptr<HitLanes> lanes = std::make_unique<HitLanes>();

    std::vector<Index> escaped; ///< positions in `active` of paths whose way out is still to be looked up
    EnvironmentLanes sky;

    [[nodiscard]] Vec2 random2(const Path &path, std::uint32_t dimension) const { return sobol2(path.sample, hash(path.seed, dimension)); }
    [[nodiscard]] float random1(const Path &path, std::uint32_t dimension) const { return sobol1(path.sample, hash(path.seed, dimension)); }
    /// Names the walk within the microsurface, where the material asks for one.
    [[nodiscard]] static std::uint32_t walkSeed(const Path &path, const SurfacePoint &point, std::uint32_t dimension) {
        return point.bsdf.multiscatter == Multiscatter::Walk ? hash(path.sample, hash(path.seed, ~dimension)) : 0;
    }
    static std::uint32_t dimensionOf(int event, EventDimension which) {
        return kCameraDimensions + static_cast<std::uint32_t>(event) * kPerEvent + which;
    }

    void startPaths(const Window &tile, int firstSample, int lastSample);
    void addPaths();
    void shadeAll(int event, const std::vector<Aov> &wanted, int aovChannels);
    void escape(std::size_t i);
    void lookUpEscaped();
    static void seeEnvironment(Path &path, const Vec3 &radiance, float lightPdf);
    /// Adds the quad and sphere lights on a ray's way; true where a camera ray ends on one.
    bool meetLights(Path &path, const Ray &ray, float farthest) const;
    void shade(int event, Index index, const Ray &ray, const Hit &hit, const std::vector<Aov> &wanted, int aovChannels);
    [[nodiscard]] bool waits(int event, std::size_t i, int aovChannels);
    void prefetch(std::size_t i) const;
    void gather(std::size_t lane, std::size_t i);
    void shadeAtOnce(int event, const PlainMaterial &material, std::span<const Index> chunk);
    void connectLight(int event, Index index, const SurfacePoint &point, const ScatteringPoint &scattering);
    void testShadows();
};

PathTracer::PathTracer(const RenderScene &scene, const std::vector<PreparedMaterial> &materials, const TraceSettings &settings)
    : state_(std::make_unique<State>(scene, materials, settings)) {
    State &s = *state_;
    for (const PreparedMaterial &material : materials) s.plainMaterials.push_back(plainMaterial(material));
    for (const RenderObject &object : scene.objects()) s.plainObjects.push_back(!settings.oneByOne && isPlain(object) ? 1 : 0);
    s.waiting.resize(materials.size());
}
PathTracer::~PathTracer() = default;

void PathTracer::State::startPaths(const Window &tile, int firstSample, int lastSample) {
    paths.clear();
    rays.clear();
    active.clear();
    CameraLanes &l = *cameraLanes;
    l.count = 0;
    for (int sample = firstSample; sample < lastSample; ++sample)
        for (int by = tile.y0; by < tile.y1; by += kBlock)
            for (int bx = tile.x0; bx < tile.x1; bx += kBlock)
                for (int y = by; y < std::min(by + kBlock, tile.y1); ++y)
                    for (int x = bx; x < std::min(bx + kBlock, tile.x1); ++x) {
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
        Ray &ray = rays[first + i];
        ray.origin = l.origin.at(i);
        ray.direction = l.direction.at(i);
        ray.time = l.time[i];
        active[first + i] = static_cast<Index>(first + i);
    }
    l.count = 0;
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
    path.radiance += path.throughput * radiance * (path.scatterPdf == 0 ? 1.0F : powerHeuristic(path.scatterPdf, lightPdf));
}

void PathTracer::State::lookUpEscaped() {
    const LightTable &lights = scene.lights();
    for (std::size_t begin = 0; begin < escaped.size(); begin += EnvironmentLanes::kSize) {
        const std::size_t count = std::min<std::size_t>(EnvironmentLanes::kSize, escaped.size() - begin);
        sky.count = static_cast<int>(count);
        for (std::size_t k = 0; k < count; ++k) sky.direction.set(k, lights.worldFromRender * rays[escaped[begin + k]].direction);
        lookup(*lights.environment, sky);
        for (std::size_t k = 0; k < count; ++k) {
            const Index i = escaped[begin + k];
            const float choice = choiceProbability(lights, {lights.environmentEntry, 0}, rays[i].origin);
            seeEnvironment(paths[active[i]], sky.radiance.at(k), sky.pdf[k] * choice);
        }
    }
    escaped.clear();
}

bool PathTracer::State::meetLights(Path &path, const Ray &ray, float farthest) const {
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
        const float weight = powerHeuristic(path.scatterPdf, lightHitPdf(lights, i, ray.origin, hit.t, hit.absCosine));
        path.radiance += path.throughput * entry.radiance * weight;
        return end;
    };
    visitLightsMet(lights, ray.origin, ray.direction, farthest, meet);
    if (nearest.entry == kNone) return false;
    path.radiance += path.throughput * lights.entries[nearest.entry].radiance;
    path.alpha = 1;
    return true;
}

void PathTracer::State::connectLight(int event, Index index, const SurfacePoint &point, const ScatteringPoint &scattering) {
    Path &path = paths[index];
    const LightSample light = sampleLight(scene.lights(), point.position, path.time, random1(path, dimensionOf(event, kLightChoice)),
                                          random2(path, dimensionOf(event, kLightPoint)));
    if (!(light.pdf > 0)) return;
    const Vec3 wi = point.frame.toLocal(light.direction);
    const float side = glm::dot(light.direction, point.geometricNormal);
    if ((side > 0) != (wi.z > 0)) return; // shading and geometric normal disagree about the side: no light leaks
    const auto [single, multiple] = scattering.evaluateParts(wi, walkSeed(path, point, dimensionOf(event, kLightPoint)));
    const auto weighed = [&](const BsdfEval &part) {
        if (!(part.pdf > 0)) return Vec3(0);
        const float weight = light.delta ? 1.0F : powerHeuristic(light.pdf, part.pdf);
        return path.throughput * part.fCos * light.radiance * (weight / light.pdf);
    };
    const Vec3 contribution = weighed(single) + weighed(multiple);
    if (!(maxComponent(contribution) > 0)) return;
    shadowRays.push_back(shadowRay(offsetOrigin(point, side > 0), point.position, light.direction, light.distance, path.time));
    shadowTests.push_back({index, contribution});
}

void PathTracer::State::shade(int event, Index index, const Ray &ray, const Hit &hit, const std::vector<Aov> &wanted, int aovChannels) {
    Path &path = paths[index];
    const SurfacePoint point = surfacePointAt(scene, materials, hit, -ray.direction, path.time);
    if (path.scatterPdf == 0) {
        path.alpha = 1;
        path.hasAovs = true;
        if (aovChannels > 0)
            writeAovs(scene, point, wanted, &aovs[static_cast<std::size_t>(index) * static_cast<std::size_t>(aovChannels)]);
    }
    if (point.emission != Vec3(0)) {
        const Index entry = scene.lightEntryOfObject(scene.objectOfGeometry(hit.geometry));
        float weight = 1;
        if (path.scatterPdf > 0 && entry != kNone) {
            const float cosine = std::fabs(glm::dot(point.geometricNormal, ray.direction));
            const float pdf = emitterHitPdf(scene.lights(), {entry, hit.primitive}, ray.origin, path.time, hit.t, cosine);
            weight = powerHeuristic(path.scatterPdf, pdf);
        }
        path.radiance += path.throughput * point.emission * weight;
    }
    if (event >= settings.maxEvents) return;

    const Vec3 wo = point.frame.toLocal(-ray.direction);
    const ScatteringPoint scattering(point.bsdf, wo);
    connectLight(event, index, point, scattering);

    const auto sampled =
        scattering.sample(random2(path, dimensionOf(event, kScatterDirection)), random1(path, dimensionOf(event, kScatterLobe)),
                          walkSeed(path, point, dimensionOf(event, kScatterLobe)));
    if (!sampled) return;
    const Vec3 direction = glm::normalize(point.frame.fromLocal(sampled->wi));
    const float side = glm::dot(direction, point.geometricNormal);
    if ((side > 0) == sampled->transmitted) return;
    path.throughput *= sampled->weight;
    path.etaScale *= sampled->etaScale;
    path.scatterPdf = sampled->pdf;
    const float chance = chanceToGoOn(path.throughput, path.etaScale);
    if (!(random1(path, dimensionOf(event, kRoulette)) < chance)) return;
    path.throughput *= 1 / chance;
    Ray next;
    next.origin = offsetOrigin(point, side > 0);
    next.direction = direction;
    next.time = path.time;
    nextRays.push_back(next);
    stillActive.push_back(index);
}

/// Puts a hit aside to be shaded with others, where its mesh and material are plain.
bool PathTracer::State::waits(int event, std::size_t i, int aovChannels) {
    const Hit &hit = hits[i];
    const Index owner = scene.objectOfGeometry(hit.geometry);
    if (plainObjects[owner] == 0 || (event == 0 && aovChannels > 0)) return false;
    const RenderObject &object = scene.objects()[owner];
    const Index material = materialOfTriangle(object, hit.primitive);
    if (!plainMaterials[material].isPlain) return false;
    if (event == 0) paths[active[i]].alpha = 1;
    if (event >= settings.maxEvents) return true;
    waiting[material].push_back(static_cast<Index>(i));
    __builtin_prefetch(&object.surface.triangles[hit.primitive]);
    return true;
}

/// Asks memory for the corners of hit i: they lie anywhere.
void PathTracer::State::prefetch(std::size_t i) const {
    const RenderObject &object = scene.objects()[scene.objectOfGeometry(hits[i].geometry)];
    const SurfaceStep &step = object.steps.front();
    const Index3 t = object.surface.triangles[hits[i].primitive];
    for (int k = 0; k < 3; ++k) {
        __builtin_prefetch(&step.positions[t[k]]);
        __builtin_prefetch(&step.normals[t[k]]);
        __builtin_prefetch(&step.tangents[t[k]]);
        if (step.stretch.size() > 1 && !object.stretchOnFaces()) __builtin_prefetch(&step.stretch[t[k]]);
    }
}

/// What lane `lane` needs of hit i.
void PathTracer::State::gather(std::size_t lane, std::size_t i) {
    HitLanes &l = *lanes;
    const HitCorners corners(scene.objects()[scene.objectOfGeometry(hits[i].geometry)], hits[i], 0);
    const InterpolatedSurface p = corners.surface();
    l.position.set(lane, p.position);
    l.e1.set(lane, p.e1);
    l.e2.set(lane, p.e2);
    l.normal.set(lane, p.normal);
    l.tangent.set(lane, Vec3(p.tangent));
    l.tangentSense[lane] = p.tangent.w;
    l.corners[lane] = p.corners;
    const bool deforms = !corners.step().stretch.empty();
    const SymmetricTensor v = deforms ? corners.stretch() : SymmetricTensor{};
    l.diagonal.set(lane, v.diagonal);
    l.offDiagonal.set(lane, v.offDiagonal);
    l.deforms[lane] = deforms ? 1 : 0;
    l.wo.set(lane, -rays[i].direction);
    const Path &path = paths[active[i]];
    l.throughput.set(lane, path.throughput);
    l.etaScale[lane] = path.etaScale;
    l.time[lane] = path.time;
    l.sample[lane] = path.sample;
    l.seed[lane] = path.seed;
    l.path[lane] = active[i];
}

void PathTracer::State::shadeAtOnce(int event, const PlainMaterial &material, std::span<const Index> chunk) {
    HitLanes &l = *lanes;
    l.count = static_cast<int>(chunk.size());
    const auto padded = static_cast<std::size_t>(l.padded());
    for (const Index i : chunk) prefetch(i);
    for (std::size_t k = 0; k < padded; ++k) gather(k, chunk[k < chunk.size() ? k : 0]);
    const EventNumbers numbers{dimensionOf(event, kScatterDirection), dimensionOf(event, kScatterLobe), dimensionOf(event, kLightPoint),
                               dimensionOf(event, kLightChoice), dimensionOf(event, kRoulette)};
    lanes::view(l, material, numbers);
    lanes::aim(l, scene.lights());
    lanes::connect(l, material);
    lanes::scatter(l, material);
    for (std::size_t k = 0; k < chunk.size(); ++k) {
        Path &path = paths[l.path[k]];
        if (l.connects[k] > 0) {
            shadowRays.push_back(shadowRay(l.shadowOrigin.at(k), l.position.at(k), l.lightDirection.at(k), l.lightDistance[k], path.time));
            shadowTests.push_back({l.path[k], l.contribution.at(k)});
        }
        if (!(l.goesOn[k] > 0)) continue;
        path.throughput = l.nextThroughput.at(k);
        path.etaScale = l.nextEtaScale[k];
        path.scatterPdf = l.scatterPdf[k];
        Ray next;
        next.origin = l.nextOrigin.at(k);
        next.direction = l.nextDirection.at(k);
        next.time = path.time;
        nextRays.push_back(next);
        stillActive.push_back(l.path[k]);
    }
}

void PathTracer::State::shadeAll(int event, const std::vector<Aov> &wanted, int aovChannels) {
    nextRays.clear();
    stillActive.clear();
    shadowRays.clear();
    shadowTests.clear();
    for (std::size_t i = 0; i < active.size(); ++i) {
        Path &path = paths[active[i]];
        if (meetLights(path, rays[i], hits[i].t)) continue;
        if (hits[i].geometry == kNone)
            escape(i);
        else if (!waits(event, i, aovChannels))
            shade(event, active[i], rays[i], hits[i], wanted, aovChannels);
    }
    lookUpEscaped();
    for (std::size_t m = 0; m < waiting.size(); ++m) {
        const std::span<const Index> all = waiting[m];
        for (std::size_t begin = 0; begin < all.size(); begin += HitLanes::kSize)
            shadeAtOnce(event, plainMaterials[m], all.subspan(begin, std::min<std::size_t>(HitLanes::kSize, all.size() - begin)));
        waiting[m].clear();
    }
    active.swap(stillActive);
    rays.swap(nextRays);
}

void PathTracer::State::testShadows() {
    blocked.resize(shadowRays.size());
    scene.embree().occluded(shadowRays, blocked);
    for (std::size_t i = 0; i < shadowTests.size(); ++i)
        if (blocked[i] == 0) paths[shadowTests[i].path].radiance += shadowTests[i].contribution;
}

void PathTracer::traceTile(const Window &tile, int firstSample, int lastSample, Film &film, StageTimes &times, RayCounts &counts) {
    State &s = *state_;
    const int pixels = tile.width() * tile.height();
    const int step = std::max(1, kMostPaths / std::max(1, pixels));
    const int aovChannels = film.aovChannels();
    for (int first = firstSample; first < lastSample; first += step) {
        auto clock = std::chrono::steady_clock::now();
        s.startPaths(tile, first, std::min(first + step, lastSample));
        s.aovs.assign(s.paths.size() * static_cast<std::size_t>(aovChannels), 0.0F);
        counts.paths += s.paths.size();
        for (int event = 0; !s.active.empty(); ++event) {
            (event == 0 ? counts.camera : counts.scattered) += s.rays.size();
            if (s.settings.record != nullptr) {
                auto &into = event == 0 ? s.settings.record->camera : s.settings.record->scattered;
                into.insert(into.end(), s.rays.begin(), s.rays.end());
            }
            times.shading += secondsSince(clock);
            s.hits.resize(s.rays.size());
            s.scene.embree().intersect(s.rays, event == 0, s.hits);
            (event == 0 ? times.cameraRays : times.scatteredRays) += secondsSince(clock);
            s.shadeAll(event, film.aovs(), aovChannels);
            times.shading += secondsSince(clock);
            counts.shadow += s.shadowRays.size();
            if (s.settings.record != nullptr)
                s.settings.record->shadow.insert(s.settings.record->shadow.end(), s.shadowRays.begin(), s.shadowRays.end());
            s.testShadows();
            times.shadowRays += secondsSince(clock);
        }
        for (std::size_t i = 0; i < s.paths.size(); ++i) {
            Path &path = s.paths[i];
            if (!isFinite(path.radiance)) {
                ++counts.notFinite;
                path.radiance = Vec3(0);
            }
            film.add(path.x, path.y, path.radiance, path.alpha,
                     path.hasAovs ? s.aovs.data() + i * static_cast<std::size_t>(aovChannels) : nullptr);
        }
        times.film += secondsSince(clock);
    }
}

} // namespace taut
