#pragma once
/// Which model of the deformed microsurface each mesh gets: no more than the scene needs (docs/pipeline.md, "Plan").
///
/// Every saving has a predicted error: the root mean square of the change that it makes to the image, relative to that of the
/// image. Predictions are bounds made from the gradient field and the materials' roughness over the frames (plan.cpp says how);
/// the errors of what is chosen together stay below the tolerance. Where nobody gives one, light that meets several facets is also
/// weighed against the noise that it brings at the scene's samples a pixel (light_coverage.h).

#include "taut/bsdf/bsdf_types.h"
#include "taut/deform/gradient_interpolation.h"
#include "taut/scene/object_surface.h"

#include <optional>
#include <string>
#include <vector>

namespace taut {

/// What M follows, cheapest first.
enum class StretchModel {
    Constant,  ///< the rest material: rigid motion, or roughness held fixed
    Uniform,   ///< one V for the whole mesh, anew each frame
    PerVertex, ///< V at every vertex: three numbers in the tangent plane
    Leaning,   ///< V and the lean at every vertex: five numbers
};

/// One way to do something, with what it is predicted to lose and to cost.
struct Choice {
    std::string name;
    float error = 0; ///< relative RMS of the image
    float cost = 0;  ///< in the question's unit
    float noise = 0; ///< that it adds at the scene's samples a pixel, relative RMS, where the plan weighs that
};

/// One question of the plan: its choices from the cheapest to the dearest, and the one taken.
struct Question {
    std::string name; ///< "stretch", "interpolation", "gradient", "subdivision" or "multiscatter"
    std::string unit; ///< of the costs: "ns a hit", "ns a vertex" (and frame), "us a frame"
    std::vector<Choice> choices;
    std::size_t taken = 0;
};

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

struct ScenePlan {
    std::vector<MeshPlan> meshes;            ///< [scene.objects]
    std::vector<MultiscatterPlan> materials; ///< [scene.materials]
    float bearableWaste = kBearableWaste;    ///< of the sampler of reflections
    bool mayRefit = true;                    ///< false: every BVH is built anew at every frame
    float tolerance = 0;
    float predictedError = 0; ///< of all that is saved, at most the tolerance; but for
    float errorInNoise = 0;   ///< light of several facets that is left out because it would bring more noise than that
};

/// The model where nobody asked for a plan: per vertex, by each object's own or default estimator, interpolated as Stretch.
ScenePlan defaultPlan(const Scene &scene);

/// `--model full`: the reference that every plan is held against. Everything per vertex and per hit, the random walk for "auto".
ScenePlan fullPlan(const Scene &scene);

inline constexpr int kPlanFrames = 9;

/// The tolerance where nobody gives one.
inline constexpr float kDefaultTolerance = 0.01F;

/// The cheapest model whose predicted error stays below `tolerance` over the scene's frames, whatever its noise. Without a tolerance:
/// the default one, and of multiple scattering no more than shows at the scene's samples a pixel. Evaluates the objects' gradients at
/// up to kPlanFrames frames.
ScenePlan makePlan(const Scene &scene, std::optional<float> tolerance = std::nullopt);

} // namespace taut
