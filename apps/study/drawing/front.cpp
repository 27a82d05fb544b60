#include "study/drawing/front.h"

#include "study/text.h"

#include <algorithm>
#include <cmath>

namespace taut::chart {

namespace {

bool beats(const Point &a, const Point &b) {
    const bool noWorse = a.x.value <= b.x.value && a.y.value <= b.y.value;
    return noWorse && (a.x.value < b.x.value || a.y.value < b.y.value);
}

/// By more than both spreads.
bool less(const Measured &a, const Measured &b) {
    return a.value + a.spread + b.spread < b.value;
}

/// A choice as good as the spreads of both let it be.
Point favoured(const Point &chosen, const Point &other) {
    Point best = chosen;
    best.x.value -= chosen.x.spread + other.x.spread;
    best.y.value -= chosen.y.spread + other.y.spread;
    return best;
}

std::string nameOf(const Point &p) {
    return p.label.empty() ? p.series : p.series + " (" + p.label + ")";
}

std::string numbersOf(const Panel &panel, const Point &p) {
    return printed("%.4g +- %.2g %s, %.4g +- %.2g %s", p.x.value, p.x.spread, panel.x.unit.c_str(), p.y.value, p.y.spread,
                   panel.y.unit.c_str());
}

} // namespace

std::vector<std::size_t> paretoFront(const std::vector<Point> &points) {
    std::vector<std::size_t> front;
    for (std::size_t i = 0; i < points.size(); ++i) {
        if (std::isnan(points[i].x.value) || std::isnan(points[i].y.value)) continue;
        const bool beaten = std::any_of(points.begin(), points.end(), [&](const Point &other) { return beats(other, points[i]); });
        if (!beaten) front.push_back(i);
    }
    std::sort(front.begin(), front.end(), [&](std::size_t a, std::size_t b) {
        return points[a].x.value < points[b].x.value || (points[a].x.value == points[b].x.value && points[a].y.value < points[b].y.value);
    });
    return front;
}

std::vector<std::string> checkDefaults(const Chart &chart) {
    std::vector<std::string> off;
    for (const Panel &panel : chart.panels) {
        if (!panel.hasFront) continue;
        for (const Point &chosen : panel.points) {
            if (!chosen.isDefault) continue;
            for (const Point &other : panel.points) {
                if (!beats(other, favoured(chosen, other))) continue;
                off.push_back(chart.name + "/" + panel.name + ": the default " + nameOf(chosen) + " (" + numbersOf(panel, chosen) +
                              ") is off the front: " + nameOf(other) + " has " + numbersOf(panel, other));
            }
        }
    }
    return off;
}

Panel beside(Panel panel, const Panel &earlier) {
    for (Point point : earlier.points) {
        point.series += ", before";
        point.isDefault = false;
        panel.points.push_back(std::move(point));
    }
    return panel;
}

Ranking compareRankings(const Panel &first, const Panel &second) {
    Ranking ranking;
    const auto find = [&](const Point &p) {
        return std::find_if(second.points.begin(), second.points.end(),
                            [&](const Point &q) { return q.series == p.series && q.label == p.label; });
    };
    const auto compare = [&](const Point &a, const Point &b, const Point &a2, const Point &b2, Measured Point::*axis,
                             const std::string &name) {
        const int before = less(a.*axis, b.*axis) ? -1 : less(b.*axis, a.*axis) ? 1 : 0;
        const int after = less(a2.*axis, b2.*axis) ? -1 : less(b2.*axis, a2.*axis) ? 1 : 0;
        if (before == 0 || after == 0) return;
        ++ranking.pairs;
        if (before != after) ranking.turned.push_back(first.name + ": " + nameOf(a) + " and " + nameOf(b) + " change places in " + name);
    };
    for (std::size_t i = 0; i < first.points.size(); ++i)
        for (std::size_t j = i + 1; j < first.points.size(); ++j) {
            const auto a = find(first.points[i]);
            const auto b = find(first.points[j]);
            if (a == second.points.end() || b == second.points.end()) continue;
            compare(first.points[i], first.points[j], *a, *b, &Point::x, first.x.name);
            compare(first.points[i], first.points[j], *a, *b, &Point::y, first.y.name);
        }
    return ranking;
}

} // namespace taut::chart
