#pragma once
/// What `taut chart` measures and reports: time on one axis, error against an independent truth on the other. A measuring function
/// fills a Chart; writers turn any Chart into CSV, plots and a section of the report.

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

namespace taut::chart {

/// How long a chart may take: all of them in ten minutes on two cores, or as long as they need.
enum class Effort { Quick, Full };

/// A median over `repetitions` and how far it may be off: half the distance between the quartiles; 0 for what has no noise.
struct Measured {
    double value = 0;
    double spread = 0;
    int repetitions = 1;
};

struct Axis {
    std::string name;
    std::string unit; ///< empty for a ratio
    bool logarithmic = true;
};

/// One choice, measured.
struct Point {
    std::string series; ///< what shares a colour and a mark: an estimator, a sampler
    std::string label;  ///< what sets it apart within the series: a level, a resolution, a tolerance
    Measured x, y;
    bool isDefault = false; ///< the choice that the code makes where nobody asks for another
    std::string note = {};  ///< drawn beside the mark instead of the label: a number that changes from run to run
};

/// A plot of choices. Less is better on both axes where `hasFront`: the Pareto front is drawn, and defaults are held to it.
struct Panel {
    std::string name; ///< unique in its chart; names the files
    std::string title;
    std::string conditions; ///< scene, machine state, sizes: what the numbers hold for
    Axis x, y;
    std::vector<Point> points = {};
    bool hasFront = true;
    bool joined = false;  ///< lines through the points of a series, in their order
    bool labelled = true; ///< labels stand beside the marks; false where an axis says the same
};
/// A panel of lines against an axis that says what labels would: no front.
inline Panel lines(Panel panel) {
    panel.joined = true;
    panel.hasFront = panel.labelled = false;
    return panel;
}

/// Values over a grid, row by row from the lowest y; what is not finite is hatched.
struct Map {
    std::string name, title, conditions;
    Axis x, y;
    std::vector<double> xs, ys, values;
    std::string valueName;    ///< with unit, if any; drawn on a logarithmic scale
    double low = 0, high = 0; ///< ends of that scale, for maps that share it; 0, 0: from the values
};

/// Numbers of many columns, for which no plot serves: text under heads.
struct Table {
    std::string name, title;
    std::vector<std::string> head;
    std::vector<std::vector<std::string>> rows = {};
};

/// An image as renders are kept: R G B, linear, rows from the top.
using Pixels = std::vector<float>;

/// A rendered picture, already written beside the report.
struct Picture {
    std::string caption;
    std::filesystem::path file;
};

struct Chart {
    std::string name; ///< as on the command line
    std::string title;
    std::string compared;       ///< what is compared with what, and what the truth is
    std::string howToRead = {}; ///< the axes, the marks
    std::string choice = {};    ///< which choice is the default, and why the chart supports it (or does not)
    std::vector<Panel> panels = {};
    std::vector<Map> maps = {};
    std::vector<Picture> pictures = {};
    std::vector<Table> tables = {};
};

/// What a measuring function is told.
struct ChartOptions {
    Effort effort = Effort::Quick;
    std::filesystem::path directory; ///< of the report, made already; pictures go there
    [[nodiscard]] int pick(int quick, int full) const { return effort == Effort::Quick ? quick : full; }
};

} // namespace taut::chart
