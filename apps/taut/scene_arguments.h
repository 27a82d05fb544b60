#pragma once
/// Arguments that several subcommands share: the scene, overrides, frames and threads.

#include "taut/plan/plan.h"
#include "taut/scene/scene.h"

#include <CLI/CLI.hpp>
#include <tbb/global_control.h>

#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace taut::app {

struct SceneArguments {
    std::string scene;
    std::vector<std::string> overrides;
    std::string frames;
    int threads = 0;       ///< 0: all
    std::string maxMemory; ///< empty: the default limit
};

/// Adds SCENE, -D, --frames, -t and --max-memory to a subcommand.
void addSceneArguments(CLI::App &command, SceneArguments &arguments);

/// What the scene may ask for. Throws InputError.
std::shared_ptr<Budget> budgetOf(const SceneArguments &arguments);

/// Reads the scene, applies --frames, prints warnings unless `quiet`.
Scene loadScene(const SceneArguments &arguments, bool quiet);

/// --tolerance and --model: how much the plan may save.
struct ModelArguments {
    std::optional<float> tolerance; ///< none: the plan's own
    std::optional<float> error;     ///< of the picture, bias and noise together
    std::string model;              ///< "auto" or "full"
};
void addModelArguments(CLI::App &command, ModelArguments &arguments);
/// The plan that they ask for, with what `taut info` reports. Throws InputError for an unknown model.
PlannedScene planFor(const Scene &scene, const ModelArguments &arguments, bool report = false, bool shares = true);

/// Limits the number of threads while it lives.
std::shared_ptr<tbb::global_control> limitThreads(int threads);

} // namespace taut::app
