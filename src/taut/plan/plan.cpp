#include "taut/plan/plan.h"

#include "taut/plan/bvh_question.h"
#include "taut/plan/detail_question.h"
#include "taut/plan/mesh_questions.h"
#include "taut/plan/multiscatter_question.h"
#include "taut/scene/check_scene.h"
#include "taut/scene/memory_estimate.h"
#include "taut/scene/ranges.h"

#include <algorithm>

namespace taut {

namespace {

/// Share of the tolerance that what is lost between facets may take; the rest is for the gradient.
constexpr float kMultiscatterShare = 0.5F;
/// And what maps of slopes seen from afar may take of the gradient's part.
constexpr float kDetailShare = 0.25F;

/// The places among the scene's frames that a plan looks at.
std::vector<std::size_t> spreadFrames(std::size_t frames) {
    const std::size_t count = std::min<std::size_t>(frames, kPlanFrames);
    std::vector<std::size_t> spread;
    for (std::size_t i = 0; i < count; ++i) spread.push_back(count == 1 ? 0 : i * (frames - 1) / (count - 1));
    return spread;
}

std::vector<int> levelsOf(const ScenePlan &plan) {
    std::vector<int> levels;
    for (const MeshPlan &mesh : plan.meshes) levels.push_back(mesh.subdivisionLevel);
    return levels;
}

/// What an object does over the frames.
struct ObjectFacts {
    GradientField field;
    RefinementError probe;       ///< where the plan chooses the level
    std::vector<float> hardness; ///< [frames looked at] of it, without a unit
    AlphaRange alpha;            ///< of its materials
    bool isMapped = false;
};

} // namespace

struct ScenePlanner::State {
    State(const Scene &scene_, const PlanOptions &options_)
        : scene(scene_), options(options_), spread(spreadFrames(scene.render.frames.size())) {
        check(scene);
        planned.surfaces.resize(scene.objects.size());
        facts.resize(scene.objects.size());
        greatestAlpha.assign(scene.materials.size(), Vec2(0));
        std::vector<float> leastAlpha(scene.materials.size(), kInfinity);
        for (std::size_t i = 0; i < scene.objects.size(); ++i) {
            look(i);
            const Object &object = scene.objects[i];
            for (const Index m : object.materials) {
                if (options.full || !hasMicrosurface(scene.materials[m])) continue;
                const AlphaRange own = deformedAlpha(scene.materials[m], object.follow ? facts[i].field : GradientField{});
                facts[i].alpha.add(own);
                greatestAlpha[m] = glm::max(greatestAlpha[m], own.greatest);
                leastAlpha[m] = std::fmin(leastAlpha[m], own.least);
            }
        }
        for (Index m = 0; m < scene.materials.size(); ++m)
            details.push_back(options.full ? std::nullopt : detailQuestion(scene, m, leastAlpha[m], middleFrame()));
    }

    const Scene &scene;
    const PlanOptions &options;
    std::vector<std::size_t> spread;
    std::vector<ObjectFacts> facts;               // [objects]
    std::vector<Vec2> greatestAlpha;              // [materials] deformed
    std::vector<std::optional<Question>> details; // [materials]
    PlannedScene planned;

    [[nodiscard]] int middleFrame() const { return scene.render.frames[spread[spread.size() / 2]]; }
    [[nodiscard]] bool choosesLevel(std::size_t i) const { return scene.objects[i].planLevel && !options.full; }

    ObjectSurface &surfaceAt(std::size_t i, int level) {
        const Object &object = scene.objects[i];
        ObjectSurface &surface = planned.surfaces[i];
        if (surface.object != nullptr) return surface;
        prepareObjectSurface(object, scene.render.fps, defaultEstimator(object), level, surface);
        compact(surface);
        return surface;
    }

    /// Brings a surface to each of the frames in turn, world space.
    template <class Look> void overFrames(ObjectSurface &surface, bool all, const Look &look) const {
        const std::vector<int> &frames = scene.render.frames;
        double ignored = 0;
        for (std::size_t k = 0; k < frames.size(); ++k) {
            if (!all && !std::binary_search(spread.begin(), spread.end(), k)) continue;
            deformAtFrame(surface, frames[k], scene.render.fps, DMat4(1), ignored, ignored);
            look(k);
        }
    }

    /// The level that a mesh is looked at; where the plan chooses, none finer is needed for that.
    [[nodiscard]] int probeLevel(std::size_t i) const { return choosesLevel(i) ? kProbeLevel : scene.objects[i].subdivision.level; }

    void look(std::size_t i) {
        const Object &object = scene.objects[i];
        ObjectFacts &fact = facts[i];
        fact.isMapped =
            std::any_of(object.materials.begin(), object.materials.end(), [&](Index m) { return scene.materials[m].slopes.isGiven(); });
        if (options.full || (!choosesLevel(i) && isRigid(object))) return;
        if (choosesLevel(i) && scene.budget)
            scene.budget->require(objectBytes(object, scene.render, kProbeLevel), "mesh " + quoted(object.name), "subdivision = \"auto\"");
        overFrames(surfaceAt(i, probeLevel(i)), false, [&](std::size_t) {
            const ObjectSurface &surface = planned.surfaces[i];
            if (!isRigid(object)) fact.field.add(surface);
            if (!choosesLevel(i)) return;
            fact.probe.add(surface);
            RefinementError now;
            now.add(surface);
            fact.hardness.push_back(now.normal + now.stretch);
        });
    }

    void planObject(std::size_t i, const PlanScales &scales, ScenePlan &plan) const {
        const Object &object = scene.objects[i];
        MeshPlan &mesh = plan.meshes[i];
        float left = (1 - kMultiscatterShare - (facts[i].isMapped ? kDetailShare : 0)) * plan.tolerance;
        if (object.planLevel) {
            Question question = subdivisionQuestion(scene, object, facts[i].probe, scales, options.costs);
            take(question, left);
            mesh.subdivisionLevel = question.answer<SubdivisionLevel>().level;
            mesh.questions.push_back(std::move(question));
        }
        const AlphaRange &alpha = facts[i].alpha;
        if (alpha.greatest.x > 0) {
            mesh.leastAlpha = alpha.least;
            mesh.greatestAlpha = alpha.greatest.x;
        }
        planMesh(object, facts[i].field, alpha, left, scales.stretch, options.costs, mesh);
        float error = 0;
        for (const Question &q : mesh.questions) error += q.choices[q.taken].error;
        plan.predictedError = std::fmax(plan.predictedError, error);
    }

    void planMaterials(const PlanScales &scales, bool weighsNoise, ScenePlan &plan) const {
        const float budget = kMultiscatterShare * plan.tolerance;
        std::optional<SceneLights> lights;
        float worst = 0;
        float worstDetail = 0;
        for (std::size_t m = 0; m < scene.materials.size(); ++m) {
            const Vec2 alpha = glm::clamp(greatestAlpha[m], Vec2(kLeastAlpha), Vec2(kMostAlpha));
            MultiscatterPlan &material = plan.materials[m];
            material = planMultiscatter(scene.materials[m], alpha, budget, scales, options.costs);
            if (weighsNoise && material.model != Multiscatter::Off && material.question) {
                if (!lights) lights = lightsOf(scene, middleFrame());
                weighNoise(scene, static_cast<Index>(m), alpha, *lights, middleFrame(), material);
            }
            DetailPlan &detail = plan.details[m];
            std::optional<Question> question = details[m];
            if (question) scaleErrors(*question, scales.detail);
            detail = planDetail(scene.materials[m], std::move(question), kDetailShare * plan.tolerance);
            worstDetail = std::fmax(worstDetail, detail.error);
            if (material.error > budget)
                plan.errorInNoise = std::fmax(plan.errorInNoise, material.error);
            else
                worst = std::fmax(worst, material.error);
        }
        plan.predictedError += worst + worstDetail;
    }

    /// What a report shows beside the plan: fields over all frames, of the surfaces that are rendered, and what BVHs will cost.
    void report(const Scene &of, std::size_t i) {
        const bool askBvh = scene.render.frames.size() > 1 && deforms(of.objects[i]);
        BvhForecast forecast(raysPerFrame(scene.render), options.costs.bvh);
        const std::size_t stride = BvhForecast::stride(scene.render.frames.size());
        overFrames(surfaceAt(i, planned.plan.meshes[i].subdivisionLevel), true, [&](std::size_t k) {
            planned.fields[i].add(planned.surfaces[i]);
            if (askBvh && k % stride == 0) forecast.add(planned.surfaces[i]);
        });
        if (askBvh) planned.plan.meshes[i].questions.push_back(forecast.question(planned.plan.bvh));
    }
};

ScenePlanner::ScenePlanner(const Scene &scene, const PlanOptions &options) : state_(std::make_unique<State>(scene, options)) {}
ScenePlanner::~ScenePlanner() = default;

ScenePlan ScenePlanner::decide(const PlanScales &scales, std::optional<float> tolerance) const {
    const State &s = *state_;
    if (s.options.full) return fullPlan(s.scene);
    ScenePlan plan = defaultPlan(s.scene);
    plan.tolerance = tolerance.value_or(kDefaultTolerance);
    for (std::size_t i = 0; i < s.scene.objects.size(); ++i) s.planObject(i, scales, plan);
    s.planMaterials(scales, !tolerance, plan);
    plan.bvh = chooseBvh(s.scene, levelsOf(plan), s.options.costs.bvh);
    return plan;
}

PlannedScene ScenePlanner::finish(ScenePlan plan) {
    State &s = *state_;
    s.planned.plan = std::move(plan);
    if (s.options.report) s.planned.fields.resize(s.scene.objects.size());
    for (std::size_t i = 0; i < s.scene.objects.size(); ++i) {
        const Object &object = s.scene.objects[i];
        const int level = s.planned.plan.meshes[i].subdivisionLevel;
        if (s.choosesLevel(i) && s.scene.budget)
            s.scene.budget->take(objectBytes(object, s.scene.render, level), "mesh " + quoted(object.name),
                                 "level " + std::to_string(level));
        if (level != s.probeLevel(i)) s.planned.surfaces[i] = ObjectSurface();
        if (s.options.report) s.report(s.scene, i);
    }
    return std::move(s.planned);
}

bool ScenePlanner::choosesLevels() const {
    for (std::size_t i = 0; i < state_->facts.size(); ++i)
        if (state_->choosesLevel(i)) return true;
    return false;
}

int ScenePlanner::hardestFrame() const {
    const State &s = *state_;
    std::vector<float> hardness(s.spread.size(), 0.0F);
    for (const ObjectFacts &fact : s.facts)
        for (std::size_t k = 0; k < fact.hardness.size(); ++k) hardness[k] += fact.hardness[k];
    const auto hardest = std::max_element(hardness.begin(), hardness.end());
    const auto k = *hardest > 0 ? static_cast<std::size_t>(hardest - hardness.begin()) : s.spread.size() / 2;
    return s.scene.render.frames[s.spread[k]];
}

namespace {

/// Whether nothing is aimed at: scattered rays alone bring the light of a constant sky.
bool isLitBySkyAlone(const Scene &scene) {
    return scene.environment && scene.environment->constant && scene.lights.empty() &&
           std::none_of(scene.objects.begin(), scene.objects.end(), [](const Object &object) { return emits(object); });
}

} // namespace

ScenePlan defaultPlan(const Scene &scene) {
    check(scene);
    ScenePlan plan;
    // Directions are then all there is of the noise, and the cone is worth its preparation on every surface.
    if (isLitBySkyAlone(scene)) plan.bearableWaste = 0;
    for (const Object &object : scene.objects) {
        MeshPlan mesh;
        mesh.stretch = isRigid(object) || !object.follow ? StretchModel::Constant
                       : object.lean                     ? StretchModel::Leaning
                                                         : StretchModel::PerVertex;
        mesh.estimator = defaultEstimator(object);
        mesh.subdivisionLevel = object.subdivision.level;
        mesh.interpolation = object.interpolation.value_or(GradientInterpolation::Stretch);
        plan.meshes.push_back(std::move(mesh));
    }
    plan.materials.resize(scene.materials.size());
    for (const Material &material : scene.materials)
        plan.details.push_back({material.detail == TextureDetail::Moments ? TextureDetail::Moments : TextureDetail::Map, 0, {}});
    plan.bvh = chooseBvh(scene, levelsOf(plan));
    return plan;
}

ScenePlan fullPlan(const Scene &scene) {
    ScenePlan plan = defaultPlan(scene);
    for (std::size_t i = 0; i < plan.meshes.size(); ++i)
        if (scene.objects[i].planLevel) plan.meshes[i].subdivisionLevel = mostLevel(scene, scene.objects[i]);
    for (MultiscatterPlan &material : plan.materials) material.model = Multiscatter::Walk;
    plan.bvh = BvhKind::Rebuild;
    return plan;
}

PlannedScene planScene(const Scene &scene, const PlanOptions &options) {
    ScenePlanner planner(scene, options);
    return planner.finish(planner.decide({}, options.tolerance));
}

ScenePlan makePlan(const Scene &scene, std::optional<float> tolerance) {
    PlanOptions options;
    options.tolerance = tolerance;
    return planScene(scene, options).plan;
}

} // namespace taut
