#pragma once
/// Rendered images for charts, their times, and how far one is from another.

#include "study/chart.h"

#include "taut/plan/plan.h"
#include "taut/render/frame_render.h"
#include "taut/scene/scene.h"

#include <span>
#include <vector>

namespace taut::chart {

/// One frame of a scene under a plan.
struct RenderedImage {
    std::vector<float> values; ///< R G B, rows from the top
    double seconds = 0;        ///< all of it: topology, deformation, BVH, rendering
    double render = 0;         ///< the rendering alone
};
RenderedImage renderImage(const Scene &scene, ScenePlan plan, double frame, int spp, std::uint32_t seed);

/// A scene that is brought to its frame once and rendered from there: the rendering alone.
RenderedImage renderReady(const RenderScene &ready, int spp, std::uint32_t seed);

/// Whether two plans of a scene render it alike, whatever they do to BVHs.
bool sameModels(const ScenePlan &a, const ScenePlan &b);

/// Root mean square of the difference over that of the reference.
double relativeRms(std::span<const float> image, std::span<const float> reference);

/// Mean over pixels and colours of the square of the difference, over the square of the reference plus a hundredth of its mean
/// squared, where either lights the pixel: relMSE.
double relativeMse(std::span<const float> image, std::span<const float> reference);

/// An object of a mesh with the first material of the scene.
Object objectOf(Mesh mesh);

/// Metal without colour, by its alphas along and across the tangent.
Material brushedMetal(float alphaX, float alphaY);

/// A deformer that is constant over time, along `axis` with `axis2` its second axis; a wave is 0.65 metres long.
DeformerKeys constantDeformer(DeformerType type, double amount, int axis, int axis2);

/// A square picture of one object under a quad light and a dim sky, seen from above at an angle.
Scene studyScene(Object object, const Material &material, int size);

} // namespace taut::chart
