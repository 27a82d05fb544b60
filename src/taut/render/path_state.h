#pragma once
/// The paths of a batch under way, their rays and their place in the sample sequence. Internal to the integrator: integrator.cpp says
/// what happens when, path_state.cpp starts paths and ends them outside of surfaces, shade_hit.cpp scatters them one by one, gather.cpp
/// many at once, surface_test.cpp says what they meet, denoise_probes.cpp looks at what pixels see.

#include "taut/base/sobol.h"
#include "taut/render/camera_rays.h"
#include "taut/render/hit_lanes.h"
#include "taut/render/integrator.h"
#include "taut/render/light_groups.h"
#include "taut/render/ray_cone.h"

namespace taut {

struct Path {
    Vec3 throughput{1};
    Vec3 radiance{0};
    float alpha = 0;
    float scatterPdf = 0; ///< of the ray under way; 0: a camera ray
    Vec3 normal{0};       ///< Receiver's where the ray under way comes from
    float etaScale = 1;
    Vec3 extinction{0}; ///< of the medium that the ray under way is in
    RayCone cone;       ///< of the ray under way, where a material looks textures up by it
    float time = 0;     ///< within the shutter
    int x = 0, y = 0;
    std::uint32_t sample = 0;
    std::uint32_t seed = 0; ///< of the pixel
    bool hasAovs = false;

    /// What samples of lights saw where a ray of this path comes from.
    [[nodiscard]] Receiver receiver(const Vec3 &origin) const { return {origin, normal}; }
};

/// What a film keeps of first hits.
struct FirstHitOutputs {
    std::span<const Aov> aovs;
    std::size_t channels = 0; ///< of all of them
};

struct ShadowTest {
    Index path;
    Vec3 contribution;
};

/// From `origin`, a little off `position`, to just before the point that lies at `distance` from the position: to that point, not
/// beside it, for a ray that grazes the plane of an emitter would enter it before its end.
inline Ray shadowRay(const Vec3 &origin, const Vec3 &position, const Vec3 &direction, float distance, float time) {
    Ray ray;
    ray.origin = origin;
    ray.time = time;
    const bool somewhere = distance < kInfinity;
    ray.direction = somewhere ? position + direction * distance - origin : direction;
    ray.farthest = somewhere ? 1 - 1e-4F : kInfinity;
    return ray;
}

struct PathTracer::State {
    State(const RenderScene &scene_, const std::vector<PreparedMaterial> &materials_, const TraceSettings &settings_)
        : scene(scene_), materials(materials_), settings(settings_) {}

    const RenderScene &scene;
    const std::vector<PreparedMaterial> &materials;
    TraceSettings settings;

    std::unique_ptr<CameraLanes> cameraLanes = std::make_unique<CameraLanes>();
    std::vector<Path> paths;
    std::vector<float> aovs;  ///< [paths x channels]
    std::vector<Vec2> places; ///< [paths] within the filters of pixels that share their samples
    std::vector<Index> active, stillActive;
    std::vector<Ray> rays, nextRays, shadowRays;
    std::vector<Hit> hits;
    std::vector<ShadowTest> shadowTests;
    std::vector<unsigned char> blocked;

    // Layers of the film, where they are asked for.
    std::vector<Vec3> groupLight;       ///< [paths x groups]
    std::vector<Index> shadowGroups;    ///< [shadowTests]
    std::vector<LayerSample> firstHits; ///< [paths] ids alone

    // Hits that are shaded at once.
    std::vector<LaneMaterial> laneMaterials; ///< [materials]
    /// How an object's hits are gathered: one by one; at one time, between steps of the shutter, with a deformation of another kind or
    /// with a stored M.
    enum class LaneObject : std::uint8_t { Alone, Still, Moving, Other, Stored };
    std::vector<LaneObject> laneObjects;     ///< [objects]
    std::vector<std::vector<Index>> waiting; ///< [materials] hits of this event
    std::unique_ptr<HitLanes> lanes = std::make_unique<HitLanes>();
    std::array<MeshValues, HitLanes::kSize> meshValues; ///< of the lanes, where a material varies

    bool hasMedia = false;    ///< a material attenuates light inside
    bool hasEmitters = false; ///< a mesh emits
    bool hasCones = false;    ///< a material looks textures up over footprints

    std::vector<Index> escaped; ///< positions in `active` of paths whose way out is still to be looked up
    EnvironmentLanes sky;

    [[nodiscard]] Vec2 random2(const Path &path, std::uint32_t dimension) const { return sobol2(path.sample, hash(path.seed, dimension)); }
    [[nodiscard]] float random1(const Path &path, std::uint32_t dimension) const { return sobol1(path.sample, hash(path.seed, dimension)); }
    [[nodiscard]] Vec3 random3(const Path &path, std::uint32_t dimension) const { return sobol3(path.sample, hash(path.seed, dimension)); }
    /// Names the walk within the microsurface, where the material asks for one.
    [[nodiscard]] static std::uint32_t walkSeed(const Path &path, const SurfacePoint &point, std::uint32_t dimension) {
        return point.bsdf.multiscatter == Multiscatter::Walk ? hash(path.sample, hash(path.seed, ~dimension)) : 0;
    }
    /// What its light towards a lamp is evaluated with.
    [[nodiscard]] walk::Numbers walkNumbers(const Path &path, const SurfacePoint &point, int event) const {
        if (point.bsdf.multiscatter != Multiscatter::Walk) return {};
        return {{random2(path, dimensionOf(event, kWalkFirst)), random2(path, dimensionOf(event, kWalkLast))},
                walkSeed(path, point, dimensionOf(event, kLightNumbers))};
    }

    class Surfaces;

    // --- layers ---
    [[nodiscard]] bool hasGroups() const { return settings.layers != nullptr && settings.layers->groups > 0; }
    void startLayers();
    void noteFirstHit(std::size_t i);
    /// Group of what a triangle emits.
    [[nodiscard]] Index groupOf(Index object, Index triangle) const;
    /// Light that reaches the camera along a path; `group` is asked where groups are.
    template <class Group> void addLight(Path &path, const Vec3 &light, const Group &group) {
        path.radiance += light;
        if (hasGroups()) groupLight[static_cast<std::size_t>(&path - paths.data()) * settings.layers->groups + group()] += light;
    }
    [[nodiscard]] Index groupOfEntry(Index entry) const { return settings.layers->entries[entry]; }
    [[nodiscard]] LayerSample layerSample(std::size_t path) const;

    void startPaths(const Window &tile, int firstSample, int lastSample);
    void addPaths();
    void intersect(int event);
    void attenuate();
    void shadeAll(int event, const FirstHitOutputs &outputs);
    void escape(std::size_t i);
    void lookUpEscaped();
    void seeEnvironment(Path &path, const Vec3 &radiance, float lightPdf);
    /// Adds the quad and sphere lights on a ray's way; true where a camera ray ends on one.
    bool meetLights(Path &path, const Ray &ray, float farthest);
    /// Tells the film what the pixels of a tile see, where it keeps that and has not been told (denoise_probes.cpp).
    void probeTile(const Window &tile, const FilmAccess &access, StageTimes &times);
    class Probes;
    void seeEmission(Path &path, const Ray &ray, const Hit &hit, const Vec3 &geometricNormal, const Vec3 &emission);
    void shade(int event, Index index, const Ray &ray, const Hit &hit, const FirstHitOutputs &outputs);
    void scatter(int event, Index index, const SurfacePoint &point, const Vec3 &wo, float distance);
    [[nodiscard]] bool waits(int event, std::size_t i);
    void prefetch(std::size_t i) const;
    template <bool kStill> void gatherSurface(std::size_t lane, std::size_t i, bool isPlain);
    void gather(std::size_t lane, std::size_t i);
    [[nodiscard]] MeshValues meshValuesOf(std::size_t lane, std::size_t i, const PreparedMaterial &prepared) const;
    void lookUp(const LaneMaterial &material, std::span<const Index> chunk);
    void lookUpSlopes(const SlopeMap &map, std::span<const Index> chunk, HitLanes &into);
    [[nodiscard]] SurfacePoint pointOf(std::size_t lane, const LaneMaterial &material) const;
    void seeEmissions(const LaneMaterial &material, std::span<const Index> chunk);
    void connectAtOnce(int event, const LaneMaterial &material);
    void writeAovsAtOnce(const LaneMaterial &material, std::span<const Index> chunk, const FirstHitOutputs &outputs);
    void shadeAtOnce(int event, const LaneMaterial &material, std::span<const Index> chunk, const FirstHitOutputs &outputs);
    /// What a light's contribution keeps on its way through the medium that the path is in, to a surface's `side` of the viewer (above 0).
    static void attenuate(const Path &path, float side, float distance, Vec3 &contribution) {
        if (path.extinction != Vec3(0) && side > 0 && distance < kInfinity) contribution *= glm::exp(-path.extinction * distance);
    }
    void connectLight(int event, Index index, const SurfacePoint &point, const FacetScattering &scattering);
    void testShadows(int event);
};

/// Opacity and culling: whether a surface is there for a ray of a path. Blended ones are for a share of the samples that is their opacity,
/// drawn for each triangle from a sequence of its own, so that layers are independent and each is stratified.
class PathTracer::State::Surfaces final : public SurfaceTest {
  public:
    /// `dimension` tells apart the batches of a path.
    Surfaces(const State &state, bool shadows, std::uint32_t dimension) : state_(state), shadows_(shadows), dimension_(dimension) {}
    [[nodiscard]] bool isThere(std::size_t ray, const Hit &hit) const override;

  private:
    const State &state_;
    bool shadows_;
    std::uint32_t dimension_;
};

} // namespace taut
