#pragma once
/// An axis of a plot in numbers: its ends, its tics, and where a value stands, zeros and infinities included.

#include "study/chart.h"

#include <utility>
#include <vector>

namespace taut::chart {

/// On a logarithmic axis 0 stands at the lower end, marked "0", and what is not finite at the upper end, marked "∞".
class PlotScale {
  public:
    /// Fits `values` (each with its spread) with a little room.
    PlotScale(const Axis &axis, const std::vector<Measured> &values);

    [[nodiscard]] double low() const { return low_; }
    [[nodiscard]] double high() const { return high_; }
    [[nodiscard]] bool logarithmic() const { return logarithmic_; }
    /// Where a value is drawn, in the axis' own units.
    [[nodiscard]] double place(double value) const;
    /// Where a value is drawn, as a share of the axis' length.
    [[nodiscard]] double share(double value) const;
    [[nodiscard]] const std::vector<std::pair<std::string, double>> &tics() const { return tics_; }

  private:
    bool logarithmic_;
    double low_ = 0, high_ = 1;
    double zeroAt_ = 0, infiniteAt_ = 1;
    std::vector<std::pair<std::string, double>> tics_;
};

/// 10 to a whole power as text: 0.01, 1, 100, 10⁻⁷.
std::string powerOfTen(int exponent);

} // namespace taut::chart
