#include "taut/mesh/triangulate.h"

#include <numeric>

namespace taut {

namespace {

/// Twice the signed area of a triangle as seen along `normal`.
float signedArea(const Vec3 &a, const Vec3 &b, const Vec3 &c, const Vec3 &normal) { return glm::dot(glm::cross(b - a, c - a), normal); }

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
    std::vector<Index> left(points.size());
    std::iota(left.begin(), left.end(), Index{0});
    while (left.size() > 3) {
        // The ear with the largest area among the valid ones; where none is valid (self-crossing polygon) any will do.
        std::size_t best = 0;
        float bestArea = -kInfinity;
        for (std::size_t i = 0; i < left.size(); ++i) {
            const Index before = left[(i + left.size() - 1) % left.size()];
            const Index after = left[(i + 1) % left.size()];
            const float area = signedArea(points[before], points[left[i]], points[after], normal);
            if (area <= bestArea) continue;
            bool empty = area > 0;
            for (std::size_t k = 0; empty && k < left.size(); ++k) {
                const Index other = left[k];
                if (other != before && other != left[i] && other != after)
                    empty = !inside(points[other], points[before], points[left[i]], points[after], normal);
            }
            if (!empty) continue;
            best = i;
            bestArea = area;
        }
        triangles.emplace_back(left[(best + left.size() - 1) % left.size()], left[best], left[(best + 1) % left.size()]);
        left.erase(left.begin() + static_cast<std::ptrdiff_t>(best));
    }
    triangles.emplace_back(left[0], left[1], left[2]);
}

} // namespace taut
