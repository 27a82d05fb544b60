/// What `taut chart` does with its numbers, whatever they are: the front, the check of defaults, rankings, CSV, plots and the page. Nothing
/// here depends on a time that was measured.

#include "command.h"
#include "study/charts.h"
#include "study/drawing/csv.h"
#include "study/drawing/front.h"
#include "study/drawing/plot_labels.h"
#include "study/drawing/plot_scale.h"
#include "study/drawing/report.h"
#include "study/measures/timing.h"
#include "study/text.h"

#include "taut/base/error.h"

#include <cmath>
#include <cstdlib>
#include <regex>

using namespace taut;
using namespace taut::chart;
using namespace taut::test;

namespace {

Point at(const std::string &series, double x, double y, bool isDefault = false, double spread = 0) {
    return {series, "", {x, spread, 9}, {y, 0, 1}, isDefault};
}

Panel panelOf(std::vector<Point> points) {
    Panel panel;
    panel.name = "made_up";
    panel.title = "A panel, \"quoted\" <and> all";
    panel.conditions = "one, two\nand three";
    panel.x = {"time", "ns"};
    panel.y = {"error", ""};
    panel.points = std::move(points);
    return panel;
}

Chart chartOf(Panel panel) {
    Chart chart;
    chart.name = "test";
    chart.title = "A test & more";
    chart.compared = "This with that, at https://example.org";
    chart.panels.push_back(std::move(panel));
    return chart;
}

Map mapOf(double corner) {
    Map map;
    map.name = "map";
    map.title = "A map";
    map.x = {"alpha", ""};
    map.y = {"stretch", ""};
    map.xs = {0.1, 1, 10};
    map.ys = {1, 2};
    map.values = {1e-7, 1e-3, 0, 1, 1e-9, corner};
    map.valueName = "error";
    return map;
}

bool hasGnuplot() {
    try {
        requireGnuplot();
        return true;
    } catch (const InputError &) {
        WARN("skipped: there is no gnuplot");
        return false;
    }
}

std::size_t count(const std::string &text, const std::string &what) {
    std::size_t n = 0;
    for (std::size_t i = text.find(what); i != std::string::npos; i = text.find(what, i + what.size())) ++n;
    return n;
}

} // namespace

TEST_CASE("chart: the front holds what nothing beats", "[chart]") {
    using Indices = std::vector<std::size_t>;
    CHECK(paretoFront({at("a", 3, 1), at("b", 1, 3), at("c", 2, 2), at("d", 3, 3), at("e", 2.5, 2)}) == Indices{1, 2, 0});
    CHECK(paretoFront({at("a", 1, 1), at("b", 1, 1)}) == Indices{0, 1}); // equals do not beat each other
    CHECK(paretoFront({at("a", 1, INFINITY), at("b", 2, 5), at("c", 3, INFINITY), at("d", 0.5, NAN)}) == Indices{0, 1});
    CHECK(paretoFront({}).empty());
}

TEST_CASE("chart: a default off the front by more than the spread is named, by less it is not", "[chart]") {
    const auto check = [](const std::vector<Point> &points) { return checkDefaults(chartOf(panelOf(points))); };
    CHECK(check({at("ours", 2, 1, true), at("fast", 1, 2)}).empty());
    const auto off = check({at("ours", 2, 1, true), at("theirs", 1, 1)});
    REQUIRE(off.size() == 1);
    CHECK(off[0].find("test/made_up") == 0);
    CHECK(off[0].find("ours") != std::string::npos);
    CHECK(off[0].find("theirs") != std::string::npos);
    CHECK(check({at("ours", 2, 1, true, 0.6), at("theirs", 1, 1, false, 0.6)}).empty());
    CHECK(check({at("ours", 2, 1, true, 0.3), at("theirs", 1, 1, false, 0.3)}).size() == 1);
    CHECK(check({at("ours", 1.01, 1, true, 0.02), at("theirs", 1, 0.5, false, 0.02)}).empty()); // as fast as can be told
    CHECK(check({at("ours", 1, INFINITY, true), at("theirs", 1, 5)}).size() == 1);
    Panel panel = panelOf({at("ours", 2, 2, true), at("theirs", 1, 1)});
    panel.hasFront = false;
    CHECK(checkDefaults(chartOf(panel)).empty());
}

TEST_CASE("chart: rankings of two runs are compared where both tell choices apart", "[chart]") {
    const Panel first = panelOf({at("a", 1, 1, false, 0.1), at("b", 2, 2, false, 0.1), at("c", 2.1, 3, false, 0.1)});
    CHECK(compareRankings(first, first).pairs == 5); // b and c are equally fast
    CHECK(compareRankings(first, first).turned.empty());
    Panel second = first;
    second.points[0].x.value = 2.6;
    CHECK(compareRankings(first, second).turned.size() == 2);
    second.points[0].x.spread = 1;
    CHECK(compareRankings(first, second).turned.empty());
    second.points.pop_back();
    CHECK(compareRankings(first, second).pairs == 1); // y of a and b
}

TEST_CASE("chart: an earlier run stands beside on the same axes, and none of its choices is a default", "[chart]") {
    const Panel both = beside(panelOf({at("a", 1, 1, true)}), panelOf({at("a", 2, 3, true), at("b", 4, 5)}));
    REQUIRE(both.points.size() == 3);
    CHECK(both.points[0].isDefault);
    CHECK(both.points[1].series == both.points[0].series + ", before");
    CHECK(both.points[1].x.value == 2);
    CHECK_FALSE(both.points[1].isDefault);
    CHECK(checkDefaults(chartOf(both)).empty());
}

TEST_CASE("chart: the median of times and how far it may be off", "[chart]") {
    const Measured m = medianOf({5, 1, 2, 4, 3});
    CHECK(m.value == 3);
    CHECK(m.spread == 1);
    CHECK(m.repetitions == 5);
    CHECK(medianOf({2, 1, 4}).spread == 1.5); // of three the least and the greatest
    CHECK(medianOf({7}).spread == 0);
    const Quartiles five = quartilesOf({5, 1, 4, 2, 3});
    CHECK(five.lower == 2);
    CHECK(five.median == 3);
    CHECK(five.upper == 4);
    std::vector<int> order;
    const std::vector<std::function<void()>> rows{[&] { order.push_back(0); }, [&] { order.push_back(1); }};
    CHECK(timeInterleaved(rows, 2).size() == 2);
    CHECK(order == std::vector<int>{0, 1, 0, 1, 0, 1}); // the first round is not counted
    const std::vector<Point> points = timeChoices({{"a", "1", true, [](std::uint32_t seed) { return 2.0 * seed; }}}, 2, Threads::All);
    CHECK(points[0].y.value == 4); // of 2, 4, 6
    CHECK(points[0].x.repetitions == 2);
    CHECK(points[0].isDefault);
}

TEST_CASE("chart: CSV comes back as it went", "[chart]") {
    const fs::path folder = freshFolder("chart_csv");
    Chart chart = chartOf(panelOf({at("a, \"b\"", 1.25, INFINITY, true, 0.5), at("c", 1e-300, 0)}));
    chart.panels[0].points[1].label = "level\n3";
    chart.maps.push_back(mapOf(NAN));
    writeCsv(chart, folder);
    const Panel &wrote = chart.panels[0];
    const Panel read = readPanel(fileOf(folder, chart, wrote.name, "csv"));
    CHECK(read.name == wrote.name);
    CHECK(read.conditions == wrote.conditions);
    CHECK((read.x.name == "time" && read.x.unit == "ns" && read.y.name == "error"));
    REQUIRE(read.points.size() == 2);
    for (std::size_t i = 0; i < 2; ++i) {
        CHECK(read.points[i].series == wrote.points[i].series);
        CHECK(read.points[i].label == wrote.points[i].label);
        CHECK(read.points[i].isDefault == wrote.points[i].isDefault);
        CHECK(read.points[i].x.value == wrote.points[i].x.value);
        CHECK(read.points[i].x.spread == wrote.points[i].x.spread);
        CHECK(read.points[i].x.repetitions == wrote.points[i].x.repetitions);
        CHECK(read.points[i].y.value == wrote.points[i].y.value);
    }
    const std::string cells = readBytes((folder / "test_map.csv").string());
    CHECK(linesOf(cells).size() == 7);
    CHECK(cells.find("10,stretch,,2,error,nan") != std::string::npos);
    writeBytes((folder / "bad.csv").string(), "a,b\n1,2\n");
    CHECK_THROWS_AS(readPanel(folder / "bad.csv"), InputError);
    CHECK_THROWS_AS(readPanel(folder / "none.csv"), InputError);
    writeBytes((folder / "short.csv").string(), linesOf(readBytes((folder / "test_made_up.csv").string()))[0] + "\n1,2,3\n");
    CHECK_THROWS_AS(readPanel(folder / "short.csv"), InputError);
}

TEST_CASE("chart: a scale holds its values, zero and infinity at its ends", "[chart]") {
    const struct {
        std::vector<Measured> values;
        bool logarithmic;
    } cases[] = {{{{1e-7}, {3, 1}, {0}, {INFINITY}}, true},
                 {{{2.1, 0.05}, {2.9}}, true},
                 {{{1}, {40, 2}}, true},
                 {{{5}}, true},
                 {{{0}}, true},
                 {{{3}, {12, 2}}, false},
                 {{{100}, {101}, {INFINITY}}, false},
                 {{{1e-9}, {1e9}}, true}};
    for (const auto &c : cases) {
        const PlotScale scale({"x", "", c.logarithmic}, c.values);
        CHECK(scale.low() < scale.high());
        for (const Measured &m : c.values) {
            CHECK(scale.share(m.value) > 0);
            CHECK(scale.share(m.value) < 1);
            if (!std::isfinite(m.value)) CHECK(scale.share(m.value) > 0.8);
        }
        CHECK(scale.tics().size() >= 1);
        CHECK(scale.tics().size() <= 10);
        for (const auto &[label, value] : scale.tics()) {
            CHECK(!label.empty());
            CHECK((value >= scale.low() && value <= scale.high()));
        }
    }
    CHECK(powerOfTen(-2) == "0.01");
    CHECK(powerOfTen(-12) == "10⁻¹²");
}

TEST_CASE("chart: no label of a crowded plot lies on another or on a point", "[chart]") {
    std::vector<Point> points;
    for (int i = 0; i < 40; ++i) {
        points.push_back(at("s", 1 + 0.2 * (i % 7), 1 + 0.3 * (i % 11)));
        points.back().label = "level " + std::to_string(i);
    }
    const Panel panel = panelOf(points);
    std::vector<Measured> xs;
    std::vector<Measured> ys;
    for (const Point &p : points) {
        xs.push_back(p.x);
        ys.push_back(p.y);
    }
    const PlotScale x(panel.x, xs);
    const PlotScale y(panel.y, ys);
    const PlotArea area{400, 400, 0.2, 0.95, 0.2, 0.95};
    const auto labels = placeLabels(panel, paretoFront(points), area, x, y);
    CHECK(labels.size() >= 5);
    CHECK(labels.size() < points.size());
    const auto half = [](const PlotLabel &l) { return 3.2 * static_cast<double>(l.text.size()); };
    for (std::size_t i = 0; i < labels.size(); ++i) {
        const double px = labels[i].x * area.width;
        const double py = labels[i].y * area.height;
        for (std::size_t j = 0; j < i; ++j) {
            const bool apart = std::fabs(px - labels[j].x * area.width) >= half(labels[i]) + half(labels[j]) ||
                               std::fabs(py - labels[j].y * area.height) >= 12;
            CHECK(apart);
        }
        for (const Point &p : points) {
            const double mx = area.width * (0.2 + 0.75 * x.share(p.x.value));
            const double my = area.height * (0.2 + 0.75 * y.share(p.y.value));
            const bool apart = std::fabs(px - mx) >= half(labels[i]) + 5 || std::fabs(py - my) >= 11;
            CHECK(apart);
        }
    }
}

TEST_CASE("chart: plots are drawn, what is not finite is hatched, and the page needs nothing else", "[chart]") {
    if (!hasGnuplot()) return;
    const fs::path folder = freshFolder("chart it's drawn"); // a name that has to be quoted
    Chart chart = chartOf(panelOf({at("it's", 1, 1e-7, true, 0.1), at("b", 2, 0), at("c", 3, INFINITY)}));
    chart.maps = {mapOf(1e-5), mapOf(INFINITY)};
    chart.maps[1].name = "holes";
    chart.tables = {{"rows", "A table", {"a", "b & c"}, {{"1", "2"}, {"3", "4"}}}};
    CHECK(markdownOf(chart.tables[0]) == "| a | b & c |\n| --- | --- |\n| 1 | 2 |\n| 3 | 4 |\n");
    const Section section = draw(chart, folder);
    for (const char *name : {"test_made_up.svg", "test_made_up.png", "test_map.svg", "test_map.png", "test_holes.svg"})
        CHECK(fs::file_size(folder / name) > 1000);
    CHECK(namesIn(folder.string()).size() == 6);
    for (const std::string &svg : {section.panels[0].wide, section.panels[0].narrow}) {
        for (const char *text : {">time [ns]<", ">error<", ">it's<", ">Pareto front<", ">default<", ">∞<", ">0<"})
            CHECK(svg.find(text) != std::string::npos);
        CHECK(svg.find("<svg") != std::string::npos);
    }
    CHECK(count(section.maps[0].wide, "url(#gpPat") < count(section.maps[1].wide, "url(#gpPat"));
    const std::string page = reportPage({section}, Effort::Quick, "a <machine>", "today");
    CHECK(page.find("A test &amp; more") != std::string::npos);
    CHECK(page.find("a &lt;machine&gt;") != std::string::npos);
    CHECK(page.find("<th>b &amp; c</th>") != std::string::npos);
    // Whatever the page loads is in it.
    const std::regex address(R"re((src|srcset|href)="([^"]{0,40}))re");
    int found = 0;
    for (std::sregex_iterator it(page.begin(), page.end(), address), end; it != end; ++it, ++found) {
        const std::string target = (*it)[2];
        CHECK((target.rfind("data:image/", 0) == 0 || target.rfind("#", 0) == 0));
    }
    CHECK(found >= 5);
    CHECK(page.find("<script") == std::string::npos);
    CHECK(page.find("url(") == std::string::npos);
}

TEST_CASE("chart: what measures is a program of its own, beside the command", "[chart]") {
    const CommandResult help = runTaut({"chart", "--help"});
    CHECK(help.exitCode == 0);
    CHECK_THAT(help.out, Catch::Contains("Usage: taut chart") && Catch::Contains("microgeometry: ") && Catch::Contains("--against"));
    CHECK_THAT(runTaut({"--help"}).out, Catch::Contains("chart "));
    CHECK_THAT(errorLine(runTaut({"chart", "--quick", "--", "precison"})), Catch::Contains("did you mean 'precision'?"));
    const std::string folder = freshFolder("chart_alone");
    std::filesystem::copy_file(TAUT_COMMAND, folder + "/taut");
    const CommandResult alone = runProgram({folder + "/taut", "chart", "precision"}, 60);
    CHECK(alone.exitCode == 1);
    CHECK_THAT(errorLine(alone), Catch::Contains(folder + "/taut_charts"));
}

TEST_CASE("chart: bad usage is one line and exit code 2", "[chart]") {
    const std::string folder = freshFolder("chart_usage");
    CommandResult result = runTaut({"chart", "precison", "-o", folder + "/report"});
    CHECK(result.exitCode == 2);
    CHECK(errorLine(result).find("did you mean 'precision'?") != std::string::npos);
    result = runProgram({"env", "PATH=" + folder, TAUT_COMMAND, "chart", "all", "-o", folder + "/report"}, 60);
    CHECK(result.exitCode == 2);
    CHECK(errorLine(result).find("gnuplot-nox") != std::string::npos);
    CHECK(runTaut({"chart"}).exitCode == 2);
    result = runTaut({"chart", "precision", "--ful"});
    CHECK(result.exitCode == 2);
    CHECK(errorLine(result).find("did you mean '--full'?") != std::string::npos);
    CHECK(runTaut({"chart", "precision", "--quick", "--full"}).exitCode == 2);
    CHECK(runTaut({"chart", "precision", "--against", folder + "/none"}).exitCode == 2);
    CHECK(namesIn(folder).empty());
}
