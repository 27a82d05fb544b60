#pragma once
/// Typed, checked access to the tables of a scene file. Every mismatch is an InputError at the value's place; a key that no
/// one asked for is an error at the key's place, with the nearest valid one.

#include "taut/deform/keyed.h"
#include "taut/scene/ranges.h"
#include "taut/scene/toml_value.h"

#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace taut {

double toNumber(const TomlValue &value, const Range &range);
std::int64_t toInteger(const TomlValue &value, const IntegerRange &range);
bool toBoolean(const TomlValue &value);
const std::string &toText(const TomlValue &value);
const std::vector<TomlValue> &toArray(const TomlValue &value, std::size_t count, std::string_view expected);
DVec3 toVec3(const TomlValue &value, const Range &range);
/// A vector of length > 0, made unit.
DVec3 toDirection(const TomlValue &value);
/// Three numbers, or one number for all three.
DVec3 toTriple(const TomlValue &value, const Range &range);
/// True for [[frame, value], ...].
bool isKeyed(const TomlValue &value);
/// A number times `unit`, constant or keyed.
Keyed<double> toKeyedNumber(const TomlValue &value, const Range &range, double unit = 1);
Keyed<DVec3> toKeyedVec3(const TomlValue &value, const Range &range, double unit = 1);
/// Like toKeyedVec3, and each value may be one number for all three.
Keyed<DVec3> toKeyedTriple(const TomlValue &value, const Range &range);
/// x, y or z as 0, 1 or 2.
int toAxis(const TomlValue &value);

template <class E> using Names = std::vector<std::pair<std::string_view, E>>;

/// One of a few names. Throws with the nearest of them.
template <class E> E toChoice(const TomlValue &value, const Names<E> &choices) {
    std::vector<std::string_view> names;
    for (const auto &[name, choice] : choices) {
        if (value.kind == TomlValue::Kind::String && value.text == name) return choice;
        names.push_back(name);
    }
    failUnknownName(value.where, toText(value), names);
}

class TableReader {
  public:
    /// `what` names the table in errors: "[render]", "a [[light]]". `keys` are all the keys that any such table may have.
    /// Throws where `value` is no table or has another key.
    TableReader(const TomlValue &value, std::string_view what, const std::vector<std::string_view> &keys);

    /// The value of a key, null where it is not given. The key counts as understood.
    const TomlValue *find(std::string_view key);
    const TomlValue &required(std::string_view key, std::string_view expected);

    /// target = convert(value) where the key is given; else the target keeps its default.
    template <class T, class Convert> void read(std::string_view key, T &target, const Convert &convert) {
        if (const TomlValue *value = find(key)) target = static_cast<T>(convert(*value));
    }
    void read(std::string_view key, bool &target) { read(key, target, toBoolean); }
    void read(std::string_view key, std::string &target) { read(key, target, toText); }

    /// Throws for two keys that exclude each other.
    void exclusive(std::string_view a, std::string_view b) const;

    /// Throws for a key that nobody asked for: it belongs to another kind of this table, say a quad's `corner` in a sphere.
    void finish() const;

    [[nodiscard]] const Location &where() const { return value_.where; }

  private:
    const TomlValue &value_;
    std::vector<std::string_view> asked_;
};

// Converters for TableReader::read.
inline auto numberIn(Range range, double unit = 1) {
    return [=](const TomlValue &value) { return toNumber(value, range) * unit; };
}
inline auto integerIn(IntegerRange range) {
    return [=](const TomlValue &value) { return toInteger(value, range); };
}
inline auto vec3In(Range range = kAnyNumber) {
    return [=](const TomlValue &value) { return toVec3(value, range); };
}
inline auto tripleIn(Range range) {
    return [=](const TomlValue &value) { return toTriple(value, range); };
}
inline auto keyedNumberIn(Range range, double unit = 1) {
    return [=](const TomlValue &value) { return toKeyedNumber(value, range, unit); };
}
inline auto keyedVec3In(Range range = kAnyNumber, double unit = 1) {
    return [=](const TomlValue &value) { return toKeyedVec3(value, range, unit); };
}
inline auto keyedTripleIn(Range range) {
    return [=](const TomlValue &value) { return toKeyedTriple(value, range); };
}
template <class E> auto oneOf(Names<E> names) {
    return [names = std::move(names)](const TomlValue &value) { return toChoice<E>(value, names); };
}

} // namespace taut
