#include "reached_error.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <cmath>

namespace taut::app {

double ReachedError::error() const {
    return std::hypot(noise.error, static_cast<double>(budget.bias));
}

std::optional<ReachedError> reachedError(const ScenePlan &plan, const std::optional<PictureNoiseReached> &noise) {
    if (!plan.budget || !noise) return std::nullopt;
    return ReachedError{*plan.budget, *noise, !plan.pilots.empty()};
}

std::string textOf(const ReachedError &r) {
    const std::string how = r.noise.controls > 0 ? fmt::format("{} blocks rendered twice", r.noise.controls) : "by halves of the samples";
    return fmt::format("error {:.3g}{}: noise {:.3g} +- {:.1g} ({}), bias {:.2g} ({})", r.error(),
                       r.error() > static_cast<double>(r.budget.error) ? fmt::format(" instead of {:.3g}", r.budget.error) : "", r.noise.error,
                       r.noise.spread, how, r.budget.bias, r.measuredBias ? "measured by pilots" : "a bound");
}

nlohmann::json toJson(const ReachedError &r) {
    return {{"asked", r.budget.error},        {"reached", r.error()},         {"noise", r.noise.error}, {"noise_spread", r.noise.spread},
            {"controls", r.noise.controls},   {"bias", r.budget.bias},        {"bias_measured", r.measuredBias},
            {"exponent", r.noise.exponent}};
}

} // namespace taut::app
