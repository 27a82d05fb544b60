#include "study/drawing/plots.h"

#include "study/drawing/csv.h"
#include "study/drawing/front.h"
#include "study/drawing/plot_labels.h"
#include "study/drawing/plot_scale.h"
#include "study/text.h"

#include "taut/base/error.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <iterator>

namespace taut::chart {

namespace {

/// Okabe and Ito's colours without yellow, which white swallows; each series has a mark of its own as well.
constexpr const char *kColours[] = {"#0072B2", "#D55E00", "#009E73", "#CC79A7", "#56B4E9", "#E69F00", "#555555"};
constexpr int kMarks[] = {7, 5, 9, 13, 11, 15, 4, 8, 12, 10, 14, 1, 2, 3};
constexpr const char *kViridis = "set palette defined (0 '#440154', 1 '#472d7b', 2 '#3b528b', 3 '#2c728e', 4 '#21918c', 5 '#28ae80', 6 "
                                 "'#5ec962', 7 '#addc30', 8 '#fde725')\n";

std::string number(double value) {
    return printed("%.7g", value);
}

/// A gnuplot string, in which nothing has a meaning.
std::string literal(const std::string &text) {
    std::string out = "'";
    for (const char c : text) out += c == '\'' ? std::string("''") : std::string(1, c == '\n' ? ' ' : c);
    return out + "'";
}

enum class Format { Svg, Png };

std::string terminal(Format format, int width, int height, const std::filesystem::path &output) {
    const std::string size = std::to_string(width) + "," + std::to_string(height);
    const std::string kind = format == Format::Svg ? "svg size " + size + " dynamic font 'DejaVu Sans,13' background '#ffffff'"
                                                   : "pngcairo size " + size + " font 'DejaVu Sans,10' background '#ffffff'";
    return "reset\nset encoding utf8\nset term " + kind + " noenhanced\nset output " + literal(output.string()) + "\n";
}

std::string axisText(char axis, const PlotScale &scale) {
    const std::string a(1, axis);
    std::string text = scale.logarithmic() ? "set logscale " + a + "\n" : "";
    text += "set " + a + "range [" + number(scale.low()) + ":" + number(scale.high()) + "]\nset " + a + "tics nomirror (";
    const char *comma = "";
    for (const auto &[label, at] : scale.tics()) {
        text += comma + literal(label) + " " + number(at);
        comma = ", ";
    }
    return text + ")\n";
}

/// Names of both axes at places of their own: gnuplot drops one that its tics leave no room for.
std::string axisNames(const Axis &x, const Axis &y, const PlotArea &area, double down, double aside) {
    return "set label " + literal(nameOf(x)) + " at screen " + number((area.left + area.right) / 2) + "," +
           number(area.bottom - down / area.height) + " center\nset label " + literal(nameOf(y)) + " at screen " +
           number(aside / area.width) + "," + number((area.bottom + area.top) / 2) + " center rotate by 90\n";
}

std::string margins(const PlotArea &area) {
    return "set lmargin at screen " + number(area.left) + "\nset rmargin at screen " + number(area.right) + "\nset bmargin at screen " +
           number(area.bottom) + "\nset tmargin at screen " + number(area.top) + "\n";
}

/// Series by their first appearance.
std::vector<std::string> seriesOf(const Panel &panel) {
    std::vector<std::string> series;
    for (const Point &p : panel.points)
        if (std::find(series.begin(), series.end(), p.series) == series.end()) series.push_back(p.series);
    return series;
}

constexpr int kKeyLeft = 658; ///< of the key beside a plot, pixels

/// What a panel looks like in one shape.
struct Shape {
    int width, height;
    PlotArea area; ///< shares of the picture
    bool titled, keyBelow;
};

/// The key beside the plot has room for its longest name.
Shape wideShape(bool titled, const std::vector<std::string> &series) {
    constexpr int kKeyCharacter = 8, kKeyMark = 45; // pixels
    std::size_t longest = 0;
    for (const std::string &name : series) longest = std::max(longest, lengthOf(name));
    const int width = std::max(960, kKeyLeft + kKeyMark + kKeyCharacter * static_cast<int>(longest));
    return {width, 500, {double(width), 500, 91.0 / width, 638.0 / width, 0.13, titled ? 0.91 : 0.97}, titled, false};
}
Shape narrowShape(std::size_t keyLines) {
    const int key = 19 * static_cast<int>(keyLines) + 24;
    const int height = 390 + key;
    const double bottom = (60.0 + key) / height;
    return {400, height, {400.0, double(height), 0.19, 0.95, bottom, 0.97}, false, true};
}

std::string panelScript(const Panel &panel, const Shape &shape, Format format, const PlotScale &x, const PlotScale &y) {
    const std::vector<std::string> series = seriesOf(panel);
    const std::vector<std::size_t> front = panel.hasFront ? paretoFront(panel.points) : std::vector<std::size_t>();
    std::string text = margins(shape.area);
    if (shape.titled) text += "set title " + literal(panel.title) + "\n";
    text += axisText('x', x) + axisText('y', y) + axisNames(panel.x, panel.y, shape.area, 42, 14);
    text += "set grid lc rgb '#dddddd' lw 0.7\nset border 3 lc rgb '#444444'\n";
    text +=
        shape.keyBelow
            ? "set key at screen 0.03," + number(shape.area.bottom - 58.0 / shape.height) + " left top Left reverse samplen 1 spacing 1.1\n"
            : "set key at screen " + number(double(kKeyLeft) / shape.width) + ",0.965 left top Left reverse samplen 1 spacing 1.25\n";
    const std::vector<PlotLabel> labels = panel.labelled ? placeLabels(panel, front, shape.area, x, y) : std::vector<PlotLabel>();
    for (const PlotLabel &label : labels)
        text += "set label " + literal(label.text) + " at screen " + number(label.x) + "," + number(label.y) + " center front font '," +
                (format == Format::Png ? "8.5" : "11") + "' tc rgb '#333333'\n";

    std::string plot;
    const auto add = [&](const std::string &what) { plot += (plot.empty() ? "plot " : ", \\\n  ") + what; };
    if (front.size() > 0) {
        text += "$front << EOD\n";
        text += number(x.place(panel.points[front.front()].x.value)) + " " + number(y.high()) + "\n";
        for (const std::size_t i : front)
            text += number(x.place(panel.points[i].x.value)) + " " + number(y.place(panel.points[i].y.value)) + "\n";
        text += number(x.high()) + " " + number(y.place(panel.points[front.back()].y.value)) + "\nEOD\n";
        add("$front with steps lc rgb '#999999' lw 2 dt 2 title 'Pareto front'");
    }
    for (std::size_t s = 0; s < series.size(); ++s) {
        const std::string block = "$series" + std::to_string(s);
        text += block + " << EOD\n";
        for (const Point &p : panel.points) {
            if (p.series != series[s]) continue;
            const double px = x.place(p.x.value);
            const double py = y.place(p.y.value);
            // An end that would leave a logarithmic axis stops at its end.
            const auto end = [](const PlotScale &scale, const Measured &m, double sign, double at) {
                const double value = m.value + sign * m.spread;
                if (m.spread == 0 || !std::isfinite(value)) return at;
                return value <= 0 && scale.logarithmic() ? scale.low() : scale.place(value);
            };
            text += number(px) + " " + number(py) + " " + number(end(x, p.x, -1, px)) + " " + number(end(x, p.x, 1, px)) + " " +
                    number(end(y, p.y, -1, py)) + " " + number(end(y, p.y, 1, py)) + "\n";
        }
        text += "EOD\n";
        const std::string colour = " lc rgb '" + std::string(kColours[s % std::size(kColours)]) + "'";
        if (panel.joined) add(block + " using 1:2 with lines notitle lw 1.2" + colour);
        add(block + " using 1:2:3:4:5:6 with xyerrorbars notitle lw 1 ps 0" + colour);
        add(block + " using 1:2 with points pt " + std::to_string(kMarks[s % std::size(kMarks)]) + " ps 1.1" + colour + " title " +
            literal(series[s]));
    }
    std::string defaults;
    for (const Point &p : panel.points)
        if (p.isDefault) defaults += number(x.place(p.x.value)) + " " + number(y.place(p.y.value)) + "\n";
    if (!defaults.empty()) {
        text += "$defaults << EOD\n" + defaults + "EOD\n";
        add("$defaults with points pt 6 ps 2.4 lw 2 lc rgb '#000000' title 'default'");
    }
    return text + plot + "\n";
}

/// Edges of cells about their middles: halfway, on the axis' own scale.
std::vector<double> edgesOf(const std::vector<double> &middles, bool logarithmic) {
    std::vector<double> at = middles;
    if (logarithmic)
        for (double &value : at) value = std::log(value);
    std::vector<double> edges;
    const double first = at.size() > 1 ? at[1] - at[0] : 1;
    const double last = at.size() > 1 ? at[at.size() - 1] - at[at.size() - 2] : 1;
    edges.push_back(at.front() - first / 2);
    for (std::size_t i = 1; i < at.size(); ++i) edges.push_back((at[i - 1] + at[i]) / 2);
    edges.push_back(at.back() + last / 2);
    if (logarithmic)
        for (double &value : edges) value = std::exp(value);
    return edges;
}

std::string axisOfCells(char axis, const Axis &what, const std::vector<double> &edges) {
    const PlotScale tics(what, {{edges.front(), 0, 1}, {edges.back(), 0, 1}});
    const std::string a(1, axis);
    // The scale's room is taken back: cells fill the plot.
    return axisText(axis, tics) + "set " + a + "range [" + number(edges.front()) + ":" + number(edges.back()) + "]\n";
}

std::string mapScript(const Map &map, bool titled) {
    const std::vector<double> xs = edgesOf(map.xs, map.x.logarithmic);
    const std::vector<double> ys = edgesOf(map.ys, map.y.logarithmic);
    double low = map.low;
    double high = map.high;
    if (!(high > low)) {
        low = INFINITY;
        high = 0;
        for (const double v : map.values)
            if (std::isfinite(v) && v > 0) {
                low = std::min(low, v);
                high = std::max(high, v);
            }
        if (!(high > low)) low = (high = high > 0 ? high : 1) / 10;
    }
    std::string finite;
    std::string hatched;
    for (std::size_t row = 0; row < map.ys.size(); ++row)
        for (std::size_t column = 0; column < map.xs.size(); ++column) {
            const double value = map.values[row * map.xs.size() + column];
            const std::string cell = number(map.xs[column]) + " " + number(map.ys[row]) + " " + number(xs[column]) + " " +
                                     number(xs[column + 1]) + " " + number(ys[row]) + " " + number(ys[row + 1]);
            if (std::isfinite(value))
                finite += cell + " " + number(std::log10(std::clamp(value, low, high))) + "\n";
            else
                hatched += cell + "\n";
        }
    const PlotArea area{420, 380, 0.18, 0.78, 0.16, titled ? 0.9 : 0.96};
    std::string text = margins(area) + axisNames(map.x, map.y, area, 42, 12);
    text += titled ? "set title " + literal(map.title) + "\n" : "";
    text += axisOfCells('x', map.x, xs) + axisOfCells('y', map.y, ys) + kViridis;
    text += "unset key\nset cbrange [" + number(std::log10(low)) + ":" + number(std::log10(high)) + "]\nset cblabel " +
            literal(map.valueName) + "\nset cbtics (";
    const char *comma = "";
    const PlotScale bar({"", ""}, {{low, 0, 1}, {high, 0, 1}});
    for (const auto &[label, at] : bar.tics()) {
        text += comma + literal(label) + " " + number(std::log10(at));
        comma = ", ";
    }
    text += ")\n$finite << EOD\n" + finite + "EOD\n$hatched << EOD\n" + hatched + "EOD\n";
    std::string plot;
    if (!finite.empty()) plot += "$finite using 1:2:3:4:5:6:7 with boxxyerror fs solid 1 noborder fc palette";
    if (!hatched.empty())
        plot += std::string(plot.empty() ? "" : ", ") + "$hatched using 1:2:3:4:5:6 with boxxyerror fs pattern 5 noborder fc rgb '#000000'";
    return text + "set tics front\nplot " + plot + "\n";
}

void runGnuplot(const std::string &script, const std::string &what) {
    std::FILE *pipe = popen("gnuplot", "w");
    if (pipe == nullptr) throw RunError(what + ": gnuplot can't be started");
    const bool written = std::fwrite(script.data(), 1, script.size(), pipe) == script.size();
    if (pclose(pipe) != 0 || !written) throw RunError(what + ": gnuplot failed");
}

std::string takeFile(const std::filesystem::path &path) {
    std::string text;
    {
        std::ifstream file(path, std::ios::binary);
        text.assign(std::istreambuf_iterator<char>(file), {});
    }
    std::filesystem::remove(path);
    if (text.empty()) throw RunError(path.string() + ": gnuplot left nothing");
    return text;
}

} // namespace

void requireGnuplot() {
    std::FILE *pipe = popen("gnuplot --version > /dev/null 2>&1", "r");
    if (pipe == nullptr || pclose(pipe) != 0)
        throw InputError("gnuplot: found no such program, expected it for the plots (Debian: gnuplot-nox)");
}

Drawing drawPanel(const Chart &chart, const Panel &panel, const std::filesystem::path &directory) {
    std::vector<Measured> xs;
    std::vector<Measured> ys;
    for (const Point &p : panel.points) {
        xs.push_back(p.x);
        ys.push_back(p.y);
    }
    const PlotScale x(panel.x, xs);
    const PlotScale y(panel.y, ys);
    const auto wideFile = fileOf(directory, chart, panel.name, "wide.svg");
    const auto narrowFile = fileOf(directory, chart, panel.name, "narrow.svg");
    const std::vector<std::string> series = seriesOf(panel);
    const Shape titled = wideShape(true, series);
    const Shape wide = wideShape(false, series);
    const Shape narrow = narrowShape(series.size() + 2);
    std::string script;
    const auto draw = [&](const Shape &shape, Format format, const std::filesystem::path &output) {
        script += terminal(format, shape.width, shape.height, output) + panelScript(panel, shape, format, x, y);
    };
    draw(titled, Format::Svg, fileOf(directory, chart, panel.name, "svg"));
    draw(titled, Format::Png, fileOf(directory, chart, panel.name, "png"));
    draw(wide, Format::Svg, wideFile);
    draw(narrow, Format::Svg, narrowFile);
    runGnuplot(script, chart.name + "/" + panel.name);
    return {takeFile(wideFile), takeFile(narrowFile)};
}

Drawing drawMap(const Chart &chart, const Map &map, const std::filesystem::path &directory) {
    const auto file = fileOf(directory, chart, map.name, "wide.svg");
    std::string script;
    const auto draw = [&](bool titled, Format format, const std::filesystem::path &output) {
        script += terminal(format, 420, 380, output) + mapScript(map, titled);
    };
    draw(true, Format::Svg, fileOf(directory, chart, map.name, "svg"));
    draw(true, Format::Png, fileOf(directory, chart, map.name, "png"));
    draw(false, Format::Svg, file);
    runGnuplot(script, chart.name + "/" + map.name);
    return {takeFile(file), ""};
}

} // namespace taut::chart
