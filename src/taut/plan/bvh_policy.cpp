#include "taut/plan/bvh_policy.h"

#include "taut/base/parallel.h"

#include <tbb/parallel_reduce.h>
#include <tbb/parallel_sort.h>

#include <algorithm>

namespace taut {

namespace {

/// Triangles a cluster: a few of Embree's leaves.
constexpr std::size_t kCluster = 16;
/// Meshes above this are judged by every so many-th cluster.
constexpr std::size_t kMostClusters = 4096;

std::uint64_t spread(std::uint32_t x) {
    std::uint64_t v = x & 0x1fffffU;
    v = (v | v << 32U) & 0x1f00000000ffffULL;
    v = (v | v << 16U) & 0x1f0000ff0000ffULL;
    v = (v | v << 8U) & 0x100f00f00f00f00fULL;
    v = (v | v << 4U) & 0x10c30c30c30c30c3ULL;
    return (v | v << 2U) & 0x1249249249249249ULL;
}

/// Sum over clusters of box surface over sum of triangle areas.
double boxesOverTriangles(const std::vector<Index> &order, std::span<const Index3> triangles, std::span<const Vec3> positions) {
    double boxes = 0;
    double areas = 0;
    for (std::size_t begin = 0; begin < order.size(); begin += kCluster) {
        Vec3 lower(kInfinity);
        Vec3 upper(-kInfinity);
        for (std::size_t i = begin; i < std::min(order.size(), begin + kCluster); ++i) {
            const Index3 &t = triangles[order[i]];
            const Vec3 &a = positions[t.x];
            const Vec3 &b = positions[t.y];
            const Vec3 &d = positions[t.z];
            lower = glm::min(lower, glm::min(a, glm::min(b, d)));
            upper = glm::max(upper, glm::max(a, glm::max(b, d)));
            areas += 0.5 * static_cast<double>(glm::length(glm::cross(b - a, d - a)));
        }
        const DVec3 e(upper - lower);
        boxes += e.x * e.y + e.y * e.z + e.z * e.x;
    }
    return areas > 0 ? boxes / areas : 0;
}

} // namespace

void BvhPolicy::built(std::span<const Index3> triangles, std::span<const Vec3> positions) {
    Vec3 lower(kInfinity);
    Vec3 upper(-kInfinity);
    for (const Vec3 &p : positions.first(positions.size() - 1)) {
        lower = glm::min(lower, p);
        upper = glm::max(upper, p);
    }
    const Vec3 extent = glm::max(upper - lower, Vec3(1e-30F));
    const Vec3 scale = Vec3(static_cast<float>((1 << 21) - 1)) / extent;
    std::vector<std::pair<std::uint64_t, Index>> keys(triangles.size());
    parallelFor(keys.size(), 4096, [&](std::size_t i) {
        const Index3 &t = triangles[i];
        const Vec3 centre = (positions[t.x] + positions[t.y] + positions[t.z]) / 3.0F;
        const Vec3 at = glm::clamp((centre - lower) * scale, Vec3(0), Vec3(2097151.0F));
        const std::uint64_t code = spread(static_cast<std::uint32_t>(at.x)) | spread(static_cast<std::uint32_t>(at.y)) << 1U |
                                   spread(static_cast<std::uint32_t>(at.z)) << 2U;
        keys[i] = {code, static_cast<Index>(i)};
    });
    tbb::parallel_sort(keys.begin(), keys.end());
    const std::size_t clusters = (keys.size() + kCluster - 1) / kCluster;
    const std::size_t stride = std::max<std::size_t>(1, clusters / kMostClusters);
    order_.clear();
    order_.reserve(std::min(keys.size(), ((clusters + stride - 1) / stride) * kCluster));
    for (std::size_t c = 0; c < clusters; c += stride)
        for (std::size_t i = c * kCluster; i < std::min(keys.size(), (c + 1) * kCluster); ++i) order_.push_back(keys[i].second);
    fresh_ = boxesOverTriangles(order_, triangles, positions);
}

double BvhPolicy::growth(std::span<const Index3> triangles, std::span<const Vec3> positions) const {
    return fresh_ > 0 ? boxesOverTriangles(order_, triangles, positions) / fresh_ : 1;
}

double BvhPolicy::refitSeconds(std::span<const Index3> triangles, std::span<const Vec3> positions, double rays,
                               const BvhCosts &costs) const {
    return costs.refit * static_cast<double>(triangles.size()) +
           costs.slowdown * std::max(0.0, growth(triangles, positions) - 1) * rays * costs.ray;
}

} // namespace taut
