#pragma once
/// What the package takes from the command, whose headers bring JSON along.

#include "taut/base/error.h"
#include "taut/render/render_scene.h"

#include <string>
#include <vector>

namespace taut::app {

/// The report of `taut info --json`.
std::string planText(const RenderScene &ready, const std::vector<GradientField> &fields);
/// `taut export --json`.
std::string exportText(const Scene &scene, const std::vector<std::string> &outputs, const std::vector<std::string> &objects,
                       const std::string &convention, const std::string &positions, const std::string &space, bool ascii,
                       Warnings &warnings);

} // namespace taut::app
