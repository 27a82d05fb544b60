#pragma once
/// Whole files as bytes, and what the mesh readers need to know about a path.

#include <string>
#include <string_view>

namespace taut {

/// The bytes of a regular file. Throws InputError where it is missing, is not a regular file or cannot be read.
std::string readFileBytes(const std::string &path);

/// The extension of `path` without its dot, in lower case.
std::string lowerExtension(std::string_view path);

/// Writes `bytes` beside `path` and renames, so that `path` is never half written. Throws RunError.
void writeFileWhole(const std::string &path, std::string_view bytes);

} // namespace taut
