#include "taut/deform/face_gradient.h"

#include "taut/base/parallel.h"

namespace taut {

std::vector<Vec3> restMetrics(const Surface &surface, std::span<const Vec3> restPositions) {
    std::vector<Vec3> metrics(surface.triangles.size(), Vec3(0));
    for (std::size_t i = 0; i < metrics.size(); ++i) {
        const Index3 &t = surface.triangles[i];
        const DVec3 a(restPositions[t.y] - restPositions[t.x]);
        const DVec3 b(restPositions[t.z] - restPositions[t.x]);
        const double aa = glm::dot(a, a);
        const double ab = glm::dot(a, b);
        const double bb = glm::dot(b, b);
        const double det = aa * bb - ab * ab;
        if (det > 1e-14 * aa * bb) metrics[i] = Vec3(DVec3(bb, -ab, aa) / det);
    }
    return metrics;
}

void faceStretches(const Surface &surface, std::span<const Vec3> metrics, std::span<const Vec3> positions,
                   std::vector<SymmetricTensor> &out) {
    if (out.size() != metrics.size()) out.resize(metrics.size());
    parallelFor(metrics.size(), kVertexGrain, [&](std::size_t i) {
        const Vec3 &g = metrics[i];
        const Index3 &t = surface.triangles[i];
        const Vec3 a = positions[t.y] - positions[t.x];
        const Vec3 b = positions[t.z] - positions[t.x];
        const Vec3 cross = glm::cross(a, b);
        const float doubleArea = glm::length(cross);
        if (g == Vec3(0)) {
            out[i] = {};
            return;
        }
        const Vec3 u = a * g.x + b * g.y;
        const Vec3 w = a * g.y + b * g.z;
        const auto s = [&](int p, int q) { return u[p] * a[q] + w[p] * b[q]; };
        const float area = doubleArea * std::sqrt(std::fmax(0.0F, g.x * g.z - g.y * g.y));
        const Vec3 n = doubleArea > 0 ? cross / doubleArea : Vec3(0, 0, 1);
        const float tau = std::sqrt(std::fmax(0.0F, s(0, 0) + s(1, 1) + s(2, 2) + 2 * area));
        if (!(tau > 0)) {
            out[i] = {Vec3(0), Vec3(0)};
            return;
        }
        const float along = std::sqrt(area) - area / tau;
        out[i].diagonal = Vec3(s(0, 0) + area, s(1, 1) + area, s(2, 2) + area) / tau + n * n * along;
        out[i].offDiagonal = {s(0, 1) / tau + n.x * n.y * along, s(0, 2) / tau + n.x * n.z * along, s(1, 2) / tau + n.y * n.z * along};
    });
}

} // namespace taut
