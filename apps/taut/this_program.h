#pragma once
/// Where the program that runs is.

#include <filesystem>

namespace taut::app {

/// Its file; "taut" where the system does not tell.
std::filesystem::path thisProgram();

} // namespace taut::app
