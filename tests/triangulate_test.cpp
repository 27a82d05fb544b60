/// Triangulation of polygons: the same triangles as by looking at every ear and every corner, and none lost in large ones.

#include "assets.h"
#include "catch.h"

#include "taut/deform/surface.h"
#include "taut/formats/read_mesh.h"
#include "taut/mesh/triangulate.h"

#include <numeric>
#include <random>

using namespace taut;
using namespace taut::test;

namespace {

float signedArea(const Vec3 &a, const Vec3 &b, const Vec3 &c, const Vec3 &normal) {
    return glm::dot(glm::cross(b - a, c - a), normal);
}

/// The largest valid ear first, found by trying all of them against all corners.
std::vector<Index3> byTrying(const std::vector<Vec3> &points) {
    const Vec3 normal = polygonNormal(points);
    std::vector<Index> left(points.size());
    std::iota(left.begin(), left.end(), Index{0});
    std::vector<Index3> triangles;
    const auto corner = [&](std::size_t i) { return left[i % left.size()]; };
    while (left.size() > 3) {
        std::size_t best = 0;
        float bestArea = 0;
        for (std::size_t i = 0; i < left.size(); ++i) {
            const Vec3 &a = points[corner(i + left.size() - 1)];
            const Vec3 &b = points[corner(i)];
            const Vec3 &c = points[corner(i + 1)];
            const float area = signedArea(a, b, c, normal);
            if (!(area > bestArea)) continue;
            bool empty = true;
            for (std::size_t k = i + 2; k < i + left.size() - 1; ++k) {
                const Vec3 &p = points[corner(k)];
                empty =
                    empty && !(signedArea(a, b, p, normal) >= 0 && signedArea(b, c, p, normal) >= 0 && signedArea(c, a, p, normal) >= 0);
            }
            if (!empty) continue;
            best = i;
            bestArea = area;
        }
        triangles.emplace_back(corner(best + left.size() - 1), corner(best), corner(best + 1));
        left.erase(left.begin() + static_cast<std::ptrdiff_t>(best));
    }
    triangles.emplace_back(left[0], left[1], left[2]);
    return triangles;
}

std::vector<Index3> trianglesOf(const std::vector<Vec3> &points) {
    std::vector<Index3> triangles;
    triangulate(points, triangles);
    return triangles;
}

/// The corners of a star about the origin, its plane turned.
template <class Radius> std::vector<Vec3> star(std::size_t corners, const Radius &radius) {
    const Mat3 turn = glm::mat3_cast(glm::normalize(Quat(0.3F, -0.5F, 0.2F, 0.7F)));
    std::vector<Vec3> points;
    for (std::size_t i = 0; i < corners; ++i) {
        const float angle = 2 * kPi * static_cast<float>(i) / static_cast<float>(corners);
        points.push_back(turn * Vec3(std::cos(angle), std::sin(angle), 0) * radius(i));
    }
    return points;
}

/// A comb of long teeth: every other corner far out.
std::vector<Vec3> comb(std::size_t teeth) {
    std::vector<Vec3> points{{0, -1, 0}, {static_cast<float>(teeth), -1, 0}};
    for (std::size_t i = teeth; i > 0; --i) {
        points.emplace_back(static_cast<float>(i), 100, 0);
        points.emplace_back(static_cast<float>(i) - 0.5F, 0, 0);
    }
    return points;
}

/// No triangle is turned over, and together they are the polygon.
void checkCovers(const std::vector<Vec3> &points) {
    const std::vector<Index3> triangles = trianglesOf(points);
    REQUIRE(triangles.size() == points.size() - 2);
    const DVec3 whole(polygonNormal(points));
    const DVec3 up = glm::normalize(whole);
    double sum = 0;
    std::size_t turned = 0;
    for (const Index3 &t : triangles) {
        const double area = glm::dot(DVec3(glm::cross(points[t.y] - points[t.x], points[t.z] - points[t.x])), up);
        sum += area;
        turned += area < -1e-6 * glm::length(whole) ? 1 : 0;
    }
    CHECK(turned == 0);
    CHECK(sum == Approx(glm::length(whole)).epsilon(1e-4));
}

} // namespace

TEST_CASE("triangulate: the largest valid ear first, as by trying all", "[triangulate]") {
    std::mt19937 random(3);
    std::uniform_real_distribution<float> radius(0.2F, 1);
    for (std::size_t corners = 5; corners < 90; ++corners) {
        INFO(corners << " corners");
        const std::vector<Vec3> wild = star(corners, [&](std::size_t) { return radius(random); });
        CHECK(trianglesOf(wild) == byTrying(wild));
        const std::vector<Vec3> round = star(corners, [](std::size_t) { return 1.0F; });
        CHECK(trianglesOf(round) == byTrying(round));
        std::vector<Vec3> bent = wild; // not in a plane
        for (Vec3 &p : bent) p.z += 0.1F * p.x * p.y;
        CHECK(trianglesOf(bent) == byTrying(bent));
        // Crossing itself, on a coarse grid where many ears are equal and corners coincide.
        std::vector<Vec3> crossing;
        for (std::size_t i = 0; i < corners; ++i) crossing.emplace_back(std::floor(radius(random) * 6), std::floor(radius(random) * 6), 0);
        CHECK(trianglesOf(crossing).size() == corners - 2);
    }
    CHECK(trianglesOf(comb(20)) == byTrying(comb(20)));
    CHECK(trianglesOf(std::vector<Vec3>(7, Vec3(1, 2, 3))).size() == 5);
}

TEST_CASE("triangulate: large polygons are covered", "[triangulate]") {
    checkCovers(star(16000, [](std::size_t) { return 1.0F; }));
    checkCovers(star(16000, [](std::size_t i) { return i % 2 == 0 ? 1.0F : 0.6F; }));
    checkCovers(comb(8000));
}

TEST_CASE("triangulate: case ngon", "[triangulate]") {
    const auto path = caseFile("ngon/n4000.obj");
    if (!path) return;
    Warnings warnings;
    const Mesh mesh = readMesh(*path, warnings);
    REQUIRE(mesh.faceCount() == 1);
    CHECK(buildSurface(mesh, {}).triangles.size() == mesh.cornerCount() - 2);
    std::vector<Vec3> points;
    for (const Index p : mesh.cornerPositions) points.push_back(mesh.positions[p]);
    checkCovers(points);
}
