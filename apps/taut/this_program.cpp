#include "this_program.h"

namespace taut::app {

std::filesystem::path thisProgram() {
    std::error_code error;
    const std::filesystem::path path = std::filesystem::read_symlink("/proc/self/exe", error);
    return error ? "taut" : path;
}

} // namespace taut::app
