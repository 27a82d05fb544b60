#pragma once
/// A tree of TOML written as text that reads back as the same tree.

#include "taut/scene/toml_value.h"

#include <string>

namespace taut {

/// A table with its subtables as [sections], arrays of tables as [[sections]]; comments are not kept. Throws InputError for a value that
/// has no text (a date).
std::string tomlText(const TomlValue &root);

/// One value as it stands after "key = ", on one line.
std::string tomlInline(const TomlValue &value);

} // namespace taut
