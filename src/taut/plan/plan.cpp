#include "taut/plan/plan.h"

#include "taut/base/frame.h"
#include "taut/microsurface/transform.h"
#include "taut/plan/gradient_field.h"
#include "taut/plan/light_coverage.h"
#include "taut/plan/refinement_error.h"
#include "taut/scene/check_scene.h"
#include "taut/scene/ranges.h"

#include <algorithm>

namespace taut {

namespace {

/// Share of the tolerance that what is lost between facets may take; the rest is for the gradient.
constexpr float kMultiscatterShare = 0.5F;
/// Total variation between the compensation's lobe and the walk's, weighed for the smoothing that any light does to lobes so broad.
constexpr float kCompensationLobeError = 0.35F;
/// Variance of the light of several facets over that of independent paths without next events, measured over the scenes of `taut chart
/// plan` and `render`: with it, mended error over noise, squared, comes out within a factor of three where it is near one.
constexpr float kNoiseShare = 0.33F;
/// A grazing view loses more than the average over views.
constexpr float kGrazingLoss = 2;
/// A lobe's relative change for a relative change of both its widths, at its peak.
constexpr float kPeakFactor = 2;

// Measured on two cores at 2.5 GHz (taut_surface_bench, charts sampling, gradient and plan), nanoseconds.
constexpr float kUniformCost = 9;
constexpr float kFaceCost = 11;
constexpr float kVertexCost = 16;
constexpr float kLeanCost = 21;
constexpr float kLimitCost = 83;
constexpr float kAnalyticCost = 128;
constexpr float kCompensationCost = 240; ///< over single scattering, as the walk's, from chart multiscatter
constexpr float kWalkCost = 60;
constexpr float kWalkLossCost = 550; ///< more, for each part of the light that meets several facets
constexpr float kWalkVariance = 14;  ///< and that much more variance, each part over the variance of single scattering
constexpr float kRefitCost = 45;     ///< a vertex, of its BVH

/// Level at which refinement errors are measured; those of the others follow, at a factor of four a level.
constexpr int kProbeLevel = 2;
/// Most faces that a plan refines a mesh to.
constexpr std::size_t kMostFaces = 4U << 20U;
/// Root mean square over vertices to that over the pixels of a view, which may see the worse part.
constexpr float kViewFactor = 2;

bool hasMicrosurface(const Material &material) {
    return bsdfInfo(material.type).microsurface;
}

/// A material's alphas before deformation; a texture multiplies its value by 0 to 1.
struct RestAlpha {
    float least;   ///< of both
    Vec2 greatest; ///< of the rougher and of the smoother one
};
RestAlpha restAlpha(const Material &material) {
    const auto range = [&](const FloatParam &p) {
        float upper = p.value;
        float lower = p.texture == kNone ? p.value : 0.0F;
        if (material.alphaIsRoughness) {
            upper *= upper;
            lower *= lower;
        }
        return glm::clamp(Vec2(lower, upper), Vec2(kLeastAlpha), Vec2(kMostAlpha));
    };
    const Vec2 x = range(material.alphaX);
    const Vec2 y = range(material.alphaY);
    RestAlpha rest{std::min(x.x, y.x), {std::max(x.y, y.y), std::min(x.y, y.y)}};
    // KHR_materials_anisotropy makes alpha rougher along its direction, up to 1.
    if (material.anisotropyStrength != 0)
        rest.greatest.x = std::max(rest.greatest.x, glm::mix(rest.greatest.x, 1.0F, sqr(material.anisotropyStrength)));
    return rest;
}

/// Takes the cheapest choice whose error fits into what is left, and spends it. The last choice is the model itself, without error.
void take(Question &question, float &left) {
    question.taken = question.choices.size() - 1;
    for (std::size_t i = 0; i < question.choices.size(); ++i)
        if (question.choices[i].error <= left) {
            question.taken = i;
            break;
        }
    left -= question.choices[question.taken].error;
}

/// The materials' alphas over everything that a mesh does.
struct AlphaRange {
    float least = kInfinity;
    Vec2 greatest{0}; ///< of the rougher and of the smoother one: singular values of a product are at most those of one factor times
                      ///< the greatest of the other
    void add(const RestAlpha &rest, const GradientField &field) {
        least = std::fmin(least, rest.least / field.greatestStretch);
        greatest = glm::max(greatest, rest.greatest / field.leastStretch);
    }
    void add(const AlphaRange &other) {
        least = std::fmin(least, other.least);
        greatest = glm::max(greatest, other.greatest);
    }
};

Question stretchQuestion(const Object &object, const GradientField &field, const AlphaRange &alpha, bool microsurface) {
    Question q{"stretch", "ns a hit", {}, 0};
    const bool inert = !microsurface || !object.follow || isRigid(object);
    const float leanError = object.lean ? 4 * field.lean * std::fmin(alpha.greatest.x, 1.0F) + kPeakFactor * field.logNormalStretch : 0.0F;
    q.choices.push_back({"constant", inert ? 0.0F : kPeakFactor * field.logStretch + leanError, 0});
    if (inert) return q;
    q.choices.push_back({"uniform", kPeakFactor * field.fromMean + leanError, kUniformCost});
    q.choices.push_back({"per vertex, 3 numbers", leanError, kVertexCost});
    if (object.lean) q.choices.push_back({"leaning, 5 numbers", 0, kLeanCost});
    return q;
}

Question interpolationQuestion(const GradientField &field) {
    return {"interpolation", "ns a hit", {{"face", kPeakFactor * field.withinFace, kFaceCost}, {"stretch", 0, kVertexCost}}, 0};
}

/// The exact estimators are the cheapest as well (chart gradient): a fit costs more than carrying two vectors along.
Question gradientQuestion(GradientEstimator estimator) {
    if (estimator == GradientEstimator::Limit) return {"gradient", "ns a vertex", {{"limit", 0, kLimitCost}}, 0};
    return {"gradient", "ns a vertex", {{"analytic", 0, kAnalyticCost}}, 0};
}

float leastRestAlpha(const Scene &scene, const Object &object) {
    float least = 1;
    for (const Index m : object.materials)
        if (hasMicrosurface(scene.materials[m])) least = std::fmin(least, restAlpha(scene.materials[m]).least);
    return least;
}

/// The finest level that a plan considers.
int mostLevel(const Object &object) {
    int level = 1;
    while (level < kMaxSubdivisionLevel && object.mesh->faceCount() << (2 * (static_cast<std::size_t>(level) + 1)) <= kMostFaces) ++level;
    return level;
}

/// Share of the image's mean square that a silhouette changes when positions are off by `error` metres, its root.
float silhouetteError(const Scene &scene, const RefinementError &box, float error) {
    const std::vector<int> &frames = scene.render.frames;
    const CameraState camera = cameraAtFrame(scene.camera, frames[frames.size() / 2], scene.render.fps);
    const DVec3 eye(camera.worldFromCamera[3]);
    const DVec3 nearest = glm::clamp(eye, DVec3(box.lower), DVec3(box.upper));
    const double size = glm::length(DVec3(box.upper - box.lower));
    const double distance = std::max(glm::length(eye - nearest), 0.05 * size);
    const double pixel = 2 * std::tan(0.5 * camera.fovY) * distance / scene.render.height;
    const double outline = std::min(1.0, 3.1416 * (size / pixel) / (static_cast<double>(scene.render.width) * scene.render.height));
    const double pixels = static_cast<double>(error) / pixel;
    // Up to a pixel, the pixels of the outline change by the share that is uncovered; from there on more of them do.
    return static_cast<float>(std::sqrt(outline * std::min(pixels * pixels, pixels)));
}

/// Errors of normals, V and outline between the vertices of each level.
Question subdivisionQuestion(const Scene &scene, const Object &object, const RefinementError &probe, float leastAlpha) {
    Question q{"subdivision", "us a frame", {}, 0};
    for (int level = 1; level <= mostLevel(object); ++level) {
        const float scale = std::pow(4.0F, static_cast<float>(kProbeLevel - level));
        const float lobes = kViewFactor * kPeakFactor * scale * (probe.stretch + probe.normal / std::fmin(leastAlpha, 1.0F));
        q.choices.push_back({"level " + std::to_string(level), lobes + silhouetteError(scene, probe, scale * probe.position),
                             probe.vertices / scale * (kLimitCost + kRefitCost) * 1e-3F});
    }
    q.choices.back().error = 0; // the finest level is what the full model takes
    return q;
}

void planMesh(const Object &object, const GradientField &field, const AlphaRange &alpha, bool microsurface, float left, MeshPlan &plan) {
    Question stretch = stretchQuestion(object, field, alpha, microsurface);
    take(stretch, left);
    const std::string &model = stretch.choices[stretch.taken].name;
    plan.stretch = model == "constant"                                          ? StretchModel::Constant
                   : model == "uniform"                                         ? StretchModel::Uniform
                   : object.lean && stretch.taken + 1 == stretch.choices.size() ? StretchModel::Leaning
                                                                                : StretchModel::PerVertex;
    plan.questions.push_back(std::move(stretch));
    const bool perVertex = plan.stretch == StretchModel::PerVertex;
    if (perVertex && !object.interpolation) {
        Question interpolation = interpolationQuestion(field);
        take(interpolation, left);
        plan.interpolation = interpolation.taken == 0 ? GradientInterpolation::Face : GradientInterpolation::Stretch;
        plan.questions.push_back(std::move(interpolation));
    }
    if (!object.gradient && !isRigid(object)) plan.questions.push_back(gradientQuestion(plan.estimator));
}

/// Share of diffuse light that meets several facets.
float lossAt(const Vec2 &alpha) {
    return 1 - energy::averageAlbedo(microTransformFromAlpha(alpha.x, alpha.y));
}

MultiscatterPlan planMultiscatter(const Material &material, const Vec2 &greatestAlpha, float budget) {
    MultiscatterPlan plan;
    const bool isOpen = material.multiscatter == Multiscatter::Auto && multiscatterOf(material, Multiscatter::Auto) == Multiscatter::Auto;
    if (!isOpen) return plan;
    const float loss = lossAt(greatestAlpha);
    plan.negligibleLoss = 0.5F * budget / kGrazingLoss;
    Question q{"multiscatter", "ns a hit at equal noise", {{"off", kGrazingLoss * loss, 0}}, 0};
    const float walkCost = (kWalkCost + kWalkLossCost * loss) * (1 + kWalkVariance * loss);
    if (bsdfInfo(material.type).compensates() && kCompensationCost < walkCost)
        q.choices.push_back(
            {"compensation where M asks for it", kGrazingLoss * plan.negligibleLoss + kCompensationLobeError * loss, kCompensationCost});
    q.choices.push_back({"walk", 0, walkCost});
    float left = budget;
    take(q, left);
    const bool walks = q.taken + 1 == q.choices.size();
    plan.model = q.taken == 0 ? Multiscatter::Off : walks ? Multiscatter::Walk : Multiscatter::Auto;
    plan.error = q.choices[q.taken].error;
    plan.question = std::move(q);
    return plan;
}

/// Noise of light that meets several facets over the light itself, both root mean squares of a pixel of n samples.
///
/// A share s, the loss, of the paths meets several facets. Let all of them see radiances of mean m and mean square q = m^2 / coverage.
/// Single scattering weighs each sample by 1 - s: its mean is s m short, its variance (1 - s)^2 (q - m^2) / n. A walk gives every path
/// its whole light instead, which has the variance (q - m^2) / n. So the square of its noise over what it mends is
///     (2 - s) (1 / coverage - 1) / (n s)
/// and a share of that where samples are stratified and lights are looked for as well: even light gets no noisier, small lights do
/// where n s coverage, the number of paths that find one, is small.
float noiseOverLight(float loss, float coverage, int samples) {
    return std::sqrt(kNoiseShare * (2 - loss) * (1 / coverage - 1) / (static_cast<float>(samples) * loss));
}

/// Takes single scattering after all where what it lacks is less than the noise of the treatments that have it: both send light of
/// several facets to about every direction, where few paths find a small light.
void weighNoise(MultiscatterPlan &plan, float noise) {
    Question &q = *plan.question;
    const float lost = q.choices.front().error;
    for (std::size_t i = 1; i < q.choices.size(); ++i) q.choices[i].noise = noise * lost;
    if (!(noise > 1)) return;
    q.taken = 0;
    plan.model = Multiscatter::Off;
    plan.error = lost;
}

/// How much of what a material's objects see is bright, at most. Its last facet spreads a light over the width of its lobe.
float coverageOfMaterial(const Scene &scene, Index material, const SceneLights &lights, int frame, const Vec2 &alpha) {
    float coverage = 0;
    for (const Object &object : scene.objects) {
        if (std::find(object.materials.begin(), object.materials.end(), material) == object.materials.end()) continue;
        const Bounds box = worldBounds(object, frame, scene.render.fps);
        if (!box.empty()) coverage = std::fmax(coverage, lightCoverage(lights, box, 4 * kPi * alpha.x * alpha.y)); // 1 / the peak of D / 4
    }
    return coverage > 0 ? coverage : 1;
}

std::vector<int> spreadFrames(const std::vector<int> &frames) {
    const std::size_t count = std::min<std::size_t>(frames.size(), kPlanFrames);
    std::vector<int> spread;
    for (std::size_t i = 0; i < count; ++i) spread.push_back(frames[count == 1 ? 0 : i * (frames.size() - 1) / (count - 1)]);
    return spread;
}

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
    return plan;
}

ScenePlan fullPlan(const Scene &scene) {
    ScenePlan plan = defaultPlan(scene);
    for (std::size_t i = 0; i < plan.meshes.size(); ++i)
        if (scene.objects[i].planLevel) plan.meshes[i].subdivisionLevel = mostLevel(scene.objects[i]);
    for (MultiscatterPlan &material : plan.materials) material.model = Multiscatter::Walk;
    plan.mayRefit = false;
    return plan;
}

ScenePlan makePlan(const Scene &scene, std::optional<float> asked) {
    ScenePlan plan = defaultPlan(scene);
    const float tolerance = asked.value_or(kDefaultTolerance);
    plan.tolerance = tolerance;
    const std::vector<int> frames = spreadFrames(scene.render.frames);
    std::vector<Vec2> greatestAlpha(scene.materials.size(), Vec2(0));
    const float gradientBudget = (1 - kMultiscatterShare) * tolerance;
    for (std::size_t i = 0; i < scene.objects.size(); ++i) {
        const Object &object = scene.objects[i];
        MeshPlan &mesh = plan.meshes[i];
        bool microsurface = false;
        for (const Index m : object.materials) microsurface |= hasMicrosurface(scene.materials[m]);
        float left = gradientBudget;
        if (object.planLevel) {
            Question level = subdivisionQuestion(scene, object, measureRefinement(object, kProbeLevel, frames, scene.render.fps),
                                                 leastRestAlpha(scene, object));
            take(level, left);
            mesh.subdivisionLevel = static_cast<int>(level.taken) + 1;
            mesh.questions.push_back(std::move(level));
        }
        GradientField field;
        if (!isRigid(object)) field = measureGradientField(object, mesh.subdivisionLevel, frames, scene.render.fps);
        AlphaRange alpha;
        for (const Index m : object.materials) {
            if (!hasMicrosurface(scene.materials[m])) continue;
            AlphaRange own;
            own.add(restAlpha(scene.materials[m]), object.follow ? field : GradientField{});
            alpha.add(own);
            greatestAlpha[m] = glm::max(greatestAlpha[m], own.greatest);
        }
        if (alpha.greatest.x > 0) {
            mesh.leastAlpha = alpha.least;
            mesh.greatestAlpha = alpha.greatest.x;
        }
        planMesh(object, field, alpha, microsurface, left, mesh);
        float error = 0;
        for (const Question &q : mesh.questions) error += q.choices[q.taken].error;
        plan.predictedError = std::fmax(plan.predictedError, error);
    }
    float worst = 0;
    std::optional<SceneLights> lights;
    const int middle = frames[frames.size() / 2];
    for (std::size_t m = 0; m < scene.materials.size(); ++m) {
        const Vec2 alpha = glm::clamp(greatestAlpha[m], Vec2(kLeastAlpha), Vec2(kMostAlpha));
        MultiscatterPlan &material = plan.materials[m];
        material = planMultiscatter(scene.materials[m], alpha, kMultiscatterShare * tolerance);
        if (!asked && material.model != Multiscatter::Off && material.question) {
            if (!lights) lights = lightsOf(scene, middle);
            const float coverage = coverageOfMaterial(scene, static_cast<Index>(m), *lights, middle, alpha);
            weighNoise(material, noiseOverLight(lossAt(alpha), coverage, scene.render.spp));
        }
        if (material.error > kMultiscatterShare * tolerance)
            plan.errorInNoise = std::fmax(plan.errorInNoise, material.error);
        else
            worst = std::fmax(worst, material.error);
    }
    plan.predictedError += worst;
    return plan;
}

} // namespace taut
