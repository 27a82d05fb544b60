#include "taut/scene/upright.h"

#include "taut/mesh/topology.h"
#include "taut/scene/object_motion.h"

#include <algorithm>
#include <limits>

namespace taut {

namespace {

constexpr double kLowest = 0.04;     ///< radii: what is not higher than that above the lowest point is stood on
constexpr double kClearlyMore = 0.1; ///< firmness: less is no reason to turn a mesh

double cross(const DVec2 &o, const DVec2 &a, const DVec2 &b) {
    return (a.x - o.x) * (b.y - o.y) - (a.y - o.y) * (b.x - o.x);
}

/// Counter-clockwise (A. M. Andrew, 1979); fewer than three points where all lie on a line.
std::vector<DVec2> convexHull(std::vector<DVec2> points) {
    std::sort(points.begin(), points.end(), [](const DVec2 &a, const DVec2 &b) { return a.x < b.x || (a.x == b.x && a.y < b.y); });
    std::vector<DVec2> hull;
    for (const bool upper : {false, true}) {
        const std::size_t first = hull.size();
        for (const DVec2 &p : points) {
            while (hull.size() >= first + 2 && cross(hull[hull.size() - 2], hull.back(), p) <= 0) hull.pop_back();
            hull.push_back(p);
        }
        hull.pop_back(); // the other half begins with it
        if (!upper) std::reverse(points.begin(), points.end());
    }
    return hull;
}

/// The mean of a surface's points.
DVec3 middleOf(const Mesh &mesh, const std::vector<Vec3> &positions) {
    DVec3 sum(0);
    double whole = 0;
    for (std::size_t face = 0; face < mesh.faceCount(); ++face) {
        const auto at = [&](std::size_t corner) { return DVec3(positions[mesh.cornerPositions[corner]]); };
        const DVec3 a = at(mesh.faceOffsets[face]);
        for (std::size_t corner = mesh.faceOffsets[face] + 1; corner + 1 < mesh.faceOffsets[face + 1]; ++corner) {
            const DVec3 b = at(corner), c = at(corner + 1);
            const double area = glm::length(glm::cross(b - a, c - a));
            sum += area * (a + b + c) / 3.0;
            whole += area;
        }
    }
    return whole > 0 ? sum / whole : sum;
}

} // namespace

double firmness(const Object &object, double frame, double fps) {
    ObjectMotion motion;
    motionAtFrame(object, frame, fps, DMat4(1), motion);
    std::vector<Vec3> positions;
    evaluatePositions(motion.state, object.mesh->skin, positions);
    const std::vector<Vec3> seen = pointsOfFaces(*object.mesh, positions);
    const Bounds bounds = boundsOf(seen);
    const double radius = bounds.empty() ? 0 : 0.5 * glm::length(DVec3(bounds.upper) - DVec3(bounds.lower));
    if (!(radius > 0)) return -1;
    std::vector<DVec2> lowest;
    for (const Vec3 &p : seen)
        if (isFinite(p) && static_cast<double>(p.z - bounds.lower.z) < kLowest * radius) lowest.emplace_back(p.x, p.y);
    const std::vector<DVec2> hull = convexHull(std::move(lowest));
    if (hull.size() < 3) return -1;
    const DVec2 middle(middleOf(*object.mesh, positions));
    double inside = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < hull.size(); ++i) {
        const DVec2 &a = hull[i], &b = hull[(i + 1) % hull.size()];
        inside = std::min(inside, cross(a, b, middle) / glm::length(b - a));
    }
    return std::isfinite(inside) ? inside / radius : -1;
}

bool standsWithYUp(const Object &object, double frame, double fps) {
    const double asItIs = firmness(object, frame, fps);
    if (asItIs >= 0) return false;
    Object turned = object;
    turned.placement.worldFromUp = kWorldFromYUp;
    return firmness(turned, frame, fps) > asItIs + kClearlyMore;
}

} // namespace taut
