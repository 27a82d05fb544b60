#pragma once
/// Where published formulations fail in float, as docs/stability.md tables it: regions in words that a test reads back, each with one
/// example and what the forms that render give there.

#include "study/chart.h"
#include "study/microsurface/precision.h"

#include <string>
#include <vector>

namespace taut::chart {

/// A part of the sweep in words: comparisons joined by "and" of
///     min, max    least and greatest alpha of the deformed surface
///     max/min     their ratio
///     view        angle of wo from the normal, degrees
/// with a number by <= or >=, e.g. "max/min >= 9000 and view >= 89.9".
class Region {
  public:
    /// Throws InputError.
    explicit Region(const std::string &words);
    [[nodiscard]] bool holds(const precision::Sample &sample) const;

  private:
    enum class Feature { Least, Greatest, Ratio, View };
    struct Condition {
        Feature feature;
        bool atLeast;
        double bound;
    };
    std::vector<Condition> conditions_;
};

/// What counts as failing: a relative error above 1e-3.
inline constexpr double kFails = 1e-3;

struct Failure {
    std::size_t formulation = 0, quantity = 0; ///< as in precision.h
    std::string where;                         ///< words of a Region
    bool notFinite = false;                    ///< not finite there, else wrong
};
/// A line of the table.
struct StabilityRow {
    Failure failure;
    MicroTransform m;
    Vec3 wo, wi;
    double theirs = 0, ours = 0, truth = 0;
};

/// A row with its three values computed anew: theirs and ours in float, truth in long double.
StabilityRow evaluated(const StabilityRow &row);

/// Its cells.
std::vector<std::string> cellsOf(const StabilityRow &row);
/// A row for every region with an example from the sweep: of those that are off by more than a tenth (or half of the most, or not
/// finite) one with the least ratio of alphas, and of these the one with alphas nearest to 1.
Table stabilityTable(const std::vector<precision::Formulation> &sweep);

/// Every line of a Markdown text that is a row of the table, read back. Throws InputError.
std::vector<StabilityRow> readStability(const std::string &text);

} // namespace taut::chart
