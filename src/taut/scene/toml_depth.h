#pragma once
/// How deep the tables and arrays of a TOML text lie within one another, found without recursion before a parser that recurses sees it.

#include <cstddef>
#include <optional>
#include <string_view>

namespace taut {

/// Where a text nests deeper than was allowed.
struct DeepPlace {
    int line = 1;
    int column = 1;
};

/// The first place of `text` that lies in more than `most` tables and arrays: parts of the header [a.b], of dotted keys, and brackets all
/// count. Dots and brackets in strings and comments do not. Of a text that is not TOML: up to where it ceases to be.
std::optional<DeepPlace> placeDeeperThan(std::string_view text, std::size_t most);

} // namespace taut
