#include "taut/scene/toml_value.h"

#include "taut/base/file_bytes.h"
#include "taut/scene/toml_depth.h"

#include <toml++/toml.h>

#include <algorithm>
#include <charconv>
#include <cstdio>

namespace taut {

namespace {

/// Tables and arrays within one another; what walks the tree does so recursively.
constexpr int kDeepestValue = 64;

Location locationOf(const toml::source_position &begin, const std::string &file) {
    return {file, static_cast<int>(begin.line), static_cast<int>(begin.column), -1};
}

bool isEarlier(const Location &a, const Location &b) {
    return a.line != b.line ? a.line < b.line : a.column < b.column;
}

TomlValue convert(const toml::node &node, const std::string &file, int depth) {
    TomlValue out;
    out.where = locationOf(node.source().begin, file);
    if (depth > kDeepestValue)
        failInput(out.where, "values nested " + std::to_string(depth) + " deep", "at most " + std::to_string(kDeepestValue));
    switch (node.type()) {
    case toml::node_type::boolean:
        out.kind = TomlValue::Kind::Boolean;
        out.boolean = node.as_boolean()->get();
        break;
    case toml::node_type::integer:
        out.kind = TomlValue::Kind::Integer;
        out.integer = node.as_integer()->get();
        out.number = static_cast<double>(out.integer);
        break;
    case toml::node_type::floating_point:
        out.kind = TomlValue::Kind::Number;
        out.number = node.as_floating_point()->get();
        break;
    case toml::node_type::string:
        out.kind = TomlValue::Kind::String;
        out.text = node.as_string()->get();
        break;
    case toml::node_type::array:
        out.kind = TomlValue::Kind::Array;
        for (const toml::node &item : *node.as_array()) out.items.push_back(convert(item, file, depth + 1));
        break;
    case toml::node_type::table: {
        const toml::table &table = *node.as_table();
        out.kind = TomlValue::Kind::Table;
        out.isInline = table.is_inline();
        for (const auto &[key, value] : table)
            out.entries.push_back({std::string(key.str()), locationOf(key.source().begin, file), convert(value, file, depth + 1)});
        std::stable_sort(out.entries.begin(), out.entries.end(),
                         [](const TomlEntry &a, const TomlEntry &b) { return isEarlier(a.where, b.where); });
        break;
    }
    default: out.kind = TomlValue::Kind::Other; break;
    }
    return out;
}

/// toml++ counts arrays within one another but frees the tables of dotted keys recursively, however many they are.
void checkDepth(std::string_view text, const std::string &file) {
    if (const auto place = placeDeeperThan(text, kDeepestValue))
        failInput({file, place->line, place->column, -1}, "keys and values nested more than " + std::to_string(kDeepestValue) + " deep",
                  "at most " + std::to_string(kDeepestValue));
}

/// TOML knows no CR alone, anywhere: where it stands it ends a line as an old program wrote it.
std::string withLineFeeds(std::string_view text) {
    std::string out(text);
    for (std::size_t i = 0; i < out.size(); ++i)
        if (out[i] == '\r' && out.compare(i, 2, "\r\n") != 0) out[i] = '\n';
    return out;
}

/// Gives a whole tree one location: what an override says has no line in the file.
void relocate(TomlValue &value, const Location &where) {
    value.where = where;
    for (TomlValue &item : value.items) relocate(item, where);
    for (TomlEntry &entry : value.entries) {
        entry.where = where;
        relocate(entry.value, where);
    }
}

void mergeInto(TomlValue &target, TomlValue &&change);

/// An integer-named entry of a change goes into an array element.
void mergeIntoArray(TomlValue &target, TomlEntry &&entry) {
    std::size_t index = 0;
    const char *end = entry.key.data() + entry.key.size();
    const auto [stop, error] = std::from_chars(entry.key.data(), end, index);
    if (error != std::errc() || stop != end || index > target.items.size())
        failInput(entry.where, quoted(entry.key), "an index from 0 to " + std::to_string(target.items.size()));
    if (index == target.items.size())
        target.items.push_back(std::move(entry.value));
    else
        mergeInto(target.items[index], std::move(entry.value));
}

void mergeInto(TomlValue &target, TomlValue &&change) {
    const bool goesInside = change.kind == TomlValue::Kind::Table && !change.isInline;
    if (goesInside && target.kind == TomlValue::Kind::Array) {
        for (TomlEntry &entry : change.entries) mergeIntoArray(target, std::move(entry));
    } else if (goesInside && target.kind == TomlValue::Kind::Table) {
        for (TomlEntry &entry : change.entries) {
            if (TomlValue *existing = target.find(entry.key))
                mergeInto(*existing, std::move(entry.value));
            else
                target.entries.push_back(std::move(entry));
        }
    } else {
        target = std::move(change);
    }
}

/// Elements of arrays that do not exist yet are written mesh.0.file=...: such tables of indices become arrays.
void makeArrays(TomlValue &value) {
    for (TomlEntry &entry : value.entries) {
        TomlValue &child = entry.value;
        makeArrays(child);
        const bool isNewArray =
            (entry.key == "mesh" || entry.key == "light" || entry.key == "deform") && child.kind == TomlValue::Kind::Table;
        if (!isNewArray || child.entries.size() != 1 || child.entries[0].key != "0") continue;
        TomlValue element = std::move(child.entries[0].value);
        child.kind = TomlValue::Kind::Array;
        child.entries.clear();
        child.items.push_back(std::move(element));
    }
    for (TomlValue &item : value.items) makeArrays(item);
}

} // namespace

const TomlValue *TomlValue::find(std::string_view key) const {
    for (const TomlEntry &entry : entries)
        if (entry.key == key) return &entry.value;
    return nullptr;
}

TomlValue *TomlValue::find(std::string_view key) {
    return const_cast<TomlValue *>(std::as_const(*this).find(key));
}

TomlValue parseToml(std::string_view text, const std::string &file) {
    const std::string lines = withLineFeeds(text.substr(sizeOfByteOrderMark(text)));
    checkDepth(lines, file);
    try {
        return convert(toml::parse(lines, std::string_view(file)), file, 0);
    } catch (const toml::parse_error &error) {
        throw InputError(locationOf(error.source().begin, file).text() + ": found text that is not TOML (" +
                         std::string(error.description()) + "), expected a scene file");
    }
}

TomlValue readToml(const std::string &path) {
    return parseToml(readFileBytes(path), path);
}

void applyOverride(TomlValue &root, const std::string &text) {
    const Location where{"-D " + text, 0, 0, -1};
    const std::size_t equals = text.find('=');
    if (equals == std::string::npos || equals == 0) failInput(where, "no '='", "-D key.path=value");
    TomlValue change;
    try {
        change = parseToml(text, where.file);
    } catch (const InputError &) {
        // Not a TOML value: then it is text, such as material.brushed.metal=Al.
        try {
            change = parseToml(text.substr(0, equals) + "=''", where.file);
        } catch (const InputError &) {
            change.entries.clear();
        }
        TomlValue *leaf = &change;
        while (leaf->kind == TomlValue::Kind::Table && !leaf->entries.empty()) leaf = &leaf->entries.front().value;
        leaf->text = text.substr(equals + 1);
    }
    if (change.entries.empty()) failInput(where, quoted(text.substr(0, equals)), "a dotted key such as render.width");
    relocate(change, where);
    mergeInto(root, std::move(change));
    makeArrays(root);
}

std::string describe(const TomlValue &value) {
    switch (value.kind) {
    case TomlValue::Kind::Boolean: return value.boolean ? "true" : "false";
    case TomlValue::Kind::Integer: return std::to_string(value.integer);
    case TomlValue::Kind::Number: return formatNumber(value.number);
    case TomlValue::Kind::String: return quoted(value.text);
    case TomlValue::Kind::Array:
        return "an array of " + std::to_string(value.items.size()) + (value.items.size() == 1 ? " item" : " items");
    case TomlValue::Kind::Table: return "a table";
    case TomlValue::Kind::Other: break;
    }
    return "a date or time";
}

} // namespace taut
