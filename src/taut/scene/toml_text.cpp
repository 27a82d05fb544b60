#include "taut/scene/toml_text.h"

#include <algorithm>
#include <charconv>
#include <cmath>

namespace taut {

namespace {

std::string textOf(const std::string &text) {
    std::string out = "\"";
    for (const char c : text) {
        const auto code = static_cast<unsigned char>(c);
        if (c == '"' || c == '\\') {
            out += '\\';
            out += c;
        } else if (code < 0x20 || code == 0x7f) {
            static constexpr char kDigits[] = "0123456789abcdef";
            out += "\\u00";
            out += kDigits[code >> 4U];
            out += kDigits[code & 15U];
        } else {
            out += c;
        }
    }
    return out + '"';
}

std::string keyOf(const std::string &key) {
    const bool bare = !key.empty() && std::all_of(key.begin(), key.end(), [](char c) {
        return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' || c == '-';
    });
    return bare ? key : textOf(key);
}

/// The fewest digits that name this double, with a point or an exponent, so that it stays no integer.
std::string numberOf(double x) {
    if (std::isnan(x)) return "nan";
    if (std::isinf(x)) return x > 0 ? "inf" : "-inf";
    char digits[32];
    const auto [end, error] = std::to_chars(digits, digits + sizeof digits, x);
    std::string out(digits, end);
    return out.find_first_of(".e") == std::string::npos ? out + ".0" : out;
}

bool isSection(const TomlValue &value) {
    return value.kind == TomlValue::Kind::Table && !value.isInline;
}
bool isSections(const TomlValue &value) {
    return value.kind == TomlValue::Kind::Array && !value.items.empty() && std::all_of(value.items.begin(), value.items.end(), isSection);
}

void writeTable(const TomlValue &table, const std::string &path, std::string &out) {
    for (const TomlEntry &entry : table.entries)
        if (!isSection(entry.value) && !isSections(entry.value)) out += keyOf(entry.key) + " = " + tomlInline(entry.value) + "\n";
    for (const TomlEntry &entry : table.entries) {
        const std::string name = (path.empty() ? "" : path + ".") + keyOf(entry.key);
        if (isSection(entry.value)) {
            out += "\n[" + name + "]\n";
            writeTable(entry.value, name, out);
        } else if (isSections(entry.value)) {
            for (const TomlValue &item : entry.value.items) {
                out += "\n[[" + name + "]]\n";
                writeTable(item, name, out);
            }
        }
    }
}

} // namespace

std::string tomlInline(const TomlValue &value) {
    std::string out;
    switch (value.kind) {
    case TomlValue::Kind::Boolean: return value.boolean ? "true" : "false";
    case TomlValue::Kind::Integer: return std::to_string(value.integer);
    case TomlValue::Kind::Number: return numberOf(value.number);
    case TomlValue::Kind::String: return textOf(value.text);
    case TomlValue::Kind::Array:
        for (const TomlValue &item : value.items) out += (out.empty() ? "" : ", ") + tomlInline(item);
        return "[" + out + "]";
    case TomlValue::Kind::Table:
        for (const TomlEntry &entry : value.entries) out += (out.empty() ? " " : ", ") + keyOf(entry.key) + " = " + tomlInline(entry.value);
        return "{" + out + (out.empty() ? "}" : " }");
    case TomlValue::Kind::Other: break;
    }
    failInput(value.where, "a date or time", "a value of a scene file");
}

std::string tomlText(const TomlValue &root) {
    std::string out;
    writeTable(root, "", out);
    return out.starts_with('\n') ? out.substr(1) : out;
}

} // namespace taut
