#pragma once
/// What there is to tell of a scene and its plan: what `taut info` and the plan() of the Python package say.

#include "taut/render/render_scene.h"

#include <nlohmann/json.hpp>

#include <array>
#include <string_view>
#include <vector>

namespace taut::app {

/// Scene, plan and measurements.
struct Report {
    const Scene &scene;
    const RenderScene &ready;
    const std::vector<GradientField> &fields; ///< [objects] over all frames
};

nlohmann::json toJson(const Report &report);
/// A question with its choices and the one taken; and all that a plan says of one mesh.
nlohmann::json toJson(const Question &q);
nlohmann::json toJson(const MeshPlan &plan);

/// What a policy for what has no right answer did, by its name (surface.h).
std::array<std::pair<std::string_view, Index>, 5> policiesOf(const Surface &surface);

/// What is done about BVHs, in words.
/// What `taut render` adds to a bare file, in a line; empty: nothing.
std::string stageOf(const Scene &scene);
std::string_view bvhOf(const RenderScene &ready);

} // namespace taut::app
