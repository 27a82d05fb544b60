#include "taut/plan/mesh_questions.h"

#include "taut/scene/memory_estimate.h"
#include "taut/scene/ranges.h"

#include <algorithm>

namespace taut {

namespace {

/// A lobe's relative change for a relative change of both its widths, at its peak.
constexpr float kPeakFactor = 2;
/// Of maps, where nobody looks at their texels.
constexpr float kTypicalSlope = 0.5F;
/// Most faces that a plan refines a mesh to.
constexpr std::size_t kMostFaces = 4U << 20U;
/// Root mean square over vertices to that over the pixels of a view, which may see the worse part.
constexpr float kViewFactor = 2;

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

Question stretchQuestion(const Object &object, const GradientField &field, const AlphaRange &alpha, const PlanCosts &costs) {
    Question q;
    const bool inert = !(alpha.greatest.x > 0) || !object.follow || isRigid(object);
    const float leanError = object.lean ? 4 * field.lean * std::fmin(alpha.greatest.x, 1.0F) + kPeakFactor * field.logNormalStretch : 0.0F;
    q.choices.push_back({StretchModel::Constant, inert ? 0.0F : kPeakFactor * alpha.sensitivity * field.logStretch + leanError, 0, 0, {}});
    if (inert) return q;
    q.choices.push_back({StretchModel::Uniform, kPeakFactor * alpha.sensitivity * field.fromMean + leanError, costs.uniform, 0, {}});
    q.choices.push_back({StretchModel::PerVertex, leanError, costs.vertex, 0, {}});
    if (object.lean) q.choices.push_back({StretchModel::Leaning, 0, costs.lean, 0, {}});
    return q;
}

Question interpolationQuestion(const GradientField &field, const AlphaRange &alpha, const PlanCosts &costs) {
    return {{{GradientInterpolation::Face, kPeakFactor * alpha.sensitivity * field.withinFace, costs.face, 0, {}},
             {GradientInterpolation::Stretch, 0, costs.vertex, 0, {}}},
            0};
}

/// The exact estimators are the cheapest as well (chart gradient): a fit costs more than carrying two vectors along.
Question gradientQuestion(GradientEstimator estimator, const PlanCosts &costs) {
    if (estimator == GradientEstimator::Limit) return {{{estimator, 0, costs.limit, 0, {}}}, 0};
    return {{{GradientEstimator::Analytic, 0, costs.analytic, 0, {}}}, 0};
}

float leastRestAlpha(const Scene &scene, const Object &object) {
    float least = 1;
    for (const Index m : object.materials)
        if (hasMicrosurface(scene.materials[m])) least = std::fmin(least, restAlpha(scene.materials[m]).least);
    return least;
}

/// Share of the image's mean square that a silhouette changes when positions are off by `error` metres, its root.
float silhouetteError(const Scene &scene, const RefinementError &box, float error) {
    const std::vector<int> &frames = scene.render.frames;
    const CameraState camera = cameraAtFrame(scene.camera, frames[frames.size() / 2], scene.render.fps);
    const DVec3 eye(camera.worldFromCamera[3]);
    const DVec3 nearest = glm::clamp(eye, DVec3(box.lower), DVec3(box.upper));
    const double size = glm::length(DVec3(box.upper - box.lower));
    const double distance = std::max(glm::length(eye - nearest), 0.05 * size);
    const double height = camera.orthoHeight > 0 ? camera.orthoHeight : 2 * std::tan(0.5 * camera.fovY) * distance;
    const double pixel = height / scene.render.height;
    const double outline = std::min(1.0, 3.1416 * (size / pixel) / (static_cast<double>(scene.render.width) * scene.render.height));
    const double pixels = static_cast<double>(error) / pixel;
    // Up to a pixel, the pixels of the outline change by the share that is uncovered; from there on more of them do.
    return static_cast<float>(std::sqrt(outline * std::min(pixels * pixels, pixels)));
}

} // namespace

bool hasMicrosurface(const Material &material) {
    return bsdfInfo(material.type).microsurface;
}

void AlphaRange::add(const AlphaRange &other) {
    least = std::fmin(least, other.least);
    greatest = glm::max(greatest, other.greatest);
    sensitivity = std::fmax(sensitivity, other.sensitivity);
}

/// Singular values of a product are at most those of one factor times the greatest of the other.
AlphaRange deformedAlpha(const Material &material, const GradientField &field) {
    const RestAlpha rest = restAlpha(material);
    AlphaRange range{rest.least / field.greatestStretch, rest.greatest / field.leastStretch};
    // A relative change of V moves a facet by that share of its slope, and roughens by that strain: against alpha.
    const float moved = (material.slopes.isGiven() ? kTypicalSlope : 0.0F) + material.roughening;
    range.sensitivity = 1 + moved / range.least;
    return range;
}

int mostLevel(const Scene &scene, const Object &object) {
    int level = 1;
    while (level < kMaxSubdivisionLevel && object.mesh->faceCount() << (2 * (static_cast<std::size_t>(level) + 1)) <= kMostFaces) ++level;
    return levelWithin(scene.budget.get(), object, scene.render, level);
}

Question subdivisionQuestion(const Scene &scene, const Object &object, const RefinementError &probe, const PlanScales &scales,
                             const PlanCosts &costs) {
    const float leastAlpha = leastRestAlpha(scene, object);
    const int most = mostLevel(scene, object);
    Question q;
    for (int level = 1; level <= most; ++level) {
        const float scale = std::pow(4.0F, static_cast<float>(kProbeLevel - level));
        const float lobes = kViewFactor * kPeakFactor * scale * (probe.stretch + probe.normal / std::fmin(leastAlpha, 1.0F));
        const float measured = scales.subdivision * std::pow(4 / scales.subdivisionRatio, static_cast<float>(level - kProbeLevel));
        q.choices.push_back({SubdivisionLevel{level},
                             measured * (lobes + silhouetteError(scene, probe, scale * probe.position)),
                             probe.vertices / scale * (costs.limit + costs.refit) * 1e-3F,
                             0,
                             {}});
    }
    q.choices.back().error = 0; // the finest level is what the full model takes
    return q;
}

void planMesh(const Object &object, const GradientField &field, const AlphaRange &alpha, float left, float scale,
              const PlanCosts &costs, MeshPlan &plan) {
    const auto ask = [&](Question question) -> const Question & {
        scaleErrors(question, scale);
        take(question, left);
        return plan.questions.emplace_back(std::move(question));
    };
    plan.stretch = ask(stretchQuestion(object, field, alpha, costs)).answer<StretchModel>();
    if (plan.stretch == StretchModel::PerVertex && !object.interpolation)
        plan.interpolation = ask(interpolationQuestion(field, alpha, costs)).answer<GradientInterpolation>();
    if (!object.gradient && !isRigid(object)) ask(gradientQuestion(plan.estimator, costs));
}

} // namespace taut
