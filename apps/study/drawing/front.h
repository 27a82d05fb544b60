#pragma once
/// Which choices nothing beats: the Pareto front of a panel, whether the defaults of the code lie on it, and whether two runs agree.

#include "study/chart.h"

#include <cstddef>

namespace taut::chart {

/// Indices of the points that no other point beats (less or equal on both axes and less on one), by rising x. Values as measured,
/// without their spread; points with a NaN are left out, infinite ones stay where nothing is better.
std::vector<std::size_t> paretoFront(const std::vector<Point> &points);

/// One line for every default and every choice of its panel that still beats it once the default is moved by the spreads of both towards
/// less time and less error. Panels without a front are not looked at.
std::vector<std::string> checkDefaults(const Chart &chart);

/// A panel with the points of an earlier run on the same axes, their series called "before"; none of them is a default.
Panel beside(Panel panel, const Panel &earlier);

/// How two runs of a panel order the same choices.
struct Ranking {
    std::size_t pairs = 0;           ///< of choices that both runs tell apart, on either axis
    std::vector<std::string> turned; ///< one line for each that they order differently
};
/// Two choices are told apart by a run where their difference is more than the spreads of both.
Ranking compareRankings(const Panel &first, const Panel &second);

} // namespace taut::chart
