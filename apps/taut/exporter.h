#pragma once
/// Scene -> deformed surfaces -> M at every vertex -> files that other tools read, frame by frame. What `taut export` and the Python
/// package run.

#include "taut/base/error.h"
#include "taut/scene/scene.h"

#include <nlohmann/json.hpp>

#include <functional>
#include <string>
#include <vector>

namespace taut::app {

/// As on the command line, whose options errors name.
struct ExportRequest {
    std::vector<std::string> outputs; ///< files or patterns of files, of all the scene's frames
    std::vector<std::string> objects; ///< names; empty: all
    std::string convention = "matrix";
    std::string positions = "deformed";
    std::string space = "world";
    bool ascii = false;
    std::function<void(int frame)> startFrame{};
    std::function<void(int frame, const std::string &path, double seconds)> finishFrame{};
};

/// Writes the files; what was written, and in `warnings` what was clipped. Throws InputError before anything is written where the request
/// contradicts itself or the scene.
nlohmann::json exportFiles(const Scene &scene, const ExportRequest &request, Warnings &warnings);

} // namespace taut::app
