#pragma once
/// Numbers for the words of a chart.

#include "study/chart.h"

#include <algorithm>
#include <cstdarg>
#include <cstdio>

namespace taut::chart {

/// printf into a string of at most a thousand bytes.
[[gnu::format(printf, 1, 2)]] inline std::string printed(const char *format, ...) {
    std::va_list values;
    va_start(values, format);
    char text[1024];
    std::vsnprintf(text, sizeof text, format, values);
    va_end(values);
    return text;
}

/// A number with so many digits.
inline std::string digits(double x, int count = 3) {
    return printed("%.*g", count, x);
}

/// A large count: 250k, 1.05M.
inline std::string count(double n) {
    return n >= 1e6 ? digits(n / 1e6) + "M" : n >= 1e3 ? digits(n / 1e3) + "k" : digits(n);
}

/// With its unit, if it has one.
inline std::string nameOf(const Axis &axis) {
    return axis.unit.empty() ? axis.name : axis.name + " [" + axis.unit + "]";
}

/// The first point of a series; the panel has one.
inline const Point &pointOf(const Panel &panel, const std::string &series) {
    return *std::find_if(panel.points.begin(), panel.points.end(), [&](const Point &p) { return p.series == series; });
}

/// As Markdown.
inline std::string markdownOf(const Table &table) {
    std::string text;
    const auto add = [&](const std::vector<std::string> &cells) {
        for (const std::string &cell : cells) text += "| " + cell + " ";
        text += "|\n";
    };
    add(table.head);
    add(std::vector<std::string>(table.head.size(), "---"));
    for (const auto &row : table.rows) add(row);
    return text;
}

} // namespace taut::chart
