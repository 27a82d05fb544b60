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

#include <memory>
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

/// What predictions are multiplied by: what they were measured to be on a scene, over what the analysis takes them for.
struct PlanScales {
    float subdivision = 1;      ///< at kProbeLevel
    float subdivisionRatio = 4; ///< from level to level
    float stretch = 1;          ///< of V that is not followed, or by fewer numbers
    float off = 1;              ///< of light that meets several facets and is left out
    float compensation = 1;     ///< or compensated for
    float detail = 1;           ///< of moments of maps
};

/// What a pilot found out about a choice.
struct PilotFinding {
    ChoiceValue value;
    float predicted = 0; ///< error by the analysis; 0 where it says nothing
    float error = 0;     ///< measured, relative RMS of the picture
    float spread = 0;    ///< standard error of that
    float noise = 0;     ///< relative RMS at one sample a pixel
    float rays = 0;      ///< a sample
};

/// How an error of the picture that is asked for is split.
struct ErrorBudget {
    float error = 0;      ///< asked for, relative RMS
    float bias = 0;       ///< of the models that are chosen, with its standard error
    float noise = 0;      ///< what is left for noise: their squares make the square of `error`, less a reserve
    int firstSamples = 4; ///< a pixel, before anything is known of the noise
    float samples = 0;    ///< a pixel, foreseen; 0: unknown
};

struct ScenePlan {
    std::vector<MeshPlan> meshes;            ///< [scene.objects]
    std::vector<MultiscatterPlan> materials; ///< [scene.materials]
    std::vector<DetailPlan> details;         ///< [scene.materials]
    float bearableWaste = kBearableWaste;    ///< of the sampler of reflections
    int maxEvents = 0;                       ///< scattering events on a path, where fewer than the scene's do; 0: the scene's
    std::optional<Question> events;          ///< how it came to that
    int motionSteps = 0;                     ///< times within the shutter, where fewer than the scene's do; 0: the scene's
    std::optional<Question> motion;          ///< how it came to that
    BvhKind bvh = BvhKind::Rebuild;          ///< of what deforms, where more than one frame is asked for
    std::vector<PilotFinding> pilots;        ///< none: predictions are the analysis's
    std::optional<ErrorBudget> budget;       ///< where an error is asked for
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
    std::optional<float> error;     ///< of the picture, bias and noise together; the tolerance follows from it (planByPilots)
    bool shares = true;  ///< with an error: pixels share their samples (pixel_filter.h), if nothing but their colour is asked for
    bool full = false;   ///< the full plan, with what is asked for below
    bool report = false; ///< for `taut info`: gradient fields over all frames, and the question of each mesh's BVH
    PlanCosts costs;
};

/// A plan with what was built on the way to it. What an object's surface is made of is built once: the renderer takes it from here.
struct PlannedScene {
    ScenePlan plan;
    std::vector<ObjectSurface> surfaces; ///< [scene.objects], of the level taken; one that no question needed has no object
    std::vector<GradientField> fields;   ///< [scene.objects] over all frames, where a report was asked for
};

/// Makes plans of one scene: looks at it once, decides as often as wanted.
class ScenePlanner {
  public:
    /// Evaluates the objects that deform at up to kPlanFrames frames. Keeps references to both.
    ScenePlanner(const Scene &scene, const PlanOptions &options);
    ~ScenePlanner();
    ScenePlanner(const ScenePlanner &) = delete;
    ScenePlanner &operator=(const ScenePlanner &) = delete;

    /// The cheapest model whose predicted error stays below the tolerance over the scene's frames, whatever its noise; none given: as in
    /// PlanOptions.
    [[nodiscard]] ScenePlan decide(const PlanScales &scales, std::optional<float> tolerance) const;
    /// What is built for a plan, and for a report all over the frames. Surfaces refer to the scene's objects until a renderer takes them
    /// over. Once; takes what the surfaces need from the scene's budget.
    PlannedScene finish(ScenePlan plan);
    /// Among the scene's frames, the one whose meshes are hardest to do with fewer faces; the middle one where that is all the same.
    [[nodiscard]] int hardestFrame() const;
    /// Whether any mesh's level is the plan's.
    [[nodiscard]] bool choosesLevels() const;

  private:
    struct State;
    std::unique_ptr<State> state_;
};

/// By analysis alone.
PlannedScene planScene(const Scene &scene, const PlanOptions &options = {});

/// The plan alone.
ScenePlan makePlan(const Scene &scene, std::optional<float> tolerance = std::nullopt);

} // namespace taut
