#pragma once
/// Numbers for the words of a chart.

#include "study/chart.h"

#include <algorithm>
#include <cstdio>

namespace taut::chart {

/// A number with so many digits.
inline std::string digits(double x, int count = 3) {
    char text[48];
    std::snprintf(text, sizeof text, "%.*g", count, x);
    return text;
}

/// A large count: 250k, 1.05M.
inline std::string count(double n) {
    return n >= 1e6 ? digits(n / 1e6) + "M" : n >= 1e3 ? digits(n / 1e3) + "k" : digits(n);
}

/// The first point of a series; the panel has one.
inline const Point &pointOf(const Panel &panel, const std::string &series) {
    return *std::find_if(panel.points.begin(), panel.points.end(), [&](const Point &p) { return p.series == series; });
}

} // namespace taut::chart
