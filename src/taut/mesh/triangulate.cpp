#include "taut/mesh/triangulate.h"

#include "taut/base/frame.h"

#include <algorithm>
#include <cmath>
#include <queue>

namespace taut {

namespace {

/// Twice the signed area of a triangle as seen along `normal`.
float signedArea(const Vec3 &a, const Vec3 &b, const Vec3 &c, const Vec3 &normal) {
    return glm::dot(glm::cross(b - a, c - a), normal);
}

bool inside(const Vec3 &p, const Vec3 &a, const Vec3 &b, const Vec3 &c, const Vec3 &normal) {
    return signedArea(a, b, p, normal) >= 0 && signedArea(b, c, p, normal) >= 0 && signedArea(c, a, p, normal) >= 0;
}

void triangulateQuad(std::span<const Vec3> p, const Vec3 &normal, std::vector<Index3> &triangles) {
    const float across02 = std::fmin(signedArea(p[0], p[1], p[2], normal), signedArea(p[0], p[2], p[3], normal));
    const float across13 = std::fmin(signedArea(p[1], p[2], p[3], normal), signedArea(p[1], p[3], p[0], normal));
    const Vec3 d02 = p[2] - p[0];
    const Vec3 d13 = p[3] - p[1];
    const bool bothConvex = across02 > 0 && across13 > 0;
    const bool split02 = bothConvex ? glm::dot(d02, d02) <= glm::dot(d13, d13) : across02 >= across13;
    if (split02) {
        triangles.emplace_back(0, 1, 2);
        triangles.emplace_back(0, 2, 3);
    } else {
        triangles.emplace_back(0, 1, 3);
        triangles.emplace_back(1, 2, 3);
    }
}

/// The corners that are left of a polygon, by place across its normal: a square of cells with about one corner each.
class CornerGrid {
  public:
    CornerGrid(std::span<const Vec3> points, const Vec3 &normal) {
        const float length = glm::length(normal);
        const Frame frame = smoothFrameFromNormal(length > 0 && length < kInfinity ? normal / length : Vec3(0, 0, 1));
        for (const Vec3 &p : points) {
            places_.emplace_back(frame.toLocal(p - points[0]));
            lower_ = glm::min(lower_, places_.back());
            upper_ = glm::max(upper_, places_.back());
        }
        side_ = static_cast<int>(std::sqrt(static_cast<double>(points.size())));
        // What rounding may move a corner by is added to every box that is looked through.
        margin_ = 1e-5F * (upper_ - lower_);
        cells_.resize(static_cast<std::size_t>(side_) * static_cast<std::size_t>(side_));
        for (Index i = 0; i < points.size(); ++i) {
            std::vector<Index> &cell = cellOf(places_[i]);
            slots_.push_back(static_cast<Index>(cell.size()));
            cell.push_back(i);
        }
    }

    void remove(Index corner) {
        std::vector<Index> &cell = cellOf(places_[corner]);
        const Index last = cell.back();
        cell[slots_[corner]] = last;
        slots_[last] = slots_[corner];
        cell.pop_back();
    }

    /// Corners and cells that were looked at, and what it costs to look at all.
    [[nodiscard]] std::size_t steps() const { return steps_; }

    /// A corner in the cells around a triangle for which f holds; kNone where there is none.
    template <class F> [[nodiscard]] Index find(const Index3 &triangle, const F &f) {
        const Vec2 &a = places_[triangle.x];
        const Vec2 &b = places_[triangle.y];
        const Vec2 &c = places_[triangle.z];
        const glm::ivec2 first = cellAt(glm::min(glm::min(a, b), c) - margin_);
        const glm::ivec2 last = cellAt(glm::max(glm::max(a, b), c) + margin_);
        steps_ += kStepsOfLook;
        for (int y = first.y; y <= last.y; ++y)
            for (int x = first.x; x <= last.x; ++x)
                for (const Index corner : cells_[static_cast<std::size_t>(y * side_ + x)]) {
                    ++steps_;
                    if (f(corner)) return corner;
                }
        steps_ += static_cast<std::size_t>(last.x - first.x + 1) * static_cast<std::size_t>(last.y - first.y + 1);
        return kNone;
    }

  private:
    [[nodiscard]] glm::ivec2 cellAt(const Vec2 &place) const {
        glm::ivec2 cell;
        for (int axis = 0; axis < 2; ++axis) { // fmin and fmax: a size of nothing is not a number
            const float along = (place[axis] - lower_[axis]) / (upper_[axis] - lower_[axis]) * static_cast<float>(side_);
            cell[axis] = static_cast<int>(std::fmin(std::fmax(along, 0.0F), static_cast<float>(side_ - 1)));
        }
        return cell;
    }
    std::vector<Index> &cellOf(const Vec2 &place) {
        const glm::ivec2 at = cellAt(place);
        return cells_[static_cast<std::size_t>(at.y * side_ + at.x)];
    }

    /// An ear that is blocked at once still goes through the heap.
    static constexpr std::size_t kStepsOfLook = 64;

    std::vector<Vec2> places_;
    Vec2 lower_{kInfinity};
    Vec2 upper_{-kInfinity};
    Vec2 margin_{0};
    int side_ = 1;
    std::vector<std::vector<Index>> cells_;
    std::vector<Index> slots_; ///< [corners] place in their cells
    std::size_t steps_ = 0;
};

/// Cuts ears off a polygon, the largest among the valid ones first, in n log n: ears stand in a heap; one with a corner inside waits
/// for that corner to be cut off.
class EarClipper {
  public:
    EarClipper(std::span<const Vec3> points, const Vec3 &normal) : points_(points), normal_(normal), grid_(points, normal) {
        const auto count = static_cast<Index>(points.size());
        for (Index i = 0; i < count; ++i) links_.push_back({(i + count - 1) % count, (i + 1) % count});
        area_.resize(count);
        waiting_.resize(count);
        for (Index i = 0; i < count; ++i) measure(i);
    }

    void run(std::vector<Index3> &triangles) {
        Index first = 0; // the first that is left
        for (std::size_t left = points_.size(); left > 3; --left) {
            const Index ear = nextEar(first);
            const auto [before, after] = links_[ear];
            triangles.emplace_back(before, ear, after);
            links_[before].after = after;
            links_[after].before = before;
            links_[ear] = {kNone, kNone};
            while (isCut(first)) ++first;
            grid_.remove(ear);
            measure(before);
            measure(after);
            for (const Index freed : waiting_[ear])
                if (!isCut(freed)) measure(freed);
        }
        const Index second = links_[first].after;
        triangles.emplace_back(first, second, links_[second].after);
    }

  private:
    struct Links {
        Index before, after;
    };
    struct Ear {
        float area;
        Index corner;
        /// Of equal ears the first corner's.
        bool operator<(const Ear &other) const { return area != other.area ? area < other.area : corner > other.corner; }
    };

    [[nodiscard]] bool isCut(Index corner) const { return links_[corner].before == kNone; }

    void measure(Index corner) {
        const auto [before, after] = links_[corner];
        area_[corner] = signedArea(points_[before], points_[corner], points_[after], normal_);
        if (area_[corner] > 0) ears_.push({area_[corner], corner});
    }

    /// The largest valid ear; where none is valid (a self-crossing polygon) any will do. A polygon that comes back to few places again
    /// and again has all corners in each other's way: after so many steps ears are taken as they come.
    Index nextEar(Index any) {
        const std::size_t mostSteps = 50'000'000 + 256 * points_.size(); // four looks at every corner, and some more
        while (!ears_.empty()) {
            const auto [area, corner] = ears_.top();
            ears_.pop();
            if (isCut(corner) || area != area_[corner]) continue; // measured anew since
            const auto [before, after] = links_[corner];
            const auto blocks = [&, before = before, after = after, corner = corner](Index other) {
                return other != before && other != corner && other != after &&
                       inside(points_[other], points_[before], points_[corner], points_[after], normal_);
            };
            const Index blocking = grid_.steps() < mostSteps ? grid_.find({before, corner, after}, blocks) : kNone;
            if (blocking == kNone) return corner;
            waiting_[blocking].push_back(corner);
        }
        return any;
    }

    std::span<const Vec3> points_;
    Vec3 normal_;
    CornerGrid grid_;
    std::vector<Links> links_;
    std::vector<float> area_;
    std::vector<std::vector<Index>> waiting_; ///< [corners]: ears that it lies in
    std::priority_queue<Ear> ears_;
};

} // namespace

Vec3 polygonNormal(std::span<const Vec3> points) {
    Vec3 normal(0);
    for (std::size_t i = 1; i + 1 < points.size(); ++i) normal += glm::cross(points[i] - points[0], points[i + 1] - points[0]);
    return normal;
}

void triangulate(std::span<const Vec3> points, std::vector<Index3> &triangles) {
    if (points.size() < 3) return;
    if (points.size() == 3) {
        triangles.emplace_back(0, 1, 2);
        return;
    }
    const Vec3 normal = polygonNormal(points);
    if (points.size() == 4) {
        triangulateQuad(points, normal, triangles);
        return;
    }
    EarClipper(points, normal).run(triangles);
}

} // namespace taut
