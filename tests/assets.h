#pragma once
/// Real meshes and animations that lie beside a checkout, where there are any. A test that wants one and finds none says so
/// in one line and passes.

#include "output_folder.h"

#include <filesystem>
#include <iostream>
#include <optional>
#include <string>

namespace taut::test {

inline std::optional<std::string> asset(const std::string &name) {
    const std::filesystem::path path = std::filesystem::path(TAUT_ASSETS) / name;
    if (std::filesystem::exists(path)) return path.string();
    std::cout << "SKIPPED: asset " << name << " is not on this machine" << std::endl;
    return std::nullopt;
}

/// An input after a public bug report, by its name in the folder of cases; skipped like an asset.
inline std::optional<std::string> caseFile(const std::string &name) {
    const std::filesystem::path path = std::filesystem::path(TAUT_CASES) / name;
    if (std::filesystem::exists(path)) return path.string();
    std::cout << "SKIPPED: case " << name << " is not on this machine" << std::endl;
    return std::nullopt;
}

} // namespace taut::test
