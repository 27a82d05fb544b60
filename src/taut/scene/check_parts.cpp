#include "taut/scene/check_parts.h"

#include <limits>

namespace taut {

namespace {

template <class T, class CheckValue>
void checkKeysBy(const Part &part, std::string_view member, const Keyed<T> &keyed, const CheckValue &checkValue) {
    if (keyed.keys.empty()) part.fail(member, "no key", "at least one");
    for (std::size_t i = 0; i < keyed.keys.size(); ++i) {
        const double frame = keyed.keys[i].first;
        if (!isWithin(kAnyNumber, frame)) part.fail(member, "a key at frame " + formatNumber(frame), describe(kAnyNumber));
        if (i > 0 && !(frame > keyed.keys[i - 1].first))
            part.fail(member, "frame " + formatNumber(frame), "a frame after " + formatNumber(keyed.keys[i - 1].first));
        checkValue(keyed.keys[i].second);
    }
}

} // namespace

void Part::fail(std::string_view member, std::string_view found, std::string_view expected) const {
    std::string where = scene.empty() ? std::string() : std::string(scene) + ": ";
    where += list;
    if (index != kNone) where += "[" + std::to_string(index) + "]";
    if (!name.empty()) where += " " + quoted(name);
    if (!member.empty()) where += "." + std::string(member);
    failInput({where, 0, 0, -1}, found, expected);
}

bool isWithin(const Range &range, double value) {
    constexpr double kRounding = 1e-5;
    if (!(std::fabs(value) <= std::numeric_limits<float>::max())) return false;
    if (range.upper < kAnyNumber.upper && value > range.upper + kRounding * std::fabs(range.upper)) return false;
    if (range.lower <= kAnyNumber.lower) return true;
    return range.openLower ? value > range.lower : value >= range.lower - kRounding * std::fabs(range.lower);
}

void checkNumber(const Part &part, std::string_view member, double value, const Range &range, double unit) {
    if (!isWithin(range, value / unit)) part.fail(member, formatNumber(value / unit), describe(range) + (unit != 1 ? " degrees" : ""));
}

void checkInteger(const Part &part, std::string_view member, std::int64_t value, const IntegerRange &range) {
    if (!range.contains(value)) part.fail(member, std::to_string(value), describe(range));
}

void checkVector(const Part &part, std::string_view member, const DVec3 &value, const Range &range, double unit) {
    for (int i = 0; i < 3; ++i) checkNumber(part, member, value[i], range, unit);
}

void checkCount(const Part &part, std::string_view member, std::size_t count, std::size_t expected) {
    if (count != expected) part.fail(member, std::to_string(count) + " elements", std::to_string(expected));
}

void checkIndex(const Part &part, std::string_view member, Index index, std::size_t count, std::string_view of) {
    if (index < count) return;
    part.fail(member, index == kNone ? "none" : std::to_string(index), "one of the " + std::to_string(count) + " " + std::string(of));
}

void checkKeys(const Part &part, std::string_view member, const Keyed<double> &keyed, const Range &range, double unit) {
    checkKeysBy(part, member, keyed, [&](double value) { checkNumber(part, member, value, range, unit); });
}

void checkKeys(const Part &part, std::string_view member, const Keyed<DVec3> &keyed, const Range &range, double unit) {
    checkKeysBy(part, member, keyed, [&](const DVec3 &value) { checkVector(part, member, value, range, unit); });
}

} // namespace taut
