#include "assets.h"
#include "mesh_fixtures.h"

#include "taut/formats/read_mesh.h"
#include "taut/mesh/subdivide.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

using namespace taut;
using namespace taut::test;

namespace {

float distanceToNearest(const Vec3 &point, const std::vector<Vec3> &points) {
    float nearest = kInfinity;
    for (const Vec3 &p : points) nearest = std::min(nearest, glm::distance(point, p));
    return nearest;
}

/// Largest distance of a point of `a` from the nearest of `b`.
float farthest(const std::vector<Vec3> &a, const std::vector<Vec3> &b) {
    float distance = 0;
    for (const Vec3 &p : a) distance = std::max(distance, distanceToNearest(p, b));
    return distance;
}

/// Limit positions of a closed quad mesh (Halstead et al. 1993, eq. 6): (n^2 v + 4 sum of edge neighbours + sum of face
/// diagonals) / (n (n + 5)). Each of the n edges at a vertex lies in two faces.
std::vector<Vec3> halsteadLimit(const Mesh &quads) {
    std::vector<Vec3> edges(quads.positions.size(), Vec3(0));
    std::vector<Vec3> diagonals(quads.positions.size(), Vec3(0));
    std::vector<float> valence(quads.positions.size(), 0);
    for (std::size_t f = 0; f < quads.faceCount(); ++f) {
        REQUIRE(quads.faceOffsets[f + 1] - quads.faceOffsets[f] == 4);
        const auto corner = [&](Index i) { return quads.cornerPositions[quads.faceOffsets[f] + i % 4]; };
        for (Index i = 0; i < 4; ++i) {
            edges[corner(i)] += 0.5F * (quads.positions[corner(i + 1)] + quads.positions[corner(i + 3)]);
            diagonals[corner(i)] += quads.positions[corner(i + 2)];
            valence[corner(i)] += 1;
        }
    }
    std::vector<Vec3> limit;
    for (std::size_t v = 0; v < edges.size(); ++v) {
        const float n = valence[v];
        limit.push_back((n * n * quads.positions[v] + 4.0F * edges[v] + diagonals[v]) / (n * (n + 5)));
    }
    return limit;
}

double largestPartitionError(const StencilTable &table) {
    double largest = 0;
    for (std::size_t i = 0; i < table.rowCount(); ++i) {
        double sum = 0;
        for (Index k = table.offsets[i]; k < table.offsets[i + 1]; ++k) sum += table.weights[k];
        largest = std::max(largest, std::fabs(sum - 1));
    }
    return largest;
}

} // namespace

TEST_CASE("Rows of every cage are affine combinations and place the refined mesh", "[subdivide]") {
    for (const auto &[name, cage] : cages())
        for (int level = 0; level <= 3; ++level) {
            INFO(name << ", level " << level);
            const Subdivision s = subdivide(cage, {.level = level});
            CHECK(s.positions.rowCount() == s.mesh.positions.size());
            CHECK(s.positions.indices.size() == s.positions.weights.size());
            CHECK(largestPartitionError(s.positions) < 1e-6);
            CHECK(std::all_of(s.positions.indices.begin(), s.positions.indices.end(), [&](Index i) { return i < cage.positions.size(); }));
            CHECK(std::all_of(s.mesh.cornerPositions.begin(), s.mesh.cornerPositions.end(),
                              [&](Index i) { return i < s.mesh.positions.size(); }));

            // Affine invariance: subdividing the moved cage is moving the subdivided one.
            const Mat3 linear(1.3F, 0.2F, -0.4F, 0.1F, 0.7F, 0.5F, -0.6F, 0.3F, 1.1F);
            const Vec3 offset(3, -2, 1);
            std::vector<Vec3> moved = cage.positions;
            for (Vec3 &p : moved) p = linear * p + offset;
            std::vector<Vec3> refined;
            applyStencils(s.positions, moved, refined);
            float largest = 0;
            for (std::size_t v = 0; v < refined.size(); ++v)
                largest = std::max(largest, glm::distance(refined[v], linear * s.mesh.positions[v] + offset));
            CHECK(largest < 1e-5F);
        }
}

TEST_CASE("Refined counts follow V' = V + E + F, a quad a corner", "[subdivide]") {
    for (const auto &[name, cage] : cages()) {
        if (name == "a corner twice in a face") continue; // that corner is none
        INFO(name);
        const Mesh *parent = &cage;
        Subdivision s;
        Mesh previous;
        for (int level = 1; level <= 3; ++level) {
            s = subdivide(cage, {.level = level});
            CHECK(s.mesh.positions.size() == parent->positions.size() + edgeCount(*parent) + parent->faceCount());
            CHECK(s.mesh.faceCount() == parent->cornerCount());
            CHECK(s.mesh.cornerCount() == 4 * s.mesh.faceCount());
            previous = s.mesh;
            parent = &previous;
        }
    }
}

TEST_CASE("Level 0 is the cage itself with identity rows", "[subdivide]") {
    Mesh cage = cube();
    cage.normals = {{0, 0, 1}};
    cage.cornerNormals.assign(cage.cornerCount(), 0);
    cage.morphs.push_back({"smile", std::vector<Vec3>(8, Vec3(1))});
    const Subdivision s = subdivide(cage, {.level = 0});
    CHECK(s.mesh.positions == cage.positions);
    CHECK(s.mesh.faceOffsets == cage.faceOffsets);
    CHECK(s.mesh.cornerPositions == cage.cornerPositions);
    CHECK(s.mesh.cornerNormals == cage.cornerNormals);
    CHECK(s.mesh.morphs.empty());
    std::vector<Vec3> out;
    applyStencils(s.positions, cage.positions, out);
    CHECK(out == cage.positions);
}

TEST_CASE("The limit of a cube's corner lies at half its distance", "[subdivide]") {
    // Level-1 points by hand: corner 5/9, edge (3/4, 3/4, 0), face (1, 0, 0); limit mask of valence 3:
    // (9 * 5/9 + 4 * (3/4 + 3/4) + 1) / 24 = 1/2.
    const Subdivision s = subdivide(cube(), {.level = 1});
    for (int i = 0; i < 8; ++i)
        CHECK(glm::distance(s.mesh.positions[static_cast<std::size_t>(i)], 0.5F * cube().positions[static_cast<std::size_t>(i)]) < 1e-6F);
    // Face midpoint, valence 4: (16 * 1 + 4 * (4 * 3/4) + 4 * 5/9) / 36.
    CHECK(distanceToNearest(Vec3((16 + 12 + 20.0F / 9) / 36, 0, 0), s.mesh.positions) < 1e-6F);
}

TEST_CASE("A regular grid reproduces the uniform bicubic B-spline", "[subdivide]") {
    const int n = 7;
    const Mesh cage = openGrid(n, bumpy);
    const auto basis = [](double t) {
        return std::array<double, 4>{(1 - t) * (1 - t) * (1 - t) / 6, (3 * t * t * t - 6 * t * t + 4) / 6,
                                     (-3 * t * t * t + 3 * t * t + 3 * t + 1) / 6, t * t * t / 6};
    };
    for (const int level : {1, 2, 4}) {
        const Subdivision s = subdivide(cage, {.level = level});
        int checked = 0;
        for (const Vec3 &p : s.mesh.positions) {
            // In the interior x and y are the spline's parameters: equally spaced control points have linear precision.
            const int i = std::clamp(static_cast<int>(std::floor(p.x + 1e-4F)), 1, n - 2);
            const int j = std::clamp(static_cast<int>(std::floor(p.y + 1e-4F)), 1, n - 2);
            if (p.x < 0.9999F || p.y < 0.9999F || p.x > static_cast<float>(n) - 0.9999F || p.y > static_cast<float>(n) - 0.9999F) continue;
            const auto bx = basis(static_cast<double>(p.x) - i);
            const auto by = basis(static_cast<double>(p.y) - j);
            double z = 0;
            for (int b = 0; b < 4; ++b)
                for (int a = 0; a < 4; ++a)
                    z += bx[static_cast<std::size_t>(a)] * by[static_cast<std::size_t>(b)] *
                         static_cast<double>(bumpy(i - 1 + a, j - 1 + b));
            REQUIRE(std::fabs(static_cast<double>(p.z) - z) < 2e-6);
            ++checked;
        }
        const int side = (n - 2) * (1 << level) + 1;
        CHECK(checked == side * side);
    }
}

TEST_CASE("Boundaries are cubic B-spline curves and boundary corners stay", "[subdivide]") {
    const int n = 4;
    const Mesh cage = openGrid(n, bumpy);
    const Subdivision s = subdivide(cage, {.level = 2});
    for (const int i : {0, n})
        for (const int j : {0, n}) CHECK(distanceToNearest(Vec3(i, j, bumpy(i, j)), s.mesh.positions) < 1e-6F);
    // At a knot of the boundary curve: (1, 4, 1) / 6 of boundary control points alone.
    for (int i = 1; i < n; ++i)
        CHECK(distanceToNearest(Vec3(i, 0, (bumpy(i - 1, 0) + 4 * bumpy(i, 0) + bumpy(i + 1, 0)) / 6), s.mesh.positions) < 1e-6F);
    // Row 0..2^level n of the boundary uses no interior control point.
    for (std::size_t v = 0; v < s.mesh.positions.size(); ++v) {
        if (std::fabs(s.mesh.positions[v].y) > 1e-6F) continue;
        for (Index k = s.positions.offsets[v]; k < s.positions.offsets[v + 1]; ++k) CHECK(s.positions.indices[k] <= static_cast<Index>(n));
    }
}

TEST_CASE("A finer level keeps the coarser level's limit points", "[subdivide]") {
    for (const auto &[name, cage] : cages()) {
        INFO(name);
        for (int level = 1; level <= 3; ++level) {
            const Subdivision coarse = subdivide(cage, {.level = level});
            const Subdivision fine = subdivide(cage, {.level = level + 1});
            // Vertices of vertices come first in the finer level, so the same vertex has the same number.
            for (std::size_t v = 0; v < coarse.mesh.positions.size(); ++v)
                REQUIRE(glm::distance(coarse.mesh.positions[v], fine.mesh.positions[v]) < 1e-5F);
        }
    }
}

TEST_CASE("Closed cages stay closed and outward", "[subdivide]") {
    for (const Mesh &cage : {cube(), torus(9, 6)})
        for (int level = 1; level <= 3; ++level) {
            const Mesh mesh = subdivide(cage, {.level = level}).mesh;
            CHECK(isWatertight(mesh));
            CHECK(signedVolume(mesh) > 0);
            CHECK(signedVolume(mesh) < signedVolume(cage));
        }
}

TEST_CASE("UVs are refined face-varying: linear where the cage's are, across seams too", "[subdivide]") {
    // On a regular torus the parameters are equally spaced each way, so the limit uv of a vertex in the middle of an island
    // is its parameter, and a seam stays at 0 and 1.
    const int n = 12;
    const int m = 8;
    const Mesh cage = torus(n, m);
    for (int level = 1; level <= 2; ++level) {
        const Mesh mesh = subdivide(cage, {.level = level}).mesh;
        REQUIRE(mesh.cornerUvs.size() == mesh.cornerCount());
        Vec2 lower(kInfinity);
        Vec2 upper(-kInfinity);
        double area = 0;
        for (std::size_t f = 0; f < mesh.faceCount(); ++f) {
            std::array<Vec2, 4> uv;
            for (std::size_t c = 0; c < 4; ++c) {
                const std::size_t corner = mesh.faceOffsets[f] + c;
                uv[c] = mesh.uvs.at(mesh.cornerUvs[corner]);
                lower = glm::min(lower, uv[c]);
                upper = glm::max(upper, uv[c]);
                // The limit of a ring of control points keeps their rotational symmetry at the knots.
                const Vec3 p = mesh.positions[mesh.cornerPositions[corner]];
                float turn = std::atan2(p.y, p.x) / (2 * kPi) - uv[c].x;
                turn -= std::round(turn);
                if (uv[c].x > 1.01F / n && uv[c].x < 1 - 1.01F / n) CHECK(std::fabs(turn) < 2e-3F);
            }
            const Vec2 d0 = uv[2] - uv[0];
            const Vec2 d1 = uv[3] - uv[1];
            area += 0.5 * static_cast<double>(d0.x * d1.y - d0.y * d1.x);
        }
        CHECK(lower == Vec2(0));
        CHECK(upper == Vec2(1));
        CHECK(area == Approx(1).epsilon(1e-5)); // no fold, no gap: the faces tile the unit square
    }
}

TEST_CASE("UVs are left out where a corner lacks one", "[subdivide]") {
    Mesh cage = openGrid(2, bumpy);
    cage.cornerUvs[5] = kNone;
    const Mesh mesh = subdivide(cage, {.level = 1}).mesh;
    CHECK(mesh.uvs.empty());
    CHECK(mesh.cornerUvs.empty());
}

TEST_CASE("Children keep their face's material", "[subdivide]") {
    Mesh cage =
        meshOf({{0, 0, 0}, {2, 0, 0}, {3, 1, 0}, {1, 2, 1}, {-1, 1, 0}, {2, 3, 0}, {4, 3, 1}}, {{0, 1, 2, 3, 4}, {3, 2, 6, 5}, {4, 3, 5}});
    cage.materialNames = {"steel", "brass", "tin"};
    cage.faceMaterials = {2, 0, 1};
    for (int level = 0; level <= 3; ++level) {
        const Mesh mesh = subdivide(cage, {.level = level}).mesh;
        CHECK(mesh.materialNames == cage.materialNames);
        REQUIRE(mesh.faceMaterials.size() == mesh.faceCount());
        const auto count = [&](Index m) { return std::count(mesh.faceMaterials.begin(), mesh.faceMaterials.end(), m); };
        const int children = level == 0 ? 0 : 1 << (2 * (level - 1));
        CHECK(count(2) == (level == 0 ? 1 : 5 * children));
        CHECK(count(0) == (level == 0 ? 1 : 4 * children));
        CHECK(count(1) == (level == 0 ? 1 : 3 * children));
    }
    // A quarter of the square belongs to each face of a 2 x 2 grid: the material is where its face was.
    Mesh grid = openGrid(2, [](int, int) { return 0.0F; });
    grid.faceMaterials = {0, 1, 2, 3};
    const Mesh mesh = subdivide(grid, {.level = 2}).mesh;
    for (std::size_t f = 0; f < mesh.faceCount(); ++f) {
        Vec3 centre(0);
        for (std::size_t c = 0; c < 4; ++c) centre += 0.25F * mesh.positions[mesh.cornerPositions[mesh.faceOffsets[f] + c]];
        CHECK(mesh.faceMaterials[f] == (centre.x > 1 ? 1U : 0U) + (centre.y > 1 ? 2U : 0U));
    }
}

TEST_CASE("Repeated corners are left out, with their materials in step", "[subdivide]") {
    Mesh cage = meshOf({{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}, {{1, 1, 0}, {0, 1, 1, 2, 0}, {0, 2, 3}});
    cage.materialNames = {"a", "b", "c"};
    cage.faceMaterials = {0, 1, 2};
    const Mesh expected = subdivide(meshOf(cage.positions, {{0, 1, 2}, {0, 2, 3}}), {.level = 1}).mesh;
    const Mesh mesh = subdivide(cage, {.level = 1}).mesh;
    CHECK(farthest(mesh.positions, expected.positions) < 1e-6F);
    CHECK(mesh.positions.size() == expected.positions.size());
    CHECK(mesh.faceMaterials == std::vector<Index>{1, 1, 1, 2, 2, 2});
}

TEST_CASE("Applying rows again reuses the output", "[subdivide]") {
    const Mesh cage = torus(16, 12);
    const Subdivision s = subdivide(cage, {.level = 3}); // more rows than one grain
    REQUIRE(s.positions.rowCount() > 4096);
    std::vector<Vec3> out;
    applyStencils(s.positions, cage.positions, out);
    const Vec3 *data = out.data();
    const std::vector<Vec3> first = out;
    applyStencils(s.positions, cage.positions, out);
    CHECK(out.data() == data);
    CHECK(out == first);
    CHECK(out == s.mesh.positions);
}

TEST_CASE("What can't be subdivided is said in one line with the mesh's name", "[subdivide]") {
    const auto messageOf = [](const Mesh &cage, int level) {
        try {
            subdivide(cage, {.level = level});
        } catch (const InputError &error) {
            return std::string(error.what());
        }
        return std::string();
    };
    for (const int level : {-1, kReferenceLevel + 1, 1000}) {
        const std::string message = messageOf(cube(), level);
        CHECK(message.find("'cage'") != std::string::npos);
        CHECK(message.find(std::to_string(level)) != std::string::npos);
    }
    // Too much is refused before anything of that size is allocated: many faces, a huge face, a huge valence.
    Mesh many = cube();
    const std::vector<Index> corners = many.cornerPositions;
    for (int copy = 1; copy < 24000; ++copy)
        for (Index f = 0; f < 6; ++f) {
            many.cornerPositions.insert(many.cornerPositions.end(), corners.begin() + 4 * f, corners.begin() + 4 * f + 4);
            many.faceOffsets.push_back(static_cast<Index>(many.cornerPositions.size()));
        }
    const std::string message = messageOf(many, 1);
    CHECK(message.find("'cage'") != std::string::npos);
    CHECK(message.find('\n') == std::string::npos);
    CHECK(messageOf(meshOf(cube().positions, {{0, 2, 3, 1}, {4, 5, 4, 6}}), 1).find("face 1 ") != std::string::npos);
    CHECK(messageOf(meshOf(cube().positions, {{0, 0, 0}}), 1).find("no faces") != std::string::npos);
    Mesh disk = meshOf(std::vector<Vec3>(40000, Vec3(0)), {{}});
    disk.cornerPositions.resize(40000);
    std::iota(disk.cornerPositions.begin(), disk.cornerPositions.end(), Index{0});
    disk.faceOffsets = {0, 40000};
    CHECK(messageOf(disk, 1).find("too many") != std::string::npos);
    CHECK(messageOf(torus(1000, 500), 5).find("too many") != std::string::npos);
}

TEST_CASE("Limit points agree with refined meshes of OpenSubdiv's own baseline", "[subdivide][assets]") {
    const auto shape = test::asset("subd/shapes/catmark_cube.obj");
    if (!shape) return;
    Warnings warnings;
    const Mesh cage = readMesh(*shape, warnings);
    for (int level = 1; level <= 3; ++level) {
        const auto baseline = test::asset("subd/baseline/catmark_cube_level" + std::to_string(level - 1) + ".obj");
        if (!baseline) return;
        // The baseline's "level 0" is the cage refined once; its vertices are not on the limit surface yet.
        const Mesh refined = readMesh(*baseline, warnings);
        const std::vector<Vec3> expected = halsteadLimit(refined);
        const Mesh mesh = subdivide(cage, {.level = level}).mesh;
        CHECK(mesh.positions.size() == expected.size());
        CHECK(mesh.faceCount() == refined.faceCount());
        CHECK(farthest(mesh.positions, expected) < 2e-6F);
        CHECK(farthest(expected, mesh.positions) < 2e-6F);
        CHECK(farthest(mesh.positions, refined.positions) > 0.05F / static_cast<float>(1 << (2 * level))); // the test can tell them apart
    }
}

TEST_CASE("Production cages: watertight, uvs in their hull", "[subdivide][assets]") {
    for (const char *name : {"static/spot_control_mesh.obj", "static/penguin_control_mesh.obj", "subd/shapes/catmark_torus.obj"}) {
        const auto path = test::asset(name);
        if (!path) continue;
        INFO(name);
        Warnings warnings;
        const Mesh cage = readMesh(*path, warnings);
        CHECK(isWatertight(cage));
        const Subdivision s = subdivide(cage, {.level = 2});
        CHECK(largestPartitionError(s.positions) < 1e-6);
        CHECK(isWatertight(s.mesh));
        CHECK(s.mesh.positions.size() == s.positions.rowCount());
        CHECK(std::all_of(s.mesh.positions.begin(), s.mesh.positions.end(), isFinite));
        const Bounds cageBounds = boundsOf(cage.positions);
        for (const Vec3 &p : s.mesh.positions)
            REQUIRE((glm::all(glm::greaterThanEqual(p, cageBounds.lower - 1e-5F)) &&
                     glm::all(glm::lessThanEqual(p, cageBounds.upper + 1e-5F))));
        if (cage.cornerUvs.empty()) continue;
        REQUIRE(s.mesh.cornerUvs.size() == s.mesh.cornerCount());
        Vec2 lower(kInfinity);
        Vec2 upper(-kInfinity);
        for (const Vec2 &uv : cage.uvs) {
            lower = glm::min(lower, uv);
            upper = glm::max(upper, uv);
        }
        for (const Vec2 &uv : s.mesh.uvs)
            REQUIRE((glm::all(glm::greaterThanEqual(uv, lower - 1e-5F)) && glm::all(glm::lessThanEqual(uv, upper + 1e-5F))));
    }
}
