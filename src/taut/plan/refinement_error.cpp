#include "taut/plan/refinement_error.h"

#include "taut/deform/stretch.h"

#include <algorithm>

namespace taut {

namespace {

/// Sums over the triangles around a surface vertex, of the corners that follow and precede it.
struct Ring {
    DVec3 position{0}, normal{0}, diagonal{0}, offDiagonal{0};
    double count = 0;
    std::int64_t imbalance = 0; ///< numbers of the followers minus those of the predecessors: 0 where the ring is closed
};

/// Second difference over the ring to the error in the middle of an edge: 1/8 of a second difference along one direction, of which
/// the ring's mean holds half; doubled, as directions may cancel.
constexpr double kMiddle = 0.5;

} // namespace

void RefinementError::add(const ObjectSurface &object) {
    const Surface &surface = object.surface;
    const SurfaceGradient &g = object.gradient;
    vertices = static_cast<float>(surface.vertexCount());
    std::vector<SymmetricTensor> stretches(surface.normals.size());
    for (std::size_t v = 0; v < surface.vertexCount(); ++v) { // V is the same at all render vertices of a surface vertex
        const Index s = surface.vertexSurface[v];
        stretches[s] = polarAt(surface, g, v).stretch;
    }
    std::vector<Ring> rings(surface.normals.size());
    for (const Index3 &t : surface.triangles)
        for (int k = 0; k < 3; ++k) {
            const Index next = surface.vertexSurface[t[(k + 1) % 3]];
            const Index previous = surface.vertexSurface[t[(k + 2) % 3]];
            Ring &ring = rings[surface.vertexSurface[t[k]]];
            for (const Index s : {next, previous}) {
                ring.position += DVec3(g.position[s]);
                ring.normal += DVec3(g.normal[s]);
                ring.diagonal += DVec3(stretches[s].diagonal);
                ring.offDiagonal += DVec3(stretches[s].offDiagonal);
            }
            ring.count += 2;
            ring.imbalance += static_cast<std::int64_t>(next) - static_cast<std::int64_t>(previous);
        }
    double normals = 0;
    double tensors = 0;
    double positions = 0;
    double closed = 0;
    for (std::size_t s = 0; s < rings.size(); ++s) {
        const Ring &ring = rings[s];
        lower = glm::min(lower, g.position[s]);
        upper = glm::max(upper, g.position[s]);
        if (!(ring.count > 0) || ring.imbalance != 0) continue;
        const DVec3 n(g.normal[s]);
        const DVec3 turned = ring.normal / ring.count;
        const DVec3 sideways = turned - n * glm::dot(turned, n); // what is lost in length is restored by normalising
        normals += glm::dot(sideways, sideways);
        positions += sqr(glm::dot(ring.position / ring.count - DVec3(g.position[s]), n));
        const DVec3 d = ring.diagonal / ring.count - DVec3(stretches[s].diagonal);
        const DVec3 o = ring.offDiagonal / ring.count - DVec3(stretches[s].offDiagonal);
        // V is det over trace at least.
        const double greatest = DVec3(stretches[s].diagonal).x + DVec3(stretches[s].diagonal).y + DVec3(stretches[s].diagonal).z;
        const double area = static_cast<double>(glm::length(glm::cross(g.f1[s], g.f2[s])));
        tensors += (glm::dot(d, d) + 2 * glm::dot(o, o)) / sqr(std::max(area / std::max(greatest, 1e-20), 1e-4));
        ++closed;
    }
    if (!(closed > 0)) return;
    const auto middle = [&](double sum) { return static_cast<float>(kMiddle * std::sqrt(sum / closed)); };
    normal = std::max(normal, middle(normals));
    stretch = std::max(stretch, middle(tensors));
    position = std::max(position, middle(positions));
}

} // namespace taut
