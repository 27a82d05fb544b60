#pragma once
/// Which model of the deformed microsurface each mesh gets: no more than the scene needs (docs/pipeline.md, "Plan").
///
/// Every saving has a predicted error: the root mean square of the change that it makes to the image, relative to that of the
/// image. Predictions are bounds made from the gradient field and the materials' roughness over the frames (mesh_questions.cpp and
/// multiscatter_question.cpp say how); the errors of what is chosen together stay below the tolerance. Where nobody gives one, light
/// that meets several facets is also weighed against the noise that it brings at the scene's samples a pixel (light_coverage.h).

#include "taut/bsdf/bsdf_types.h"
#include "taut/plan/costs.h"
#include "taut/plan/gradient_field.h"
#include "taut/plan/question.h"

#include <optional>

namespace taut {

struct MeshPlan {
    StretchModel stretch = StretchModel::PerVertex;
    GradientEstimator estimator = GradientEstimator::Analytic;
    GradientInterpolation interpolation = GradientInterpolation::Stretch;
    int subdivisionLevel = 0;
    float leastAlpha = 0, greatestAlpha = 0; ///< of its materials over the frames, deformed; 0 without a microsurface or a plan
    std::vector<Question> questions;         ///< how it came to that; empty for a plan that was not chosen
};

/// What is done about light that meets several facets, where a material says "auto".
struct MultiscatterPlan {
    Multiscatter model = Multiscatter::Auto; ///< Off and Walk everywhere; Auto: by the M of each hit,
    float negligibleLoss = kNegligibleLoss;  ///< with this share of light that may be lost
    float error = 0;                         ///< predicted
    std::optional<Question> question;        ///< how it came to that; none where the material says itself
};

/// How the textures of a material with a map of slopes are looked up.
struct DetailPlan {
    TextureDetail detail = TextureDetail::Map; ///< Map or Moments
    float error = 0;                           ///< predicted
    std::optional<Question> question;          ///< how it came to that; none where there is no map, or the material says itself
};

struct ScenePlan {
    std::vector<MeshPlan> meshes;            ///< [scene.objects]
    std::vector<MultiscatterPlan> materials; ///< [scene.materials]
    std::vector<DetailPlan> details;         ///< [scene.materials]
    float bearableWaste = kBearableWaste;    ///< of the sampler of reflections
    BvhKind bvh = BvhKind::Rebuild;          ///< of what deforms, where more than one frame is asked for
    float tolerance = 0;
    float predictedError = 0; ///< of all that is saved, at most the tolerance; but for
    float errorInNoise = 0;   ///< light of several facets that is left out because it would bring more noise than that
};

/// The model where nobody asked for a plan: per vertex, by each object's own or default estimator, interpolated as Stretch. Builds
/// nothing.
ScenePlan defaultPlan(const Scene &scene);

/// `--model full`: the reference that every plan is held against. Everything per vertex and per hit, the random walk for "auto".
ScenePlan fullPlan(const Scene &scene);

inline constexpr int kPlanFrames = 9;

/// The tolerance where nobody gives one.
inline constexpr float kDefaultTolerance = 0.01F;

struct PlanOptions {
    std::optional<float> tolerance; ///< none: the default, and of multiple scattering no more than shows at the scene's samples a pixel
    bool full = false;              ///< the full plan, with what is asked for below
    bool report = false;            ///< for `taut info`: gradient fields over all frames, and the question of each mesh's BVH
    PlanCosts costs;
};

/// A plan with what was built on the way to it. What an object's surface is made of is built once: the renderer takes it from here.
struct PlannedScene {
    ScenePlan plan;
    std::vector<ObjectSurface> surfaces; ///< [scene.objects], of the level taken; one that no question needed has no object
    std::vector<GradientField> fields;   ///< [scene.objects] over all frames, where a report was asked for
};

/// The cheapest model whose predicted error stays below the tolerance over the scene's frames, whatever its noise. Evaluates the objects
/// that deform at up to kPlanFrames frames, for a report at all. Surfaces refer to the scene's
/// objects until a renderer takes them over.
PlannedScene planScene(const Scene &scene, const PlanOptions &options = {});

/// The plan alone.
ScenePlan makePlan(const Scene &scene, std::optional<float> tolerance = std::nullopt);

} // namespace taut
