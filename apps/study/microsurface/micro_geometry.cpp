#include "study/microsurface/micro_geometry.h"

#include "taut/base/parallel.h"
#include "taut/base/sobol.h"
#include "taut/microsurface/ggx.h"

#include <algorithm>

namespace taut {

namespace {

/// Steps of a roof's profile.
constexpr int kSteps = 8;

/// Adds roofs to a mesh.
class Builder {
  public:
    Builder(Mesh &mesh, std::uint32_t seed) : mesh_(mesh), seed_(seed) {}

    double random() { return static_cast<double>(toUnitFloat(hash(seed_, count_++))); }

    /// A roof on the triangle abc, counter-clockwise.
    void addRoof(const DVec2 &a, const DVec2 &b, const DVec2 &c) {
        const double oppositeA = glm::distance(b, c);
        const double oppositeB = glm::distance(c, a);
        const double oppositeC = glm::distance(a, b);
        const double perimeter = oppositeA + oppositeB + oppositeC;
        const DVec2 centre = (oppositeA * a + oppositeB * b + oppositeC * c) / perimeter;
        const DVec2 u = b - a;
        const DVec2 v = c - a;
        const double inradius = (u.x * v.y - u.y * v.x) / perimeter;
        const double sign = random() < 0.5 ? -1 : 1; // a pit or a peak
        // Heights of the level lines, from the rim inwards.
        double height[kSteps + 1] = {};
        for (int k = kSteps - 1; k >= 0; --k) {
            const double stratum = std::min((k + random()) / kSteps, 1 - 1e-6);
            const double slope = std::sqrt(stratum / (1 - stratum));
            height[k] = height[k + 1] + sign * slope * inradius * (scale(k + 1) - scale(k));
        }
        const auto first = static_cast<Index>(mesh_.positions.size());
        addPosition(centre, height[0]);
        for (int k = 1; k <= kSteps; ++k)
            for (const DVec2 *corner : {&a, &b, &c}) addPosition(centre + scale(k) * (*corner - centre), height[k]);
        for (Index side = 0; side < 3; ++side) {
            const Index next = (side + 1) % 3;
            addTriangle(first, first + 1 + side, first + 1 + next);
            for (Index k = 0; k + 1 < kSteps; ++k) {
                const Index inner = first + 1 + 3 * k;
                const Index outer = inner + 3;
                addTriangle(inner + side, outer + side, outer + next);
                addTriangle(inner + side, outer + next, inner + next);
            }
        }
    }

  private:
    static double scale(int k) { return std::sqrt(static_cast<double>(k) / kSteps); }
    void addPosition(const DVec2 &xy, double z) { mesh_.positions.emplace_back(DVec3(xy, z)); }
    void addTriangle(Index a, Index b, Index c) {
        mesh_.cornerPositions.insert(mesh_.cornerPositions.end(), {a, b, c});
        mesh_.faceOffsets.push_back(static_cast<Index>(mesh_.cornerPositions.size()));
    }

    Mesh &mesh_;
    std::uint32_t seed_;
    std::uint32_t count_ = 0;
};

/// A regular polygon about the origin; `turn` in corners.
struct Polygon {
    double radius, turn;
    int corners;
    [[nodiscard]] double turns(int i) const { return (i + turn) / corners; }
    [[nodiscard]] DVec2 corner(int i) const { return {radius * std::cos(kTwoPi * turns(i)), radius * std::sin(kTwoPi * turns(i))}; }
};

/// Roofs between two polygons: walks around both, always advancing the one whose next corner comes first.
void addStrip(Builder &builder, const Polygon &inner, const Polygon &outer) {
    int i = 0;
    int o = static_cast<int>(std::floor(inner.turns(0) * outer.corners - outer.turn + 0.5));
    const int end = o + outer.corners;
    while (i < inner.corners || o < end) {
        if (o < end && (i == inner.corners || outer.turns(o + 1) < inner.turns(i + 1))) {
            builder.addRoof(inner.corner(i), outer.corner(o), outer.corner(o + 1));
            ++o;
        } else {
            builder.addRoof(inner.corner(i), outer.corner(o), inner.corner(i + 1));
            ++i;
        }
    }
}

/// The polygons that cut the patch into strips, from the rim inwards. Strips between equally many corners are alike up to size; where
/// the radius has halved, so have the corners, `doublings` times, down to `fewest`. A strip looks the same after a turn by a corner of
/// its inner polygon.
std::vector<Polygon> nestedPolygons(int fewest, int doublings) {
    std::vector<Polygon> polygons{{1, 0, fewest << doublings}};
    double halved = 0.5;
    while (polygons.back().corners > fewest) {
        const Polygon &outer = polygons.back();
        const double radius = outer.radius * (1 - std::sqrt(3.0) / 2 * kTwoPi / outer.corners);
        const bool coarser = radius < halved;
        if (coarser) halved /= 2;
        polygons.push_back({radius, 0, coarser ? outer.corners / 2 : outer.corners});
    }
    return polygons;
}
std::size_t roofsBetween(const std::vector<Polygon> &polygons) {
    std::size_t roofs = 0;
    for (const Polygon &p : polygons) roofs += 2 * static_cast<std::size_t>(p.corners); // on either side of it
    return roofs - static_cast<std::size_t>(polygons.front().corners);
}

Deformer shearOf(int axis, int by, double amount) {
    Deformer shear;
    shear.keys.type = DeformerType::Shear;
    shear.keys.axis = axis;
    shear.keys.axis2 = by;
    shear.amount = amount;
    return shear;
}

} // namespace

Mesh makeGgxHeightfield(std::size_t facets, std::uint32_t seed) {
    constexpr std::size_t kFacetsPerRoof = 3 * (2 * kSteps - 1);
    // About a third of corners^2 roofs; as many corners as it takes.
    const double wanted = std::sqrt(static_cast<double>(facets) / kFacetsPerRoof * 2.5);
    int doublings = 0;
    while (wanted / (1 << doublings) > 32) ++doublings;
    int fewest = std::max(8, static_cast<int>(wanted / (1 << doublings)));
    while (roofsBetween(nestedPolygons(fewest, doublings)) * kFacetsPerRoof < facets) ++fewest;

    Mesh mesh;
    mesh.name = "ggx_heightfield";
    Builder builder(mesh, seed);
    std::vector<Polygon> polygons = nestedPolygons(fewest, doublings);
    for (Polygon &polygon : polygons) polygon.turn = builder.random();
    for (std::size_t i = 1; i < polygons.size(); ++i) addStrip(builder, polygons[i], polygons[i - 1]);
    const Polygon &innermost = polygons.back();
    for (int i = 0; i < innermost.corners; ++i) builder.addRoof(DVec2(0), innermost.corner(i), innermost.corner(i + 1));
    return mesh;
}

void deformPositions(Mesh &mesh, std::span<const Deformer> deformers) {
    parallelFor(mesh.positions.size(), 4096, [&](std::size_t i) {
        DVec3 p(mesh.positions[i]);
        for (const Deformer &deformer : deformers) p = deform(deformer, p).position;
        mesh.positions[i] = Vec3(p);
    });
}

std::vector<Deformer> deformersOf(const MicroTransform &m) {
    Deformer stretch;
    stretch.keys.type = DeformerType::Stretch;
    stretch.factor = DVec3(static_cast<double>(m.a), static_cast<double>(m.d), 1.0);
    return {stretch, shearOf(0, 1, static_cast<double>(m.b / m.d)), shearOf(0, 2, static_cast<double>(m.p)),
            shearOf(1, 2, static_cast<double>(m.q))};
}

NormalHistogram countNormals(const Mesh &mesh, int bins) {
    NormalHistogram histogram{bins, std::vector<double>(static_cast<std::size_t>(bins) * static_cast<std::size_t>(bins))};
    const auto index = [bins](double v) {
        return static_cast<std::size_t>(std::clamp(static_cast<int>((0.5 + 0.5 * v) * bins), 0, bins - 1));
    };
    double whole = 0; // overhangs count against it: the macro-surface's area
    for (std::size_t face = 0; face < mesh.faceCount(); ++face) {
        const Index *corner = &mesh.cornerPositions[mesh.faceOffsets[face]];
        const DVec3 a(mesh.positions[corner[0]]);
        const DVec3 n = glm::cross(DVec3(mesh.positions[corner[1]]) - a, DVec3(mesh.positions[corner[2]]) - a);
        whole += n.z;
        if (!(n.z > 0)) continue;
        const double inverse = 1 / glm::length(n);
        histogram.share[index(n.y * inverse) * static_cast<std::size_t>(bins) + index(n.x * inverse)] += n.z;
    }
    for (double &share : histogram.share) share /= whole;
    return histogram;
}

NormalHistogram expectedNormals(const MicroTransform &m, int bins) {
    constexpr int kNodes = 32;
    NormalHistogram histogram{bins, std::vector<double>(static_cast<std::size_t>(bins) * static_cast<std::size_t>(bins))};
    const double width = 2.0 / (bins * kNodes);
    for (int row = 0; row < bins * kNodes; ++row)
        for (int column = 0; column < bins * kNodes; ++column) {
            const double x = (column + 0.5) * width - 1;
            const double y = (row + 0.5) * width - 1;
            const double z2 = 1 - x * x - y * y;
            if (!(z2 > 0)) continue;
            // dx dy = n.z per solid angle: the density over the disk is D itself.
            const float density = ggx::distribution(m, Vec3(DVec3(x, y, std::sqrt(z2))));
            histogram.share[static_cast<std::size_t>(row / kNodes * bins + column / kNodes)] +=
                static_cast<double>(density) * width * width;
        }
    return histogram;
}

double totalVariation(const NormalHistogram &a, const NormalHistogram &b) {
    double sum = 0;
    for (std::size_t i = 0; i < a.share.size(); ++i) sum += std::fabs(a.share[i] - b.share[i]);
    return sum / 2;
}

NormalImage paintNormals(const Mesh &mesh, const MicroTransform &m, int size) {
    constexpr double kBrightest = 0.6; // leaves room for the noise of counting
    const NormalHistogram counted = countNormals(mesh, size);
    const NormalHistogram expected = expectedNormals(m, size);
    const double greatest = *std::max_element(expected.share.begin(), expected.share.end());
    const double cell = sqr(2.0 / size);
    NormalImage image{2 * size, size, static_cast<float>(cell * kBrightest / greatest), {}};
    for (int row = size - 1; row >= 0; --row)
        for (const NormalHistogram *histogram : {&counted, &expected})
            for (int column = 0; column < size; ++column) {
                const double share = histogram->share[static_cast<std::size_t>(row * size + column)];
                // Outside the disk a blue no histogram has.
                const double x = (2 * column + 1.0) / size - 1;
                const double y = (2 * row + 1.0) / size - 1;
                const Vec3 colour = x * x + y * y > 1 ? Vec3(0.02F, 0.03F, 0.08F) : Vec3(static_cast<float>(share * kBrightest / greatest));
                image.rgb.insert(image.rgb.end(), {colour.x, colour.y, colour.z});
            }
    return image;
}

} // namespace taut
