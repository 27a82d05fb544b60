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

/// Makes a plan, object by object and material by material.
class Planner {
  public:
    Planner(const Scene &scene, const PlanOptions &options)
        : scene_(scene), options_(options), spread_(spreadFrames(scene.render.frames.size())),
          greatestAlpha_(scene.materials.size(), Vec2(0)), leastAlpha_(scene.materials.size(), kInfinity) {}

    PlannedScene plan() {
        ScenePlan &plan = planned_.plan;
        plan = options_.full ? fullPlan(scene_) : defaultPlan(scene_);
        planned_.surfaces.resize(scene_.objects.size());
        if (options_.report) planned_.fields.resize(scene_.objects.size());
        forecasts_.assign(scene_.objects.size(), BvhForecast(raysPerFrame(scene_.render), options_.costs.bvh));
        if (!options_.full) plan.tolerance = options_.tolerance.value_or(kDefaultTolerance);
        for (std::size_t i = 0; i < scene_.objects.size(); ++i) planObject(i);
        if (!options_.full) {
            planMaterials();
            plan.bvh = chooseBvh(scene_, levelsOf(plan), options_.costs.bvh);
        }
        for (std::size_t i = 0; i < scene_.objects.size(); ++i)
            if (reportsBvh(i)) plan.meshes[i].questions.push_back(forecasts_[i].question(plan.bvh));
        return std::move(planned_);
    }

  private:
    [[nodiscard]] bool reportsBvh(std::size_t i) const {
        return options_.report && scene_.render.frames.size() > 1 && deforms(scene_.objects[i]);
    }

    ObjectSurface &surfaceAt(std::size_t i, int level) {
        const Object &object = scene_.objects[i];
        ObjectSurface &surface = planned_.surfaces[i];
        if (surface.object != nullptr) return surface;
        prepareObjectSurface(object, scene_.render.fps, defaultEstimator(object), level, surface);
        compact(surface);
        return surface;
    }

    /// Brings a surface to each of the frames in turn, world space.
    template <class Look> void overFrames(ObjectSurface &surface, bool all, const Look &look) const {
        const std::vector<int> &frames = scene_.render.frames;
        double ignored = 0;
        for (std::size_t k = 0; k < frames.size(); ++k) {
            const bool planned = std::binary_search(spread_.begin(), spread_.end(), k);
            if (!planned && !all) continue;
            deformAtFrame(surface, frames[k], scene_.render.fps, DMat4(1), ignored, ignored);
            look(k, planned);
        }
    }

    void chooseLevel(std::size_t i, float &left) {
        MeshPlan &mesh = planned_.plan.meshes[i];
        const Object &object = scene_.objects[i];
        if (scene_.budget)
            scene_.budget->require(objectBytes(object, scene_.render, kProbeLevel), "mesh " + quoted(object.name), "subdivision = \"auto\"");
        ObjectSurface &surface = surfaceAt(i, kProbeLevel);
        RefinementError probe;
        overFrames(surface, false, [&](std::size_t, bool) { probe.add(surface); });
        Question question = subdivisionQuestion(scene_, scene_.objects[i], probe, options_.costs);
        take(question, left);
        mesh.subdivisionLevel = question.answer<SubdivisionLevel>().level;
        mesh.questions.push_back(std::move(question));
        if (scene_.budget)
            scene_.budget->take(objectBytes(object, scene_.render, mesh.subdivisionLevel), "mesh " + quoted(object.name),
                                "level " + std::to_string(mesh.subdivisionLevel));
        if (mesh.subdivisionLevel != kProbeLevel) surface = ObjectSurface();
    }

    /// The gradient field over the frames that a plan looks at, and all that a report asks for: one evaluation a frame.
    GradientField measure(std::size_t i) {
        GradientField field;
        const bool asked = !options_.full && !isRigid(scene_.objects[i]);
        if (!asked && !options_.report) return field;
        ObjectSurface &surface = surfaceAt(i, planned_.plan.meshes[i].subdivisionLevel);
        const std::size_t stride = BvhForecast::stride(scene_.render.frames.size());
        overFrames(surface, options_.report, [&](std::size_t k, bool planned) {
            GradientField now;
            now.add(surface);
            if (planned && asked) field.add(now);
            if (options_.report) planned_.fields[i].add(now);
            if (reportsBvh(i) && k % stride == 0) forecasts_[i].add(surface);
        });
        return field;
    }

    void planObject(std::size_t i) {
        const Object &object = scene_.objects[i];
        ScenePlan &plan = planned_.plan;
        MeshPlan &mesh = plan.meshes[i];
        const bool mapped =
            std::any_of(object.materials.begin(), object.materials.end(), [&](Index m) { return scene_.materials[m].slopes.isGiven(); });
        float left = (1 - kMultiscatterShare - (mapped ? kDetailShare : 0)) * plan.tolerance;
        if (object.planLevel && !options_.full) chooseLevel(i, left);
        const GradientField field = measure(i);
        if (options_.full) return;
        AlphaRange alpha;
        for (const Index m : object.materials) {
            if (!hasMicrosurface(scene_.materials[m])) continue;
            const AlphaRange own = deformedAlpha(scene_.materials[m], object.follow ? field : GradientField{});
            alpha.add(own);
            greatestAlpha_[m] = glm::max(greatestAlpha_[m], own.greatest);
            leastAlpha_[m] = std::fmin(leastAlpha_[m], own.least);
        }
        if (alpha.greatest.x > 0) {
            mesh.leastAlpha = alpha.least;
            mesh.greatestAlpha = alpha.greatest.x;
        }
        planMesh(object, field, alpha, left, options_.costs, mesh);
        float error = 0;
        for (const Question &q : mesh.questions) error += q.choices[q.taken].error;
        plan.predictedError = std::fmax(plan.predictedError, error);
    }

    void planMaterials() {
        ScenePlan &plan = planned_.plan;
        const float budget = kMultiscatterShare * plan.tolerance;
        const int middle = scene_.render.frames[spread_[spread_.size() / 2]];
        std::optional<SceneLights> lights;
        float worst = 0;
        float worstDetail = 0;
        for (std::size_t m = 0; m < scene_.materials.size(); ++m) {
            const Vec2 alpha = glm::clamp(greatestAlpha_[m], Vec2(kLeastAlpha), Vec2(kMostAlpha));
            MultiscatterPlan &material = plan.materials[m];
            material = planMultiscatter(scene_.materials[m], alpha, budget, options_.costs);
            if (!options_.tolerance && material.model != Multiscatter::Off && material.question) {
                if (!lights) lights = lightsOf(scene_, middle);
                weighNoise(scene_, static_cast<Index>(m), alpha, *lights, middle, material);
            }
            DetailPlan &detail = plan.details[m];
            detail = planDetail(scene_, static_cast<Index>(m), leastAlpha_[m], middle, kDetailShare * plan.tolerance);
            worstDetail = std::fmax(worstDetail, detail.error);
            if (material.error > budget)
                plan.errorInNoise = std::fmax(plan.errorInNoise, material.error);
            else
                worst = std::fmax(worst, material.error);
        }
        plan.predictedError += worst + worstDetail;
    }

    const Scene &scene_;
    const PlanOptions &options_;
    std::vector<std::size_t> spread_;
    std::vector<Vec2> greatestAlpha_;    // [materials] deformed
    std::vector<float> leastAlpha_;      // [materials] deformed
    std::vector<BvhForecast> forecasts_; // [objects]
    PlannedScene planned_;
};

} // namespace

ScenePlan defaultPlan(const Scene &scene) {
    check(scene);
    ScenePlan plan;
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
    return Planner(scene, options).plan();
}

ScenePlan makePlan(const Scene &scene, std::optional<float> tolerance) {
    PlanOptions options;
    options.tolerance = tolerance;
    return planScene(scene, options).plan;
}

} // namespace taut
