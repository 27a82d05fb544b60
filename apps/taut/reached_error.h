#pragma once
/// What a frame that was rendered to an error has reached, and how that is known.

#include "taut/plan/plan.h"
#include "taut/render/frame_render.h"

#include <nlohmann/json_fwd.hpp>

#include <optional>
#include <string>

namespace taut::app {

struct ReachedError {
    ErrorBudget budget;
    PictureNoiseReached noise;
    bool measuredBias = false; ///< by pilots; else the analysis bounds it

    /// Relative RMS, bias and noise together.
    [[nodiscard]] double error() const;
};

/// None where no error was asked for.
std::optional<ReachedError> reachedError(const ScenePlan &plan, const std::optional<PictureNoiseReached> &noise);

/// "error 0.019: noise 0.018 +- 0.001 (12 blocks rendered twice), bias 0.004 (pilots)".
std::string textOf(const ReachedError &reached);
nlohmann::json toJson(const ReachedError &reached);

} // namespace taut::app
