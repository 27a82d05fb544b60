#include "study/drawing/report.h"

#include "study/drawing/front.h"
#include "study/text.h"

#include "taut/base/error.h"
#include "taut/render/image_file.h"

#include <algorithm>
#include <cmath>
#include <ctime>
#include <fstream>
#include <iterator>
#include <thread>

namespace taut::chart {

namespace {

constexpr const char *kStyle = R"(
:root{color-scheme:light}
*{box-sizing:border-box}
body{margin:0 auto;padding:1rem;max-width:62rem;font:16px/1.5 "DejaVu Sans",Verdana,Arial,sans-serif;color:#1a1a1a;background:#fff;overflow-wrap:break-word}
h1{font-size:1.6rem;line-height:1.25}h2{font-size:1.35rem;margin-top:3rem;border-top:2px solid #1a1a1a;padding-top:.6rem}
h3{font-size:1.05rem;margin:2rem 0 .3rem}
nav a{display:inline-block;margin:0 .9rem .3rem 0}
a{color:#00559b}
dt{font-weight:bold;margin-top:.5rem}dd{margin:0}
figure{margin:.5rem 0 1.5rem}figcaption,.conditions{font-size:.85rem;color:#444}
img{max-width:100%;height:auto;display:block}
.plot img{width:100%}
.grid{display:grid;grid-template-columns:repeat(auto-fit,minmax(min(21rem,100%),1fr));gap:1rem}
.grid h3{margin-top:.5rem}
.scroll{overflow-x:auto}
table{border-collapse:collapse;font-size:.8rem;font-variant-numeric:tabular-nums}
th,td{padding:.15rem .6rem;text-align:left;border-bottom:1px solid #ddd;white-space:nowrap}
td.number{text-align:right}
.off{border-left:4px solid #D55E00;padding-left:.6rem}
summary{cursor:pointer;font-size:.9rem}
)";

std::string escaped(const std::string &text) {
    std::string out;
    for (const char c : text) out += c == '&' ? "&amp;" : c == '<' ? "&lt;" : c == '>' ? "&gt;" : c == '"' ? "&quot;" : std::string(1, c);
    return out;
}

std::string base64(const std::string &bytes) {
    static constexpr const char *kDigits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string out;
    for (std::size_t i = 0; i < bytes.size(); i += 3) {
        unsigned bits = 0;
        for (std::size_t k = 0; k < 3; ++k) bits = bits << 8U | (i + k < bytes.size() ? static_cast<unsigned char>(bytes[i + k]) : 0U);
        for (std::size_t k = 0; k < 4; ++k) out += i + k <= bytes.size() ? kDigits[bits >> (18 - 6 * k) & 63U] : '=';
    }
    return out;
}

std::string svgAddress(const std::string &svg) {
    return "data:image/svg+xml;base64," + base64(svg);
}

std::string plot(const Drawing &drawing, const std::string &title) {
    std::string text = "<figure class=\"plot\"><picture>";
    if (!drawing.narrow.empty()) text += "<source media=\"(max-width:640px)\" srcset=\"" + svgAddress(drawing.narrow) + "\">";
    return text + "<img alt=\"" + escaped(title) + "\" src=\"" + svgAddress(drawing.wide) + "\"></picture></figure>\n";
}

std::string measuredText(const Measured &m) {
    const std::string value = std::isfinite(m.value) ? printed("%.4g", m.value) : "not finite";
    return m.spread == 0 ? value : value + printed(" ± %.1g", m.spread);
}

std::string cells(const char *open, const std::vector<std::string> &texts, const char *close) {
    std::string text = "<tr>";
    for (const std::string &cell : texts) text += open + escaped(cell) + close;
    return text + "</tr>\n";
}

std::string folded(const char *summary, const std::string &rows) {
    return std::string("<details><summary>") + summary + "</summary><div class=\"scroll\"><table>" + rows + "</table></div></details>\n";
}

std::string tableOf(const Panel &panel) {
    const std::vector<std::size_t> front = panel.hasFront ? paretoFront(panel.points) : std::vector<std::size_t>();
    std::string text = cells("<th>", {"", "", nameOf(panel.x), nameOf(panel.y), "repetitions", ""}, "</th>");
    for (std::size_t i = 0; i < panel.points.size(); ++i) {
        const Point &p = panel.points[i];
        std::string remarks = p.isDefault ? "default" : "";
        if (std::find(front.begin(), front.end(), i) != front.end()) remarks += remarks.empty() ? "on the front" : ", on the front";
        text += "<tr><td>" + escaped(p.series) + "</td><td>" + escaped(p.note.empty() ? p.label : p.label + " " + p.note) +
                "</td><td class=\"number\">" + measuredText(p.x) + "</td><td class=\"number\">" + measuredText(p.y) +
                "</td><td class=\"number\">" + std::to_string(std::max(p.x.repetitions, p.y.repetitions)) + "</td><td>" + remarks +
                "</td></tr>\n";
    }
    return folded("The numbers", text);
}

std::string pictureOf(const Picture &picture) {
    std::ifstream file(picture.file, std::ios::binary);
    const std::string bytes{std::istreambuf_iterator<char>(file), {}};
    if (bytes.empty()) throw RunError(picture.file.string() + ": can't be read");
    return "<figure><img alt=\"" + escaped(picture.caption) + "\" src=\"data:image/png;base64," + base64(bytes) + "\"><figcaption>" +
           escaped(picture.caption) + "</figcaption></figure>\n";
}

std::string sectionText(const Section &section) {
    const Chart &chart = section.chart;
    std::string text = "<section id=\"" + chart.name + "\"><h2>" + escaped(chart.title) + "</h2>\n<dl>";
    for (const auto &[term, words] :
         {std::pair("Compared", chart.compared), {"How to read it", chart.howToRead}, {"The default", chart.choice}})
        if (!words.empty()) text += std::string("<dt>") + term + "</dt><dd>" + escaped(words) + "</dd>";
    text += "</dl>\n";
    for (const std::string &line : checkDefaults(chart)) text += "<p class=\"off\">" + escaped(line) + "</p>\n";
    for (std::size_t i = 0; i < chart.panels.size(); ++i) {
        const Panel &panel = chart.panels[i];
        text += "<h3>" + escaped(panel.title) + "</h3>\n<p class=\"conditions\">" + escaped(panel.conditions) + "</p>\n" +
                plot(section.panels[i], panel.title) + tableOf(panel);
    }
    if (!chart.maps.empty()) text += "<div class=\"grid\">\n";
    for (std::size_t i = 0; i < chart.maps.size(); ++i)
        text += "<div><h3>" + escaped(chart.maps[i].title) + "</h3><p class=\"conditions\">" + escaped(chart.maps[i].conditions) + "</p>" +
                plot(section.maps[i], chart.maps[i].title) + "</div>\n";
    if (!chart.maps.empty()) text += "</div>\n";
    for (const Picture &picture : chart.pictures) text += pictureOf(picture);
    for (const Table &table : chart.tables) {
        std::string rows = cells("<th>", table.head, "</th>");
        for (const auto &row : table.rows) rows += cells("<td>", row, "</td>");
        text += "<h3>" + escaped(table.title) + "</h3>\n" + folded("The table", rows);
    }
    return text + "</section>\n";
}

} // namespace

Section draw(const Chart &chart, const std::filesystem::path &directory) {
    Section section{chart, {}, {}};
    for (const Panel &panel : chart.panels) section.panels.push_back(drawPanel(chart, panel, directory));
    for (const Map &map : chart.maps) section.maps.push_back(drawMap(chart, map, directory));
    return section;
}

std::string describeMachine() {
    std::string processor = "unknown processor";
    std::ifstream file("/proc/cpuinfo");
    for (std::string line; std::getline(file, line);)
        if (line.rfind("model name", 0) == 0) {
            processor = line.substr(line.find(':') + 2);
            break;
        }
    return processor + ", " + std::to_string(std::thread::hardware_concurrency()) + " threads, GCC " __VERSION__;
}

std::string reportPage(const std::vector<Section> &sections, Effort effort, const std::string &machine, const std::string &date) {
    std::string text = "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><meta name=\"viewport\" "
                       "content=\"width=device-width,initial-scale=1\"><title>Taut: speed against accuracy</title><style>" +
                       std::string(kStyle) + "</style></head><body>\n<h1>Taut: speed against accuracy</h1>\n<p>Measured on " +
                       escaped(machine) + ", " + escaped(date) + ", " + (effort == Effort::Quick ? "quick" : "full") +
                       ". Times are medians over rounds in which every choice is run once; bars and ± are half the distance between the "
                       "quartiles. Less is better on both axes where the front of choices that nothing beats (the Pareto front) is drawn. "
                       "A black ring is what the code does where nobody asks for another choice; ∞ is what is not finite.</p>\n<nav>";
    for (const Section &section : sections) text += "<a href=\"#" + section.chart.name + "\">" + escaped(section.chart.name) + "</a>";
    text += "</nav>\n";
    for (const Section &section : sections) text += sectionText(section);
    return text + "</body></html>\n";
}

void makeFolder(const std::filesystem::path &directory, const std::string &option) {
    std::error_code error;
    std::filesystem::create_directories(directory, error);
    if (error) failInput({option}, quoted(directory.string()), "a folder that can be made");
}

std::filesystem::path writeReport(const std::vector<Section> &sections, Effort effort, const std::filesystem::path &directory) {
    const std::time_t now = std::time(nullptr);
    char date[32];
    std::strftime(date, sizeof date, "%Y-%m-%d %H:%M UTC", std::gmtime(&now));
    const std::filesystem::path page = directory / "index.html";
    writeTextFile(page.string(), reportPage(sections, effort, describeMachine(), date));
    return page;
}

} // namespace taut::chart
