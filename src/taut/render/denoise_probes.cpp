/// What pixels see, for the denoiser: by camera rays of their own, which are cheap, since nothing is shaded. One through the middle of a
/// pixel; more where surfaces have textures or things move, and many where something ends within the pixel or beside it: how much of an
/// outline's pixel is covered is then known far better than by the samples that are shaded, and with it how light is mixed there.
///
/// What a pixel is told depends on it and the scene alone, not on samples, tiles or crops: films may be split and merged in any way.

#include "taut/render/denoise_features.h"
#include "taut/render/path_state.h"

#include <algorithm>
#include <chrono>
#include <utility>

namespace taut {

namespace {

constexpr int kDetailed = 4; ///< probes of a pixel that sees a texture
constexpr int kFaceted = 8;  ///< where facets of one surface meet: how it turns, there is no cover to know
constexpr int kBlurred = 8;  ///< where what a pixel sees is left to chance: by lens, shutter or opacity
/// Neighbouring pixels see different surfaces where cosines of facets are below, or distances further apart.
constexpr float kSameFacet = 0.9F, kSameDepth = 0.1F;
/// Probes of a pixel where surfaces end, for each sample of half the picture's; and the least and most of them.
constexpr int kEdgeProbes = 8, kLeastEdgeProbes = 32, kMostEdgeProbes = 256;
/// Of the sample sequence, whatever that of the frame.
constexpr std::uint32_t kProbeSeed = 0x7ac3U;
/// Instead of a geometry: a light.
constexpr Index kLight = kNone - 1;

bool hasDetail(const Material &m) {
    return m.color.texture != kNone || m.metallic.texture != kNone || m.alphaX.texture != kNone || m.alphaY.texture != kNone ||
           m.rotation.texture != kNone || m.anisotropyTexture != kNone || m.slopes.isGiven();
}

} // namespace

/// Of one tile.
class PathTracer::State::Probes {
  public:
    Probes(State &state, const Window &tile, int block)
        : s_(state), tile_(tile), edgeProbes_(std::clamp(kEdgeProbes * block, kLeastEdgeProbes, kMostEdgeProbes)),
          ring_{std::max(0, tile.x0 - 1), std::max(0, tile.y0 - 1), std::min(state.settings.width, tile.x1 + 1),
                std::min(state.settings.height, tile.y1 + 1)} {
        const RenderSettings &render = s_.scene.scene().render;
        const Environment *environment = s_.scene.lights().environment;
        seesEnvironment_ = environment != nullptr && environment->cameraVisible;
        isBlurred_ = render.shutter > 0 || s_.scene.camera().apertureRadius > 0 || s_.scene.surfacesMayBeAbsent();
    }

    /// Calls use(x, y, features) for every pixel of the tile.
    void run(const auto &use) {
        lookAround();
        std::vector<FeatureMeans> means(static_cast<std::size_t>(tile_.width()) * static_cast<std::size_t>(tile_.height()));
        std::vector<Wanted> wanted(means.size());
        FeatureMeans one;
        const auto placeOf = [&](int x, int y) { return static_cast<std::size_t>((y - tile_.y0) * tile_.width() + x - tile_.x0); };
        for (int y = tile_.y0; y < tile_.y1; ++y)
            for (int x = tile_.x0; x < tile_.x1; ++x) {
                const std::size_t i = placeOf(x, y);
                wanted[i] = probesOf(x, y);
                if (wanted[i].probes != 1) continue;
                one.clear();
                add(ringPlace(x, y), one);
                use(x, y, one.rounded(false));
            }
        begin(false);
        const auto finish = [&] {
            trace();
            for (std::size_t i = 0; i < s_.rays.size(); ++i) add(i, means[placeOf(s_.paths[i].x, s_.paths[i].y)]);
            begin(false);
        };
        for (int y = tile_.y0; y < tile_.y1; ++y)
            for (int x = tile_.x0; x < tile_.x1; ++x)
                for (int probe = 0; wanted[placeOf(x, y)].probes > 1 && probe < wanted[placeOf(x, y)].probes; ++probe) {
                    start(x, y, probe);
                    if (s_.paths.size() >= kMostProbes) finish();
                }
        finish();
        for (int y = tile_.y0; y < tile_.y1; ++y)
            for (int x = tile_.x0; x < tile_.x1; ++x)
                if (const Wanted &own = wanted[placeOf(x, y)]; own.probes > 1) use(x, y, means[placeOf(x, y)].rounded(own.edge));
    }

  private:
    /// What the middle of a pixel sees.
    struct Seen {
        Index object = kNone; ///< or none, or a light
        bool detailed = false;
        Vec3 facet{0}; ///< unit
        float distance = 0;
    };

    /// Of a pixel, and whether surfaces or facets end there.
    struct Wanted {
        int probes = 1;
        bool edge = false;
    };

    static constexpr std::size_t kMostProbes = 1024;
    State &s_;
    Window tile_;
    int edgeProbes_;
    Window ring_; ///< the tile and the pixels around it
    bool isBlurred_;
    bool seesEnvironment_;
    std::vector<Seen> seen_; ///< [pixels of the ring]

    [[nodiscard]] std::size_t ringPlace(int x, int y) const {
        return static_cast<std::size_t>((y - ring_.y0) * ring_.width() + x - ring_.x0);
    }

    void begin(bool centred) {
        s_.paths.clear();
        s_.rays.clear();
        s_.active.clear();
        s_.cameraLanes->count = 0;
        s_.cameraLanes->centred = centred;
    }
    void start(int x, int y, int probe) {
        CameraLanes &l = *s_.cameraLanes;
        l.x[l.count] = x;
        l.y[l.count] = y;
        l.sample[l.count] = static_cast<std::uint32_t>(probe);
        if (++l.count == CameraLanes::kSize) s_.addPaths();
    }
    void trace() {
        s_.addPaths();
        s_.startLayers();
        s_.intersect(0);
    }

    [[nodiscard]] bool meetsLight(std::size_t i) {
        return !s_.scene.lights().parts.empty() && s_.meetLights(s_.paths[i], s_.rays[i], s_.hits[i].t);
    }

    void lookAround() {
        begin(true);
        for (int y = ring_.y0; y < ring_.y1; ++y)
            for (int x = ring_.x0; x < ring_.x1; ++x) start(x, y, 0);
        trace();
        seen_.assign(s_.rays.size(), {});
        for (std::size_t i = 0; i < seen_.size(); ++i) {
            Seen &seen = seen_[i];
            const Hit &hit = s_.hits[i];
            if (meetsLight(i)) {
                seen.object = kLight;
            } else if (hit.geometry != kNone) {
                seen.object = s_.scene.objectOfGeometry(hit.geometry);
                const RenderObject &object = s_.scene.objects()[seen.object];
                seen.detailed = hasDetail(s_.scene.scene().materialAt(materialOfTriangle(object, hit.primitive)));
                const InterpolatedSurface at = HitCorners<false>(object, hit, s_.paths[i].time).surface();
                const Vec3 cross = glm::cross(at.e1, at.e2);
                seen.facet = cross / std::max(glm::length(cross), 1e-30F);
                seen.distance = hit.t;
            }
        }
    }

    [[nodiscard]] static bool areOneSurface(const Seen &a, const Seen &b) {
        if (a.object != b.object) return false;
        if (a.object == kNone || a.object == kLight) return true;
        return std::fabs(a.distance - b.distance) <= kSameDepth * std::min(a.distance, b.distance);
    }

    [[nodiscard]] Wanted probesOf(int x, int y) const {
        const Seen &own = seen_[ringPlace(x, y)];
        Wanted wanted{isBlurred_ ? kBlurred : own.detailed ? kDetailed : 1};
        for (int v = std::max(ring_.y0, y - 1); v < std::min(ring_.y1, y + 2); ++v)
            for (int u = std::max(ring_.x0, x - 1); u < std::min(ring_.x1, x + 2); ++u) {
                const Seen &other = seen_[ringPlace(u, v)];
                if (!areOneSurface(own, other)) return {edgeProbes_, true};
                if (own.object != kNone && own.object != kLight && glm::dot(own.facet, other.facet) < kSameFacet) wanted = {kFaceted, true};
            }
        return wanted;
    }

    /// Ray `i` tells what it meets.
    void add(std::size_t i, FeatureMeans &means) {
        const Hit &hit = s_.hits[i];
        const Ray &ray = s_.rays[i];
        if (meetsLight(i)) return means.addNothing(true, true);
        if (hit.geometry == kNone) return means.addNothing(seesEnvironment_, false);
        if (!means.addHit(s_.scene.objectOfGeometry(hit.geometry), hit.t)) return;
        const Path &path = s_.paths[i];
        const float coneWidth = s_.hasCones ? path.cone.widthAt(hit.t) : 0.0F;
        const SurfacePoint point = surfacePointAt(s_.scene, s_.materials, hit, -ray.direction, path.time, coneWidth);
        float features[kDenoiseFeatures];
        const bool moving = writeDenoiseFeatures(s_.scene, point, -ray.direction, path.time, s_.settings.before, features);
        means.tell(features, moving);
    }
};

void PathTracer::State::probeTile(const Window &tile, const FilmAccess &access, StageTimes &times) {
    const auto start = std::chrono::steady_clock::now();
    DenoiseSums &sums = *access.film.denoiseSums();
    {
        const std::lock_guard lock(access.lock);
        bool told = true;
        for (int y = tile.y0; y < tile.y1; ++y)
            for (int x = tile.x0; x < tile.x1; ++x) told &= sums.featuresAt(x, y).probes > 0;
        if (told) return;
    }
    const std::uint32_t seed = std::exchange(settings.seed, kProbeSeed);
    std::vector<std::pair<glm::ivec2, PixelFeatures>> features;
    features.reserve(static_cast<std::size_t>(tile.width()) * static_cast<std::size_t>(tile.height()));
    Probes(*this, tile, sums.block()).run([&](int x, int y, const PixelFeatures &told) { features.emplace_back(glm::ivec2(x, y), told); });
    settings.seed = seed;
    cameraLanes->centred = false;
    const std::lock_guard lock(access.lock);
    for (const auto &[at, told] : features) sums.tell(at.x, at.y, told);
    times.film += std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

} // namespace taut
