#include "taut/scene/table_reader.h"

#include <algorithm>

namespace taut {

namespace {

using Kind = TomlValue::Kind;

bool isNumber(const TomlValue &value) {
    return value.kind == Kind::Integer || value.kind == Kind::Number;
}

DVec3 toTripleOf(const TomlValue &value, const Range &range, bool oneIsEnough) {
    if (oneIsEnough && isNumber(value)) return DVec3(toNumber(value, range));
    const auto &items = toArray(value, 3, oneIsEnough ? "a number or three numbers" : "three numbers");
    return {toNumber(items[0], range), toNumber(items[1], range), toNumber(items[2], range)};
}

/// A constant, or keys [[frame, value], ...] at increasing frames.
template <class T, class Convert> Keyed<T> toKeyed(const TomlValue &value, const Convert &convert) {
    if (!isKeyed(value)) return Keyed<T>(convert(value));
    Keyed<T> keyed;
    for (const TomlValue &key : value.items) {
        const auto &pair = toArray(key, 2, "a key [frame, value]");
        const double frame = toNumber(pair[0], kAnyNumber);
        if (!keyed.keys.empty() && frame <= keyed.keys.back().first)
            failInput(pair[0].where, "frame " + formatNumber(frame), "a frame after " + formatNumber(keyed.keys.back().first));
        keyed.keys.emplace_back(frame, convert(pair[1]));
    }
    return keyed;
}

} // namespace

double toNumber(const TomlValue &value, const Range &range) {
    if (!isNumber(value)) failInput(value.where, describe(value), describe(range));
    if (!range.contains(value.number)) failInput(value.where, describe(value), describe(range));
    return value.number;
}

std::int64_t toInteger(const TomlValue &value, const IntegerRange &range) {
    if (value.kind != Kind::Integer || !range.contains(value.integer)) failInput(value.where, describe(value), describe(range));
    return value.integer;
}

bool toBoolean(const TomlValue &value) {
    if (value.kind != Kind::Boolean) failInput(value.where, describe(value), "true or false");
    return value.boolean;
}

const std::string &toText(const TomlValue &value) {
    if (value.kind != Kind::String) failInput(value.where, describe(value), "a string");
    return value.text;
}

const std::vector<TomlValue> &toArray(const TomlValue &value, std::size_t count, std::string_view expected) {
    if (value.kind != Kind::Array || value.items.size() != count) failInput(value.where, describe(value), expected);
    return value.items;
}

DVec3 toVec3(const TomlValue &value, const Range &range) {
    return toTripleOf(value, range, false);
}

DVec3 toTriple(const TomlValue &value, const Range &range) {
    return toTripleOf(value, range, true);
}

DVec3 toDirection(const TomlValue &value) {
    const DVec3 direction = toVec3(value, kAnyNumber);
    const double length = glm::length(direction);
    if (!(length > 1e-12)) failInput(value.where, "a vector of no length", "a direction");
    return direction / length;
}

bool isKeyed(const TomlValue &value) {
    return value.kind == Kind::Array && !value.items.empty() && value.items.front().kind == Kind::Array;
}

Keyed<double> toKeyedNumber(const TomlValue &value, const Range &range, double unit) {
    return toKeyed<double>(value, [&](const TomlValue &v) { return toNumber(v, range) * unit; });
}

Keyed<DVec3> toKeyedVec3(const TomlValue &value, const Range &range, double unit) {
    return toKeyed<DVec3>(value, [&](const TomlValue &v) { return toVec3(v, range) * unit; });
}

Keyed<DVec3> toKeyedTriple(const TomlValue &value, const Range &range) {
    return toKeyed<DVec3>(value, [&](const TomlValue &v) { return toTriple(v, range); });
}

int toAxis(const TomlValue &value) {
    return toChoice<int>(value, {{"x", 0}, {"y", 1}, {"z", 2}});
}

TableReader::TableReader(const TomlValue &value, std::string_view what, const std::vector<std::string_view> &keys) : value_(value) {
    if (value.kind != Kind::Table) failInput(value.where, describe(value), "a table " + std::string(what));
    for (const TomlEntry &entry : value.entries)
        if (std::find(keys.begin(), keys.end(), entry.key) == keys.end()) failUnknownName(entry.where, entry.key, keys);
}

const TomlValue *TableReader::find(std::string_view key) {
    if (std::find(asked_.begin(), asked_.end(), key) == asked_.end()) asked_.push_back(key);
    return value_.find(key);
}

const TomlValue &TableReader::required(std::string_view key, std::string_view expected) {
    const TomlValue *value = find(key);
    if (value == nullptr) failInput(value_.where, "no key '" + std::string(key) + "'", expected);
    return *value;
}

void TableReader::exclusive(std::string_view a, std::string_view b) const {
    if (value_.find(a) == nullptr) return;
    for (const TomlEntry &entry : value_.entries)
        if (entry.key == b) failInput(entry.where, quoted(b) + " beside " + quoted(a), "one of the two");
}

void TableReader::finish() const {
    for (const TomlEntry &entry : value_.entries)
        if (std::find(asked_.begin(), asked_.end(), entry.key) == asked_.end()) failUnknownName(entry.where, entry.key, asked_);
}

} // namespace taut
