#pragma once
/// Names of files that hold one part each.

#include <string>
#include <vector>

namespace taut::app {

/// One name a part, for use within a file's name. Letters of every script are kept; ASCII but letters, digits, dots and dashes, and
/// what is not UTF-8, becomes an underscore. At most `longest` bytes each. Names differ from one another even where case does not
/// count (name_2, name_3 ... where they would not), so that no file is written over another.
std::vector<std::string> partNames(const std::vector<std::string> &names, std::size_t longest);

} // namespace taut::app
