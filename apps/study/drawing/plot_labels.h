#pragma once
/// Names beside the points of a plot, none over another or over a point; those that find no place are left to the table.

#include "study/chart.h"
#include "study/drawing/plot_scale.h"

namespace taut::chart {

/// A picture in pixels, and the plot's edges as shares of it.
struct PlotArea {
    double width, height;
    double left, right, bottom, top;
};

/// Centred at shares of the picture.
struct PlotLabel {
    std::string text;
    double x, y;
};

/// Characters of UTF-8.
std::size_t lengthOf(const std::string &text);

/// Labels of points, those on the front and the defaults first.
std::vector<PlotLabel> placeLabels(const Panel &panel, const std::vector<std::size_t> &front, const PlotArea &area, const PlotScale &x,
                                   const PlotScale &y);

} // namespace taut::chart
