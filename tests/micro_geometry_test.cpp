/// A heightfield of real facets, deformed by the mesh deformers: its normals against D_M.

#include "command.h"

#include "study/microsurface/micro_geometry.h"
#include "taut/render/image_file.h"

using namespace taut;

namespace {

constexpr int kBins = 32;

double distanceAfter(const Mesh &rest, const MicroTransform &deformed, const MicroTransform &expected) {
    Mesh mesh = rest;
    deformPositions(mesh, deformersOf(deformed));
    return totalVariation(countNormals(mesh, kBins), expectedNormals(expected, kBins));
}

} // namespace

TEST_CASE("The GGX heightfield is one: continuous, facing up, over its whole patch", "[micro_geometry]") {
    const Mesh mesh = makeGgxHeightfield(20000, 1);
    REQUIRE(mesh.faceCount() >= 20000);
    double area = 0;
    double farthest = 0;
    for (std::size_t f = 0; f < mesh.faceCount(); ++f) {
        const Index *c = &mesh.cornerPositions[mesh.faceOffsets[f]];
        const DVec3 a(mesh.positions[c[0]]);
        const double z = glm::cross(DVec3(mesh.positions[c[1]]) - a, DVec3(mesh.positions[c[2]]) - a).z;
        if (!(z > 0)) FAIL_CHECK("facet " << f << " faces down");
        area += z / 2;
    }
    // Every roof is 25 positions: incentre, then 8 level lines, the last one on the rim at height 0, so that neighbours meet there.
    REQUIRE(mesh.positions.size() % 25 == 0);
    for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
        farthest = std::max(farthest, static_cast<double>(std::hypot(mesh.positions[i].x, mesh.positions[i].y)));
        if (i % 25 >= 22 && mesh.positions[i].z != 0) FAIL_CHECK("a rim at height " << mesh.positions[i].z);
    }
    CHECK(farthest == Approx(1).epsilon(1e-6));
    // Triangles that lie side by side without a gap or an overlap, facing up, cover the polygon at the rim: a corner lies on the unit
    // circle, and its area is between that of the polygons of 32 and of infinitely many corners.
    CHECK(area < 3.14159265);
    CHECK(area > 16 * std::sin(2 * 3.14159265 / 32));
}

TEST_CASE("Deformed facets have the distribution of the transformed microsurface", "[micro_geometry]") {
    const MicroTransform identity;
    const std::vector<std::pair<std::string, MicroTransform>> cases{{"rest", identity},
                                                                    {"stretched", microTransform(3, 0, 0, 1)},
                                                                    {"sheared", microTransform(1, 2, 0, 1)},
                                                                    {"both", microTransform(10, 20, 0, 10)},
                                                                    {"squashed", microTransform(0.5F, 0.2F, 0, 0.6F)},
                                                                    {"leaning", microTransform(1.5F, 0.5F, 0, 1, 0.5F, 0.3F)}};
    const Mesh coarse = makeGgxHeightfield(60000, 1);
    const Mesh middle = makeGgxHeightfield(250000, 1);
    const Mesh fine = makeGgxHeightfield(1000000, 1);
    REQUIRE(fine.faceCount() >= 1000000);
    for (const auto &[name, m] : cases) {
        const double a = distanceAfter(coarse, m, m);
        const double b = distanceAfter(middle, m, m);
        const double c = distanceAfter(fine, m, m);
        INFO(name << ": " << a << ", " << b << ", " << c);
        CHECK(c < 0.02);
        CHECK(b < 0.75 * a);
        CHECK(c < 0.75 * b);
    }
    // The count notices a microsurface that is off by a tenth.
    CHECK(distanceAfter(fine, microTransform(1, 2, 0, 1), microTransform(1, 2.2F, 0, 1)) > 0.02);
    CHECK(distanceAfter(fine, identity, microTransformFromAlpha(1.1F, 1)) > 0.02);
}

TEST_CASE("Histograms of normals: closed shares and distances", "[micro_geometry]") {
    // alpha 1 is even over the disk: a cell inside has the share (2 / bins)^2 / pi.
    const NormalHistogram even = expectedNormals(MicroTransform{}, 16);
    CHECK(even.share[8 * 16 + 8] == Approx(4.0 / 256 / 3.14159265).epsilon(1e-5));
    double sum = 0;
    for (const double s : even.share) sum += s;
    CHECK(sum == Approx(1).epsilon(1e-3));
    CHECK(totalVariation(even, even) == 0);
    // Two triangles: one level, one of slope 1 along x; projected areas 1/2 and 1/2.
    Mesh mesh;
    mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 0}, {1, 0, 1}, {0, 1, 0}};
    mesh.cornerPositions = {0, 1, 2, 3, 4, 5};
    mesh.faceOffsets = {0, 3, 6};
    const NormalHistogram two = countNormals(mesh, 4);
    CHECK(two.share[2 * 4 + 2] == Approx(0.5)); // n.xy = (0, 0)
    CHECK(two.share[2 * 4 + 0] == Approx(0.5)); // n.xy = (-0.707, 0)
}

TEST_CASE("taut probe microgeometry draws the talk's picture", "[micro_geometry][probe]") {
    const std::string folder = test::freshFolder("micro_geometry");
    const std::string file = folder + "/normals.exr";
    const auto result = test::runTaut({"probe", "microgeometry", "--m", "1,2,0,1", "--facets", "200000", "--width", "128", "-o", file});
    INFO(result.err);
    REQUIRE(result.exitCode == 0);
    const Image image = readImage(file);
    REQUIRE(image.width == 128);
    REQUIRE(image.height == 64);
    // Counted to the left, expected to the right: alike in the large. Blue is outside both.
    double left = 0;
    double right = 0;
    for (std::size_t y = 0; y < 64; ++y)
        for (std::size_t x = 0; x < 64; ++x) {
            const double dx = (static_cast<double>(x) + 0.5) / 32 - 1;
            const double dy = (static_cast<double>(y) + 0.5) / 32 - 1;
            if (dx * dx + dy * dy > 0.9) continue;
            left += static_cast<double>(image.values[(y * 128 + x) * 3]) * (x < 32 ? 1 : -1) * (y < 32 ? 1 : -1);
            right += static_cast<double>(image.values[(y * 128 + x + 64) * 3]) * (x < 32 ? 1 : -1) * (y < 32 ? 1 : -1);
        }
    CHECK(right > 0); // [1 2; 0 1] tilts facets along (-1, 2): more at the upper left and the lower right
    CHECK(left == Approx(right).epsilon(0.05));
}
