/// taut chart bvh: what is done to the BVH of a deforming mesh, its time against the speed of rays through it.

#include "study/charts.h"
#include "study/measures/replay.h"
#include "study/measures/timing.h"
#include "study/scenes/scenes.h"
#include "study/text.h"

#include "taut/base/parallel.h"
#include "taut/plan/plan.h"
#include "taut/render/embree_packets.h"
#include "taut/render/triangle_pairs.h"

#include <array>
#include <cmath>
#include <memory>

namespace taut::chart {

namespace {

/// Refitting and rebuilding are the renderer's; low and high quality are Embree's, which it has no use for.
struct Update {
    const char *name;
    bool ours;
    RTCBuildQuality quality;
};
constexpr Update kUpdates[] = {{"refit", true, RTC_BUILD_QUALITY_REFIT},
                               {"rebuild, low quality", false, RTC_BUILD_QUALITY_LOW},
                               {"rebuild, medium quality", true, RTC_BUILD_QUALITY_MEDIUM},
                               {"rebuild, high quality", false, RTC_BUILD_QUALITY_HIGH}};

/// One mesh in a BVH of its own.
class Bvh {
  public:
    Bvh(const Update &update, std::span<const Vec3> positions, std::span<const Index3> triangles) : update_(update) {
        if (update.ours) {
            renderers_ = std::make_unique<EmbreeScene>(true);
            id_ = renderers_->addTriangles({positions}, {triangles});
            renderers_->commit();
            return;
        }
        const RTCBuildQuality quality = update.quality;
        device_ = rtcNewDevice(nullptr);
        scene_ = rtcNewScene(device_);
        if (quality == RTC_BUILD_QUALITY_LOW) rtcSetSceneFlags(scene_, RTC_SCENE_FLAG_DYNAMIC);
        rtcSetSceneBuildQuality(scene_, quality);
        geometry_ = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_QUAD);
        rtcSetSharedGeometryBuffer(geometry_, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, positions.data(), 0, sizeof(Vec3),
                                   positions.size() - 1);
        const TrianglePairs pairs(triangles);
        void *const corners =
            rtcSetNewGeometryBuffer(geometry_, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT4, sizeof(QuadCorners), pairs.size());
        pairs.corners(triangles, {static_cast<QuadCorners *>(corners), pairs.size()});
        rtcSetGeometryBuildQuality(geometry_, quality);
        rtcCommitGeometry(geometry_);
        rtcAttachGeometry(scene_, geometry_);
        rtcCommitScene(scene_);
    }
    ~Bvh() {
        if (device_ == nullptr) return;
        rtcReleaseGeometry(geometry_);
        rtcReleaseScene(scene_);
        rtcReleaseDevice(device_);
    }
    Bvh(const Bvh &) = delete;
    Bvh &operator=(const Bvh &) = delete;

    /// The positions have changed.
    void update() {
        if (renderers_) {
            renderers_->update(id_, update_.quality == RTC_BUILD_QUALITY_MEDIUM);
            renderers_->commit();
            return;
        }
        rtcUpdateGeometryBuffer(geometry_, RTC_BUFFER_TYPE_VERTEX, 0);
        rtcUpdateGeometryBuffer(geometry_, RTC_BUFFER_TYPE_INDEX, 0);
        rtcCommitGeometry(geometry_);
        rtcCommitScene(scene_);
    }
    [[nodiscard]] RTCScene native() const { return renderers_ ? static_cast<RTCScene>(renderers_->native()) : scene_; }

  private:
    const Update &update_;
    std::unique_ptr<EmbreeScene> renderers_;
    Index id_ = 0;
    RTCDevice device_ = nullptr;
    RTCScene scene_ = nullptr;
    RTCGeometry geometry_ = nullptr;
};

/// Camera and scattered rays, eight wide.
class Rays {
  public:
    explicit Rays(const RayRecord &record) {
        for (const std::vector<Ray> *rays : {&record.camera, &record.scattered})
            for (std::size_t i = 0; i + 8 <= rays->size(); i += 8) {
                packets_.emplace_back();
                for (std::size_t lane = 0; lane < 8; ++lane) setLane(packets_.back(), lane, (*rays)[i + lane]);
            }
    }
    void trace(RTCScene scene) const {
        parallelFor(packets_.size(), 64, [&](std::size_t i) {
            RTCRayHit8 packet = packets_[i];
            alignas(32) std::array<int, 8> valid;
            valid.fill(-1);
            tracePacket(scene, valid.data(), packet, false);
        });
    }
    [[nodiscard]] double count() const { return 8 * static_cast<double>(packets_.size()); }

  private:
    std::vector<RTCRayHit8> packets_;
};

/// A torus twisted about x, its twist growing by a radian a metre with every frame.
Scene twistingScene(int around) {
    Object torus = objectOf(makeTorus(around, around / 4, 0.7F, 0.3F));
    Keyed<double> amount;
    amount.keys = {{0, 0.0}, {100, 100.0}};
    torus.deformers = {deformer(DeformerType::Twist, amount, 0, 2)};
    Scene scene = studyScene(std::move(torus), brushedMetal(0.1F, 0.3F), 256);
    scene.materials[0].multiscatter = Multiscatter::Off;
    return scene;
}

/// Everything measured at one amount of twist, the BVH built (or refitted from) where there was none.
struct Stage {
    double twist = 0;
    double growth = 1;
    std::array<Measured, 4> update, trace; ///< s; s a ray
    double policyRays = 0;                 ///< rays a frame from which the policy rebuilds
};

/// The number of rays at which the policy changes its mind: what a refit costs is linear in them.
double switchOf(const BvhPolicy &policy, std::span<const Index3> triangles, std::span<const Vec3> positions) {
    const double none = policy.refitSeconds(triangles, positions, 0);
    const double slope = policy.refitSeconds(triangles, positions, 1) - none;
    return slope > 0 ? (BvhPolicy::rebuildSeconds(triangles.size()) - none) / slope : 1e12;
}

/// All stages and ways in turn, round after round.
std::vector<Stage> measureStages(const Scene &scene, const std::vector<double> &twists, int rounds) {
    RenderScene ready(scene, defaultPlan(scene), true);
    StageTimes ignored;
    ready.setFrame(0, ignored);
    const RenderObject &object = ready.objects()[0];
    const std::vector<Index3> &triangles = object.surface.triangles;
    std::vector<Vec3> positions = object.steps[0].positions;
    BvhPolicy policy;
    policy.built(triangles, positions);
    std::vector<std::unique_ptr<Bvh>> trees;
    for (const Update &update : kUpdates) trees.push_back(std::make_unique<Bvh>(update, positions, triangles));
    std::vector<Stage> stages;
    std::vector<std::vector<Vec3>> shapes; // [stages]
    std::vector<Rays> rays;                // [stages]
    for (const double twist : twists) {
        ready.setFrame(twist, ignored);
        shapes.push_back(object.steps[0].positions);
        rays.emplace_back(recordRays(ready, 1, 1));
        Stage stage;
        stage.twist = twist;
        stage.growth = policy.growth(triangles, shapes.back());
        stage.policyRays = switchOf(policy, triangles, shapes.back());
        stages.push_back(stage);
    }
    std::vector<std::function<void()>> rows;
    for (std::size_t s = 0; s < stages.size(); ++s) {
        rows.emplace_back([&, s] { std::copy(shapes[s].begin(), shapes[s].end(), positions.begin()); });
        for (const auto &tree : trees) rows.emplace_back([&tree] { tree->update(); });
        for (const auto &tree : trees) rows.emplace_back([&tree, &rays, s] { rays[s].trace(tree->native()); });
    }
    const std::vector<Measured> times = timeOnOneThread(rows, rounds);
    for (std::size_t s = 0; s < stages.size(); ++s)
        for (std::size_t i = 0; i < trees.size(); ++i) {
            const std::size_t row = s * (1 + 2 * trees.size()) + 1 + i;
            stages[s].update[i] = times[row];
            stages[s].trace[i] = times[row + trees.size()] * (1 / rays[s].count());
        }
    return stages;
}

/// Rays of a frame of 512 x 512 pixels, as many to a sample as recorded frames have.
double raysOf(int spp) {
    return 2.5 * 512 * 512 * spp;
}

/// What the policy would do at a stage.
std::size_t chosenAt(const Stage &stage, double rays) {
    return rays >= stage.policyRays ? 2 : 0;
}

Panel stagePanel(const std::string &name, const Stage &stage, const std::string &conditions) {
    Panel panel{name,
                "Twisted by " + digits(stage.twist) + " radians a metre",
                conditions + "; default: what the policy takes at " + std::to_string(RenderSettings{}.spp) + " samples a pixel",
                {"update of the BVH", "ms"},
                {"time a ray", "ns"},
                {}};
    for (std::size_t i = 0; i < 4; ++i)
        panel.points.push_back(
            {kUpdates[i].name, "", stage.update[i] * 1e3, stage.trace[i] * 1e9, i == chosenAt(stage, raysOf(RenderSettings{}.spp))});
    return panel;
}

Panel framePanel(int spp, const std::vector<Stage> &stages, const std::string &conditions) {
    Panel panel = lines({"frame-" + std::to_string(spp),
                         "BVH and rays of a frame, " + std::to_string(spp) + (spp == 1 ? " sample a pixel" : " samples a pixel"),
                         conditions + "; 512 x 512 pixels, 2.5 rays a sample",
                         {"twist", "rad/m"},
                         {"update and rays", "ms"},
                         {}});
    const auto add = [&](const std::string &series, const Stage &stage, std::size_t i, bool isDefault) {
        const Measured rays = stage.trace[i] * (1e3 * raysOf(spp));
        const Measured update = stage.update[i] * 1e3;
        const Measured both{rays.value + update.value, rays.spread + update.spread, rays.repetitions};
        panel.points.push_back({series, digits(stage.twist), {stage.twist}, both, isDefault});
    };
    for (std::size_t i = 0; i < 4; ++i)
        for (const Stage &stage : stages) add(kUpdates[i].name, stage, i, false);
    for (const Stage &stage : stages) add("policy", stage, chosenAt(stage, raysOf(spp)), true);
    return panel;
}

/// Rays from which a rebuild pays, measured and by the policy.
Panel switchPanel(const std::vector<Stage> &stages, const std::string &conditions) {
    Panel panel = lines({"switch",
                         "Where a rebuild pays",
                         conditions + "; measured: (rebuild - refit) / what a ray loses",
                         {"growth of the boxes since the last build, less 1", ""},
                         {"rays a frame", ""},
                         {}});
    for (const Stage &stage : stages) {
        const double lost = stage.trace[0].value - stage.trace[2].value;
        const double lostSpread = stage.trace[0].spread + stage.trace[2].spread;
        if (!(stage.growth > 1 && lost > lostSpread)) continue;
        const double build = stage.update[2].value - stage.update[0].value;
        const double rays = build / lost;
        const double spread = rays * std::hypot((stage.update[2].spread + stage.update[0].spread) / build, lostSpread / lost);
        panel.points.push_back({"measured", digits(stage.twist), {stage.growth - 1}, {rays, spread, stage.trace[0].repetitions}, false});
    }
    for (const Stage &stage : stages)
        if (stage.growth > 1) // else it never rebuilds
            panel.points.push_back({"policy", digits(stage.twist), {stage.growth - 1}, {stage.policyRays}, true});
    return panel;
}

/// How much longer than the better of refitting and rebuilding a frame takes at worst: always refitted, or by the policy.
double worstLoss(const std::vector<Stage> &stages, int spp, bool policy) {
    double worst = 1;
    for (const Stage &stage : stages) {
        const auto seconds = [&](std::size_t i) { return stage.update[i].value + stage.trace[i].value * raysOf(spp); };
        worst = std::max(worst, seconds(policy ? chosenAt(stage, raysOf(spp)) : 0) / std::min(seconds(0), seconds(2)));
    }
    return worst;
}

} // namespace

Chart measureBvh(const ChartOptions &options) {
    const Scene scene = twistingScene(448); // 100,352 triangles
    const std::vector<double> twists = options.effort == Effort::Quick ? std::vector<double>{0.5, 1, 2, 4, 7}
                                                                       : std::vector<double>{0.125, 0.25, 0.5, 1, 1.5, 2, 3, 4, 6, 8, 12};
    const std::vector<Stage> stages = measureStages(scene, twists, options.pick(9, 31));
    const std::string conditions = "torus of 100k triangles, built at rest; camera and scattered rays; one thread";
    Chart chart{
        "bvh", "BVH of a deforming mesh",
        "What a frame does to a BVH that was built for the mesh at rest: refit its boxes, or build anew at Embree's low, "
        "medium or high quality. Truth is the clock: all give the same hits.",
        "The first plots: left is a quicker update, down quicker rays. The others add both up for a frame of so many samples, and show "
        "from how many rays a frame on a rebuild pays, by the clock and by the policy, which looks at boxes alone."};
    chart.panels.push_back(stagePanel("mild", stages[0], conditions));
    chart.panels.push_back(stagePanel("strong", stages[stages.size() - 2], conditions));
    for (const int spp : {1, RenderSettings{}.spp}) chart.panels.push_back(framePanel(spp, stages, conditions));
    chart.panels.push_back(switchPanel(stages, conditions));
    const int spp = RenderSettings{}.spp;
    const auto percent = [&](bool policy) { return digits(100 * (worstLoss(stages, spp, policy) - 1), 2); };
    chart.choice =
        "Default: refit until the policy finds that the frame's rays would pay for a build, then rebuild at medium quality. At " +
        std::to_string(spp) + " samples a pixel its frames take at most " + percent(true) +
        " % longer than the better of refit and rebuild, where frames that are always refitted take up to " + percent(false) + " %.";
    return chart;
}

} // namespace taut::chart
