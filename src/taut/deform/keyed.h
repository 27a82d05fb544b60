#pragma once
/// Values keyed over frames in a scene file: a constant, or [[frame, value], ...] with linear interpolation between keys
/// and the end values held outside.

#include "taut/base/vec.h"

#include <algorithm>
#include <utility>
#include <vector>

namespace taut {

template <class T> struct Keyed {
    std::vector<std::pair<double, T>> keys; ///< at least one; frames strictly increasing

    Keyed() = default;
    Keyed(const T &constant) : keys{{0.0, constant}} {} // NOLINT: a constant is a keyed value

    [[nodiscard]] bool isConstant() const {
        return std::all_of(keys.begin(), keys.end(), [&](const auto &key) { return key.second == keys.front().second; });
    }
    [[nodiscard]] const T &first() const { return keys.front().second; }

    /// Value at a (fractional) frame.
    [[nodiscard]] T at(double frame) const {
        if (frame <= keys.front().first) return keys.front().second;
        if (frame >= keys.back().first) return keys.back().second;
        const auto next = std::upper_bound(keys.begin(), keys.end(), frame, [](double f, const auto &key) { return f < key.first; });
        const auto previous = next - 1;
        const double u = (frame - previous->first) / (next->first - previous->first);
        return previous->second * (1 - u) + next->second * u;
    }
};

} // namespace taut
