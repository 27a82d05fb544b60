#include "study/drawing/plot_labels.h"

#include <algorithm>
#include <cmath>

namespace taut::chart {

namespace {

struct Box {
    double x, y, halfWidth, halfHeight; // pixels
    [[nodiscard]] bool overlaps(const Box &other) const {
        return std::fabs(x - other.x) < halfWidth + other.halfWidth && std::fabs(y - other.y) < halfHeight + other.halfHeight;
    }
};

const std::string &textOf(const Point &p) {
    return p.note.empty() ? p.label : p.note;
}

constexpr double kMark = 7;        ///< half a mark
constexpr double kRing = 12;       ///< half of a default's
constexpr double kCharacter = 6.8; ///< of an 11 pixel font, wide ones
constexpr double kHalfHeight = 7;

} // namespace

std::size_t lengthOf(const std::string &text) {
    return static_cast<std::size_t>(
        std::count_if(text.begin(), text.end(), [](char c) { return (static_cast<unsigned char>(c) & 0xC0U) != 0x80U; }));
}

std::vector<PlotLabel> placeLabels(const Panel &panel, const std::vector<std::size_t> &front, const PlotArea &area, const PlotScale &x,
                                   const PlotScale &y) {
    const auto across = [&](double value) { return area.width * (area.left + (area.right - area.left) * x.share(value)); };
    const auto upwards = [&](double value) { return area.height * (area.bottom + (area.top - area.bottom) * y.share(value)); };
    std::vector<Box> taken;
    for (const Point &p : panel.points) {
        const double half = p.isDefault ? kRing : kMark;
        taken.push_back({across(p.x.value), upwards(p.y.value), half, half});
    }
    for (std::size_t i = 0; i < panel.points.size(); ++i) { // bars of spread
        const Point &p = panel.points[i];
        const Box mark = taken[i];
        if (p.x.spread > 0) {
            const double left = across(p.x.value - p.x.spread);
            const double right = across(p.x.value + p.x.spread);
            taken.push_back({(left + right) / 2, mark.y, (right - left) / 2 + 2, 4});
        }
        if (p.y.spread > 0) {
            const double low = upwards(p.y.value - p.y.spread);
            const double high = upwards(p.y.value + p.y.spread);
            taken.push_back({mark.x, (low + high) / 2, 4, (high - low) / 2 + 2});
        }
    }
    if (panel.joined) // lines, by boxes along them
        for (std::size_t i = 0; i < panel.points.size(); ++i)
            for (std::size_t j = i + 1; j < panel.points.size(); ++j) {
                if (panel.points[j].series != panel.points[i].series) continue;
                constexpr int kParts = 24;
                for (int k = 1; k < kParts; ++k) {
                    const double t = static_cast<double>(k) / kParts;
                    taken.push_back({taken[i].x + t * (taken[j].x - taken[i].x), taken[i].y + t * (taken[j].y - taken[i].y), 2, 2});
                }
                break;
            }
    // The front's steps: across at one point's error, then down to the next.
    for (std::size_t i = 0; i + 1 < front.size(); ++i) {
        const Box a = taken[front[i]];
        const Box b = taken[front[i + 1]];
        taken.push_back({(a.x + b.x) / 2, a.y, std::fabs(b.x - a.x) / 2, 1});
        taken.push_back({b.x, (a.y + b.y) / 2, 1, std::fabs(b.y - a.y) / 2});
    }
    if (!front.empty()) {
        const Box first = taken[front.front()];
        const Box last = taken[front.back()];
        taken.push_back({first.x, (first.y + area.height * area.top) / 2, 1, (area.height * area.top - first.y) / 2});
        taken.push_back({(last.x + area.width * area.right) / 2, last.y, (area.width * area.right - last.x) / 2, 1});
    }
    std::vector<std::size_t> order;
    const auto wanted = [&](std::size_t i) { return panel.points[i].isDefault || std::find(front.begin(), front.end(), i) != front.end(); };
    for (const bool first : {true, false})
        for (std::size_t i = 0; i < panel.points.size(); ++i)
            if (wanted(i) == first && !textOf(panel.points[i]).empty()) order.push_back(i);

    std::vector<PlotLabel> labels;
    for (const std::size_t i : order) {
        const Box point = taken[i];
        const double half = kCharacter * static_cast<double>(lengthOf(textOf(panel.points[i]))) / 2;
        const double aside = half + point.halfWidth + 3;
        const double above = kHalfHeight + point.halfHeight + 2;
        std::vector<Box> places;
        const auto add = [&](double dx, double dy) { places.push_back({point.x + dx, point.y + dy, half, kHalfHeight}); };
        add(aside, 0);
        add(-aside, 0);
        for (const double far : {1.0, 1.7}) {
            add(0, far * above);
            add(0, -far * above);
            add(aside, far * above);
            add(-aside, far * above);
            add(aside, -far * above);
            add(-aside, -far * above);
        }
        for (const Box &place : places) {
            const bool inside = place.x - half > area.width * area.left && place.x + half < area.width * area.right &&
                                place.y - kHalfHeight > area.height * area.bottom && place.y + kHalfHeight < area.height * area.top;
            if (!inside || std::any_of(taken.begin(), taken.end(), [&](const Box &other) { return place.overlaps(other); })) continue;
            taken.push_back(place);
            labels.push_back({textOf(panel.points[i]), place.x / area.width, place.y / area.height});
            break;
        }
    }
    return labels;
}

} // namespace taut::chart
