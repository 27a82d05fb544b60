/// Gradients of limit surfaces against closed forms: B-spline derivatives, Halstead's and Loop's tangents, affine maps.

#include "assets.h"
#include "mesh_fixtures.h"

#include "taut/deform/surface_motion.h"
#include "taut/formats/read_mesh.h"
#include "taut/mesh/weld.h"

#include <array>
#include <functional>
#include <set>

using namespace taut;
using namespace taut::test;

namespace {

struct LimitSurface {
    Mesh cage;
    Subdivision subdivision;
    Surface surface;
    SurfaceGradient gradient;
};

LimitSurface limitOf(const Mesh &cage, const SubdivisionOptions &subdivision, const std::vector<Vec3> &deformed) {
    LimitSurface l{cage, subdivide(cage, subdivision), {}, {}};
    SurfaceOptions options;
    options.limit = &l.subdivision;
    options.cage = l.cage.positions;
    l.surface = buildSurface(l.subdivision.mesh, options);
    fitGradient(l.surface, deformed, false, cage.name, l.gradient);
    return l;
}

std::vector<Vec3> mapped(const std::vector<Vec3> &points, const std::function<DVec3(const DVec3 &)> &map) {
    std::vector<Vec3> result;
    for (const Vec3 &p : points) result.emplace_back(map(DVec3(p)));
    return result;
}

/// Largest difference of the computed gradient from `expected(surface vertex, rest tangent)`, relative to the expected vector's
/// largest length; vertices where `expected` is not finite are left out.
double worstGradient(const LimitSurface &l, const std::function<DVec3(std::size_t, const DVec3 &)> &expected, std::size_t &checked) {
    double worst = 0;
    checked = 0;
    for (std::size_t s = 0; s < l.surface.normals.size(); ++s) {
        const Frame frame = l.surface.frameAt(s);
        const DVec3 e1 = expected(s, DVec3(frame.s));
        const DVec3 e2 = expected(s, DVec3(frame.t));
        if (!std::isfinite(e1.x + e2.x)) continue;
        ++checked;
        // The gradient is kept in the tangent plane of the deformed surface, where both vectors lie.
        const double size = std::max(glm::length(e1), glm::length(e2));
        worst = std::max(worst, glm::length(DVec3(l.gradient.f1[s]) - e1) / size);
        worst = std::max(worst, glm::length(DVec3(l.gradient.f2[s]) - e2) / size);
    }
    return worst;
}

const DVec3 kUnknown(std::numeric_limits<double>::quiet_NaN());

/// A smooth map that neither symmetry nor low order could get right by chance.
DVec3 bent(const DVec3 &p) {
    return {p.x + 0.2 * std::sin(0.9 * p.y) + 0.1 * p.z, 0.8 * p.y + 0.15 * p.x * p.x,
            p.z + 0.3 * std::sin(0.7 * p.x) * std::cos(0.8 * p.y)};
}

/// Tangent vectors of a cage vertex in the middle of n quads, with weights by `edge(i)` and `face(i)` of its neighbours in order.
struct Ring {
    std::vector<Index> edges, faces; ///< counter-clockwise: edge i, the corner opposite in the face between edges i and i + 1
};
Ring ringOf(const Mesh &mesh, Index v) {
    std::map<Index, std::pair<Index, Index>> next; // edge neighbour -> (following edge neighbour, opposite corner)
    for (std::size_t f = 0; f < mesh.faceCount(); ++f) {
        const Index begin = mesh.faceOffsets[f];
        const Index n = mesh.faceOffsets[f + 1] - begin;
        for (Index k = 0; k < n; ++k) {
            const auto at = [&](Index i) { return mesh.cornerPositions[begin + (k + i) % n]; };
            if (at(0) == v) next[at(1)] = {at(n - 1), at(2)};
        }
    }
    Ring ring;
    Index edge = next.begin()->first;
    for (std::size_t i = 0; i < next.size(); ++i) {
        ring.edges.push_back(edge);
        ring.faces.push_back(next.at(edge).second);
        edge = next.at(edge).first;
    }
    return ring;
}

/// Catmull-Clark (Halstead, Kass & DeRose 1993, appendix): both tangents from the ring by cosines and sines.
std::array<DVec3, 2> halsteadTangents(const Ring &ring, const std::vector<Vec3> &p) {
    const double n = static_cast<double>(ring.edges.size());
    const double step = 2 * std::acos(-1.0) / n;
    const double a = 1 + std::cos(step) + std::cos(step / 2) * std::sqrt(2 * (9 + std::cos(step)));
    std::array<DVec3, 2> t{DVec3(0), DVec3(0)};
    for (std::size_t i = 0; i < ring.edges.size(); ++i) {
        const double x = static_cast<double>(i) * step;
        const DVec3 edge(p[ring.edges[i]]);
        const DVec3 face(p[ring.faces[i]]);
        t[0] += a * std::cos(x) * edge + (std::cos(x) + std::cos(x + step)) * face;
        t[1] += a * std::sin(x) * edge + (std::sin(x) + std::sin(x + step)) * face;
    }
    return t;
}

/// Loop (Loop 1987; Hoppe et al. 1994).
std::array<DVec3, 2> loopTangents(const Ring &ring, const std::vector<Vec3> &p) {
    const double step = 2 * std::acos(-1.0) / static_cast<double>(ring.edges.size());
    std::array<DVec3, 2> t{DVec3(0), DVec3(0)};
    for (std::size_t i = 0; i < ring.edges.size(); ++i) {
        const double x = static_cast<double>(i) * step;
        t[0] += std::cos(x) * DVec3(p[ring.edges[i]]);
        t[1] += std::sin(x) * DVec3(p[ring.edges[i]]);
    }
    return t;
}

/// The image of rest tangent `e` under the map that takes tangents r to d.
DVec3 imageOf(const std::array<DVec3, 2> &r, const std::array<DVec3, 2> &d, const DVec3 &e) {
    const double g11 = glm::dot(r[0], r[0]);
    const double g12 = glm::dot(r[0], r[1]);
    const double g22 = glm::dot(r[1], r[1]);
    const double b1 = glm::dot(r[0], e);
    const double b2 = glm::dot(r[1], e);
    const double det = g11 * g22 - g12 * g12;
    return (g22 * b1 - g12 * b2) / det * d[0] + (g11 * b2 - g12 * b1) / det * d[1];
}

Mesh octahedron() {
    return meshOf({{1.1F, 0, 0}, {-1, 0.1F, 0}, {0, 1, 0}, {0.2F, -1, 0}, {0, 0, 1}, {0, 0.1F, -1.2F}},
                  {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4}, {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}});
}

} // namespace

TEST_CASE("Limit derivatives of a regular grid are the bicubic B-spline's", "[limit]") {
    const int n = 7;
    const Mesh cage = openGrid(n, [](int, int) { return 0.0F; });
    const std::vector<Vec3> deformed = mapped(cage.positions, bent);
    const auto control = [&](int i, int j) { return DVec3(deformed[static_cast<std::size_t>(j * (n + 1) + i)]); };
    using Weights = std::array<double, 4>;
    const auto basis = [](double t) {
        return Weights{(1 - t) * (1 - t) * (1 - t) / 6, (3 * t * t * t - 6 * t * t + 4) / 6, (-3 * t * t * t + 3 * t * t + 3 * t + 1) / 6,
                       t * t * t / 6};
    };
    const auto slope = [](double t) {
        return Weights{-(1 - t) * (1 - t) / 2, (3 * t * t - 4 * t) / 2, (-3 * t * t + 2 * t + 1) / 2, t * t / 2};
    };
    for (const int level : {1, 2, 3, 5}) {
        INFO("level " << level);
        const LimitSurface l = limitOf(cage, {.level = level}, deformed);
        std::size_t checked = 0;
        const double worst = worstGradient(
            l,
            [&](std::size_t s, const DVec3 &e) {
                const DVec3 p(l.subdivision.mesh.positions[l.surface.surfacePosition[s]]);
                if (std::min(p.x, p.y) < 0.9999 || std::max(p.x, p.y) > n - 0.9999) return kUnknown;
                const int i = std::clamp(static_cast<int>(std::floor(p.x + 1e-4)), 1, n - 2);
                const int j = std::clamp(static_cast<int>(std::floor(p.y + 1e-4)), 1, n - 2);
                const Weights bx = basis(p.x - i);
                const Weights by = basis(p.y - j);
                const Weights sx = slope(p.x - i);
                const Weights sy = slope(p.y - j);
                DVec3 dx(0);
                DVec3 dy(0);
                for (std::size_t b = 0; b < 4; ++b)
                    for (std::size_t a = 0; a < 4; ++a) {
                        const DVec3 c = control(i - 1 + static_cast<int>(a), j - 1 + static_cast<int>(b));
                        dx += sx[a] * by[b] * c;
                        dy += bx[a] * sy[b] * c;
                    }
                return dx * e.x + dy * e.y;
            },
            checked);
        const auto side = static_cast<std::size_t>((n - 2) * (1 << level) + 1);
        CHECK(checked == side * side);
        CHECK(worst < 3e-6 * (1 << level)); // rounding of control points over the shrinking distance of neighbours
    }
}

TEST_CASE("Limit derivatives at extraordinary vertices are Halstead's and Loop's", "[limit]") {
    const auto check = [](const Mesh &cage, SubdivisionScheme scheme, const auto &tangents) {
        const std::vector<Vec3> deformed = mapped(cage.positions, bent);
        for (int level = 1; level <= 4; ++level) {
            INFO("level " << level);
            const LimitSurface l = limitOf(cage, {.level = level, .scheme = scheme}, deformed);
            std::size_t checked = 0;
            const double worst = worstGradient(
                l,
                [&](std::size_t s, const DVec3 &e) {
                    const Index v = l.surface.surfacePosition[s];
                    if (v >= cage.positions.size()) return kUnknown; // vertices of the cage come first
                    const Ring ring = ringOf(cage, v);
                    return imageOf(tangents(ring, cage.positions), tangents(ring, deformed), e);
                },
                checked);
            CHECK(checked == cage.positions.size());
            CHECK(worst < 2e-6 * (1 << level));
        }
    };
    check(cube(), SubdivisionScheme::CatmullClark, halsteadTangents);      // valence 3
    check(torus(7, 5), SubdivisionScheme::CatmullClark, halsteadTangents); // valence 4
    // The cube refined: valences 3 and 4, and a cap of valence 5 and 6 around it would need triangles: a fan of kites.
    for (const int n : {5, 6, 9}) {
        INFO("valence " << n);
        std::vector<Vec3> points{{0, 0, 0.3F}};
        Polygons faces;
        for (int i = 0; i < 2 * n; ++i) {
            const float x = kPi * static_cast<float>(i) / static_cast<float>(n);
            points.emplace_back((1.0F + 0.1F * static_cast<float>(i % 3)) * std::cos(x), std::sin(x), 0.1F * std::cos(3 * x));
        }
        points.emplace_back(0, 0, -1);
        for (int i = 0; i < n; ++i) {
            const auto at = [&](int k) { return static_cast<Index>(1 + k % (2 * n)); };
            faces.push_back({0, at(2 * i), at(2 * i + 1), at(2 * i + 2)});
            faces.push_back({static_cast<Index>(2 * n + 1), at(2 * i + 3), at(2 * i + 2), at(2 * i + 1)});
        }
        const Mesh cage = meshOf(points, faces);
        REQUIRE(isWatertight(cage));
        check(cage, SubdivisionScheme::CatmullClark, halsteadTangents); // also doublets: valence 2 on the rim
    }
    check(octahedron(), SubdivisionScheme::Loop, loopTangents);
    check(meshOf({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}}), SubdivisionScheme::Loop,
          loopTangents);
}

TEST_CASE("An affine map of the cage is the gradient of every limit surface, creases and borders too", "[limit]") {
    const glm::dmat3 linear(1.3, 0.2, -0.4, 0.1, 0.7, 0.5, -0.6, 0.3, 1.1);
    auto all = cages();
    Mesh creased = cube();
    creased.name = "cage";
    for (const auto &[edge, uses] : directedEdges(creased))
        if (edge.first < edge.second) creased.creases.push_back({edge.first, edge.second, kInfinitelySharp});
    all.emplace_back("cube, all edges sharp", creased);
    creased.creases.resize(1);
    all.emplace_back("cube, one edge sharp", creased);
    creased.creases.front().sharpness = 1.5F;
    creased.corners = {{7, kInfinitelySharp}};
    all.emplace_back("cube, one edge semi-sharp, one corner sharp", creased);
    for (const auto &[name, cage] : all)
        for (int level = 1; level <= 3; ++level) {
            INFO(name << ", level " << level);
            const LimitSurface l =
                limitOf(cage, {.level = level}, mapped(cage.positions, [&](const DVec3 &p) { return linear * p + DVec3(3, -2, 1); }));
            CHECK(l.surface.loneVertices == 0);
            std::size_t checked = 0;
            CHECK(worstGradient(
                      l, [&](std::size_t, const DVec3 &e) { return linear * e; }, checked) < 1e-4);
            CHECK(checked > 0);
        }
}

TEST_CASE("A sharp crease has a normal and a gradient on either side", "[limit]") {
    Mesh cage = cube();
    for (const auto &[edge, uses] : directedEdges(cage))
        if (edge.first < edge.second) cage.creases.push_back({edge.first, edge.second, kInfinitelySharp});
    for (const bool byAngle : {false, true}) {
        if (byAngle) cage.creases.clear();
        const LimitSurface l = limitOf(cage, {.level = 3, .creaseAngle = byAngle ? 0.5F : kPi}, cage.positions);
        // The limit is the cube itself, and every normal is one of its six.
        std::set<std::array<int, 3>> normals;
        for (std::size_t s = 0; s < l.surface.normals.size(); ++s) {
            const Vec3 &n = l.surface.normals[s];
            CHECK(std::fabs(maxComponent(glm::abs(n)) - 1) < 1e-5F);
            normals.insert({static_cast<int>(std::lround(n.x)), static_cast<int>(std::lround(n.y)), static_cast<int>(std::lround(n.z))});
            const Vec3 &p = l.subdivision.mesh.positions[l.surface.surfacePosition[s]];
            CHECK(glm::dot(p, n) == Approx(1).epsilon(1e-5));
        }
        CHECK(normals.size() == 6);
        CHECK(l.surface.normals.size() == 6 * 81);
    }
}

TEST_CASE("Creases and corners agree with OpenSubdiv's own refinement", "[limit][assets]") {
    // Sharpness 2 is used up after three refinements: from there on the baseline is a cage without creases, and has the same limit.
    for (const char *name : {"catmark_cube_creases0", "catmark_dart_edgecorner", "catmark_tent_creases0"}) {
        const auto shape = asset(std::string("subd/shapes/") + name + ".obj");
        const auto baseline = asset(std::string("subd/baseline/") + name + "_level2.obj");
        if (!shape || !baseline) return;
        INFO(name);
        Warnings warnings;
        Mesh cage = readMesh(*shape, warnings);
        REQUIRE(!cage.creases.empty());
        const Mesh refined = readMesh(*baseline, warnings);
        const std::vector<Vec3> expected = [&] {
            const Subdivision once = subdivide(refined, {.level = 1});
            return std::vector<Vec3>(once.mesh.positions.begin(),
                                     once.mesh.positions.begin() + static_cast<std::ptrdiff_t>(refined.positions.size()));
        }();
        const auto distance = [&](const Mesh &mesh) {
            float farthest = 0;
            for (const Vec3 &p : mesh.positions) {
                float nearest = kInfinity;
                for (const Vec3 &q : expected) nearest = std::min(nearest, glm::distance(p, q));
                farthest = std::max(farthest, nearest);
            }
            return farthest;
        };
        CHECK(subdivide(cage, {.level = 3}).mesh.positions.size() == expected.size());
        CHECK(distance(subdivide(cage, {.level = 3}).mesh) < 2e-5F);
        cage.creases.clear();
        CHECK(distance(subdivide(cage, {.level = 3}).mesh) > 1e-2F);
    }
}

TEST_CASE("A cage split at its seams is welded before it is subdivided", "[limit]") {
    // A cube of 24 positions, as glTF stores one.
    const Mesh closed = cube();
    Mesh split = closed;
    split.positions.clear();
    split.cornerPositions.clear();
    for (const Index p : closed.cornerPositions) {
        split.cornerPositions.push_back(static_cast<Index>(split.positions.size()));
        split.positions.push_back(closed.positions[p]);
    }
    CHECK(subdivide(split, {.level = 2}).mesh.positions.size() == 6 * 25);
    const Subdivision s = subdivide(welded(split), {.level = 2});
    CHECK(s.mesh.faceCount() == 96);
    double largest = 0;
    for (std::size_t f = 0; f < s.mesh.cornerCount(); ++f)
        largest = std::max(largest, static_cast<double>(glm::length(s.mesh.positions[s.mesh.cornerPositions[f]])));
    CHECK(largest < 1); // the split cube keeps its corners at the square root of 3
}

TEST_CASE("Loop's scheme wants triangles", "[limit]") {
    try {
        subdivide(cube(), {.level = 1, .scheme = SubdivisionScheme::Loop});
        FAIL("quads were taken");
    } catch (const InputError &error) {
        CHECK(std::string(error.what()).find("expected triangles") != std::string::npos);
    }
}
