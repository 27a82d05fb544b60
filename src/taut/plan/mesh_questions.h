#pragma once
/// The questions about one mesh: how finely it is refined, what M follows, how that is interpolated and computed.

#include "taut/plan/costs.h"
#include "taut/plan/gradient_field.h"
#include "taut/plan/plan.h"
#include "taut/plan/refinement_error.h"

namespace taut {

bool hasMicrosurface(const Material &material);

/// Alphas of materials over everything that a mesh does.
struct AlphaRange {
    float least = kInfinity;
    Vec2 greatest{0};      ///< of the rougher and of the smoother one; 0 without a microsurface
    float sensitivity = 1; ///< of an image to V: 1 for a gloss alone; slopes that V turns, and roughening by it, change lobes beside that
    void add(const AlphaRange &other);
};
/// A material's alphas on a mesh that does this.
AlphaRange deformedAlpha(const Material &material, const GradientField &field);

/// Level at which refinement errors are measured; those of the others follow, at a factor of four a level.
inline constexpr int kProbeLevel = 2;
/// The finest level that a plan considers.
int mostLevel(const Scene &scene, const Object &object);
/// Errors of normals, V and outline between the vertices of each level, from those at kProbeLevel.
Question subdivisionQuestion(const Scene &scene, const Object &object, const RefinementError &probe, const PlanScales &scales,
                             const PlanCosts &costs);

/// All other questions, answered within what is left of the tolerance; predicted errors are multiplied by `scale`.
void planMesh(const Object &object, const GradientField &field, const AlphaRange &alpha, float left, float scale,
              const PlanCosts &costs, MeshPlan &plan);

} // namespace taut
