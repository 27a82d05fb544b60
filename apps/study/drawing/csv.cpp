#include "study/drawing/csv.h"

#include "study/drawing/front.h"
#include "study/text.h"

#include "taut/base/error.h"
#include "taut/render/image_file.h"

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <iterator>

namespace taut::chart {

namespace {

constexpr const char *kPanelHeader =
    "chart,panel,conditions,series,label,default,on_front,x_name,x_unit,x,x_spread,x_repetitions,y_name,y_unit,y,y_spread,y_repetitions";
constexpr std::size_t kPanelFields = 17;

std::string field(const std::string &text) {
    if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
    std::string out = "\"";
    for (const char c : text) out += c == '"' ? std::string("\"\"") : std::string(1, c);
    return out + "\"";
}

std::string field(double value) {
    return printed("%.9g", value);
}

std::string field(const Measured &m) {
    return field(m.value) + "," + field(m.spread) + "," + std::to_string(m.repetitions);
}

std::string textOf(const Chart &chart, const Panel &panel) {
    std::string text = std::string(kPanelHeader) + "\n";
    const std::vector<std::size_t> front = panel.hasFront ? paretoFront(panel.points) : std::vector<std::size_t>();
    for (std::size_t i = 0; i < panel.points.size(); ++i) {
        const Point &p = panel.points[i];
        const bool onFront = std::find(front.begin(), front.end(), i) != front.end();
        text += field(chart.name) + "," + field(panel.name) + "," + field(panel.conditions) + "," + field(p.series) + "," + field(p.label) +
                (p.isDefault ? ",1," : ",0,") + (onFront ? "1," : "0,") + field(panel.x.name) + "," + field(panel.x.unit) + "," +
                field(p.x) + "," + field(panel.y.name) + "," + field(panel.y.unit) + "," + field(p.y) + "\n";
    }
    return text;
}

std::string textOf(const Chart &chart, const Map &map) {
    std::string text = "chart,map,conditions,x_name,x_unit,x,y_name,y_unit,y,value_name,value\n";
    for (std::size_t row = 0; row < map.ys.size(); ++row)
        for (std::size_t column = 0; column < map.xs.size(); ++column)
            text += field(chart.name) + "," + field(map.name) + "," + field(map.conditions) + "," + field(map.x.name) + "," +
                    field(map.x.unit) + "," + field(map.xs[column]) + "," + field(map.y.name) + "," + field(map.y.unit) + "," +
                    field(map.ys[row]) + "," + field(map.valueName) + "," + field(map.values[row * map.xs.size() + column]) + "\n";
    return text;
}

std::string textOf(const Table &table) {
    std::string text;
    const auto add = [&](const std::vector<std::string> &cells) {
        for (const std::string &cell : cells) text += (&cell == cells.data() ? "" : ",") + field(cell);
        text += "\n";
    };
    add(table.head);
    for (const auto &row : table.rows) add(row);
    return text;
}

/// Lines of fields, quotes taken off.
std::vector<std::vector<std::string>> parse(const std::string &text) {
    std::vector<std::vector<std::string>> lines(1, std::vector<std::string>(1));
    bool inside = false;
    for (std::size_t i = 0; i < text.size(); ++i) {
        const char c = text[i];
        std::string &last = lines.back().back();
        if (inside && c == '"' && i + 1 < text.size() && text[i + 1] == '"') {
            last += c;
            ++i;
        } else if (c == '"') {
            inside = !inside;
        } else if (!inside && c == ',') {
            lines.back().emplace_back();
        } else if (!inside && c == '\n') {
            lines.emplace_back(1);
        } else {
            last += c;
        }
    }
    lines.pop_back(); // what follows the last line's end
    return lines;
}

double number(const std::filesystem::path &path, std::size_t line, const std::string &text) {
    char *end = nullptr;
    const double value = std::strtod(text.c_str(), &end);
    if (text.empty() || *end != '\0') failInput({path.string(), static_cast<int>(line) + 1}, quoted(text), "a number");
    return value;
}

} // namespace

std::filesystem::path fileOf(const std::filesystem::path &directory, const Chart &chart, const std::string &name,
                             const std::string &extension) {
    return directory / (chart.name + "_" + name + "." + extension);
}

void writeCsv(const Chart &chart, const std::filesystem::path &directory) {
    const auto write = [&](const std::string &name, const std::string &text) {
        writeTextFile(fileOf(directory, chart, name, "csv").string(), text);
    };
    for (const Panel &panel : chart.panels) write(panel.name, textOf(chart, panel));
    for (const Map &map : chart.maps) write(map.name, textOf(chart, map));
    for (const Table &table : chart.tables) write(table.name, textOf(table));
}

Panel readPanel(const std::filesystem::path &path) {
    std::ifstream file(path, std::ios::binary);
    if (!file) failInput({path.string()}, "no such file", "a panel of a report");
    const std::string text{std::istreambuf_iterator<char>(file), {}};
    if (text.rfind(std::string(kPanelHeader) + "\n", 0) != 0)
        failInput({path.string(), 1}, "another first line", quoted(std::string_view(kPanelHeader)));
    Panel panel;
    const auto lines = parse(text);
    for (std::size_t i = 1; i < lines.size(); ++i) {
        const auto &f = lines[i];
        if (f.size() != kPanelFields)
            failInput({path.string(), static_cast<int>(i) + 1}, std::to_string(f.size()) + " fields", std::to_string(kPanelFields));
        const auto measured = [&](std::size_t at) {
            return Measured{number(path, i, f[at]), number(path, i, f[at + 1]), static_cast<int>(number(path, i, f[at + 2]))};
        };
        panel.name = f[1];
        panel.conditions = f[2];
        panel.x = {f[7], f[8]};
        panel.y = {f[12], f[13]};
        panel.points.push_back({f[3], f[4], measured(9), measured(14), f[5] == "1"});
    }
    return panel;
}

} // namespace taut::chart
