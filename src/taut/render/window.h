#pragma once
/// A part of a frame.

#include <algorithm>

namespace taut {

/// The pixels [x0, x1) x [y0, y1) of a frame; rows from the top.
struct Window {
    int x0 = 0, y0 = 0, x1 = 0, y1 = 0;
    [[nodiscard]] int width() const { return x1 - x0; }
    [[nodiscard]] int height() const { return y1 - y0; }
    [[nodiscard]] bool empty() const { return x1 <= x0 || y1 <= y0; }
    [[nodiscard]] bool contains(const Window &other) const { return other.x0 >= x0 && other.y0 >= y0 && other.x1 <= x1 && other.y1 <= y1; }
    bool operator==(const Window &) const = default;
};

inline Window unionOf(const Window &a, const Window &b) {
    return {std::min(a.x0, b.x0), std::min(a.y0, b.y0), std::max(a.x1, b.x1), std::max(a.y1, b.y1)};
}

} // namespace taut
