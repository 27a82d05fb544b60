#pragma once
/// A TOML document as a plain tree in which every key and value knows where it was written. toml++ parses; nothing else
/// of the project sees its types.

#include "taut/base/error.h"

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace taut {

struct TomlEntry;

struct TomlValue {
    enum class Kind { Boolean, Integer, Number, String, Array, Table, Other };
    Kind kind = Kind::Table;
    Location where;
    bool boolean = false;
    std::int64_t integer = 0;
    double number = 0; ///< set for integers too
    std::string text;
    std::vector<TomlValue> items;   ///< of an array
    std::vector<TomlEntry> entries; ///< of a table, in the order of the file
    bool isInline = false;          ///< a table written as { ... }

    /// The value of a key of this table; null where there is none.
    [[nodiscard]] const TomlValue *find(std::string_view key) const;
    TomlValue *find(std::string_view key);
};

struct TomlEntry {
    std::string key;
    Location where;
    TomlValue value;
};

/// Reads a TOML file. Throws InputError where it can't be read or is not TOML, with toml++'s reason.
TomlValue readToml(const std::string &path);

/// Parses TOML text; `file` is the name used in locations.
TomlValue parseToml(std::string_view text, const std::string &file);

/// Applies one command line override "key.path=value" to a document. Array elements are named by their index, from 0; the
/// index one past the end appends. The value is read as TOML, else taken as a string. Tables in between are made where they
/// are missing. Values carry the location "-D key.path=value".
void applyOverride(TomlValue &root, const std::string &text);

/// What a value is, for the "found" part of an error: 12, 'text', a table, an array of 3 items.
std::string describe(const TomlValue &value);

} // namespace taut
