/// Folds: an isometric motion, however sharp, changes no stretch; faces that stretch do; slivers have no say in their neighbours.

#include "assets.h"
#include "catch.h"
#include "render_fixtures.h"

#include "taut/microsurface/transform.h"
#include "taut/scene/load_scene.h"

#include <functional>
#include <random>

using namespace taut;
using namespace taut::test;

namespace {

constexpr double kDegree = 3.14159265358979 / 180;

/// Greatest and least stretch of every render vertex at a frame.
std::vector<Vec2> stretches(const Object &object, double frame = 1) {
    ObjectSurface surface;
    prepareObjectSurface(object, 24, surface);
    double ignored = 0;
    surfaceAtFrame(surface, frame, 24, DMat4(1), ignored, ignored);
    std::vector<Vec2> out;
    for (std::size_t v = 0; v < surface.vertices.ds.size(); ++v) {
        const Vec3 &ds = surface.vertices.ds[v];
        const Vec3 &dt = surface.vertices.dt[v];
        REQUIRE((isFinite(ds) && isFinite(dt) && isFinite(surface.vertices.normals[v])));
        CHECK(std::fabs(glm::dot(ds, surface.vertices.normals[v])) < 1e-4F);
        const float a = glm::length(ds);
        out.push_back(a > 0 ? singularValues(a, glm::dot(ds, dt) / a, 0, glm::length(glm::cross(ds, dt)) / a) : Vec2(0));
    }
    return out;
}

/// The largest distance of a vertex's stretches from (greatest, least).
float worst(const std::vector<Vec2> &found, const Vec2 &expected) {
    float result = 0;
    for (const Vec2 &s : found) result = std::fmax(result, std::fmax(std::fabs(s.x - expected.x), std::fabs(s.y - expected.y)));
    return result;
}

using Map = std::function<DVec3(const DVec3 &)>;

Object moved(const Mesh &mesh, const Map &map, std::optional<GradientEstimator> estimator = {}) {
    Object object = makeObject(mesh);
    object.gradient = estimator;
    std::vector<Vec3> points;
    for (const Vec3 &p : mesh.positions) points.emplace_back(map(DVec3(p)));
    object.points =
        pointFunction(points.size(), [points](double, std::span<Vec3> out) { std::copy(points.begin(), points.end(), out.begin()); });
    return object;
}

/// A sheet in z = 0, folded along the line x = 0: each half turns by half of the angle, and is stretched across the line.
Map fold(double degrees, double left = 1, double right = 1) {
    const double half = 0.5 * degrees * kDegree;
    return [=](const DVec3 &p) {
        const double along = std::fabs(p.x) * (p.x < 0 ? left : right);
        return DVec3((p.x < 0 ? -along : along) * std::cos(half), p.y, -along * std::sin(half));
    };
}

/// A plate of triangles, whose diagonals and rows are not those of the fold: the fold line is one of the rows of corners still.
Mesh triangles(int n) {
    Mesh grid = makeGrid(n, n, 2);
    Mesh out = grid;
    out.faceOffsets = {0};
    out.cornerPositions.clear();
    for (std::size_t f = 0; f < grid.faceCount(); ++f) {
        const auto corner = [&](Index k) { return grid.cornerPositions[grid.faceOffsets[f] + k % 4]; };
        const Index first = f % 2;
        for (const Index k : {first, first + 2}) {
            for (const Index c : {k, k + 1, k + 2}) out.cornerPositions.push_back(corner(c));
            out.faceOffsets.push_back(out.faceOffsets.back() + 3);
        }
    }
    out.cornerUvs = out.cornerPositions;
    out.cornerNormals = out.cornerPositions;
    return out;
}

const std::vector<GradientEstimator> kFits{GradientEstimator::Analytic, GradientEstimator::Area, GradientEstimator::Angle,
                                           GradientEstimator::LeastSquares};

} // namespace

TEST_CASE("fold: case isometric-fold keeps alpha at every vertex of every frame", "[fold]") {
    const auto path = caseFile("isometric-fold/fold.toml");
    if (!path) return;
    Warnings warnings;
    const Scene scene = loadScene(*path, {}, warnings);
    for (const double frame : {1.0, 2.0, 3.0, 4.0}) {
        INFO("frame " << frame);
        CHECK(worst(stretches(scene.objects[0], frame), Vec2(1)) < 1e-4F);
    }
}

TEST_CASE("fold: a sheet keeps its stretch at any angle, under every fit", "[fold]") {
    for (const Mesh &mesh : {makeGrid(8, 8, 2), triangles(8)})
        for (const GradientEstimator fit : kFits)
            for (const double angle : {0.5, 3.0, 20.0, 45.0, 90.0, 135.0, 170.0, 179.9, 180.0}) {
                INFO(nameOf(fit) << ", " << angle << " degrees");
                CHECK(worst(stretches(moved(mesh, fold(angle), fit)), Vec2(1)) < 3e-4F);
                // Stretched to twice its length across the fold: that and no more.
                CHECK(worst(stretches(moved(mesh, fold(angle, 2, 2), fit)), Vec2(2, 1)) < 6e-4F);
            }
}

TEST_CASE("fold: accordions, sheets folded at rest and morphs keep their stretch", "[fold]") {
    // Eight folds to and fro, flat at rest and opened from flat.
    const double pitch = 0.25;
    const auto accordion = [&](double degrees) {
        const double half = 0.5 * degrees * kDegree;
        return [=](const DVec3 &p) {
            const double place = (p.x + 1) / pitch;
            const double within = place - 2 * std::floor(place / 2);
            return DVec3(place * pitch * std::cos(half), p.y, pitch * std::sin(half) * (within < 1 ? within : 2 - within));
        };
    };
    const Mesh sheet = triangles(8);
    for (const double angle : {10.0, 80.0, 160.0}) {
        INFO(angle << " degrees");
        CHECK(worst(stretches(moved(sheet, accordion(angle))), Vec2(1)) < 3e-4F);
        Mesh folded = sheet; // at rest
        folded.normals.clear();
        folded.cornerNormals.clear();
        for (Vec3 &p : folded.positions) p = Vec3(fold(angle)(DVec3(p)));
        const std::vector<Vec3> flat = sheet.positions;
        Object opened = makeObject(folded);
        opened.points = pointFrames({std::span<const Vec3>(flat)});
        CHECK(worst(stretches(opened), Vec2(1)) < 3e-4F);
        // By a morph at full weight, of a node of a rig that turns it.
        Mesh morphed = sheet;
        morphed.morphs.push_back({"fold", {}});
        for (const Vec3 &p : sheet.positions) morphed.morphs[0].positionDeltas.push_back(Vec3(fold(angle)(DVec3(p))) - p);
        Object object = makeObject(morphed);
        Rig rig;
        rig.nodes.resize(1);
        rig.nodes[0].rotation = glm::normalize(DQuat(0.3, -0.5, 0.2, 0.7));
        rig.nodes[0].morphWeights = {1};
        object.rig = RigMotion{std::make_shared<const Rig>(rig), 0};
        CHECK(worst(stretches(object), Vec2(1)) < 3e-4F);
    }
}

TEST_CASE("fold: a hinge of two joints keeps the stretch of both leaves", "[fold][skin]") {
    // The right half follows a joint that turns about the line x = 0; corners on the line follow one joint or half of each.
    for (const Mesh &mesh : {makeGrid(8, 8, 2), triangles(8)})
        for (const bool shared : {false, true})
            for (const double angle : {20.0, 90.0, 175.0, 180.0}) {
                INFO(angle << " degrees" << (shared ? ", shared" : ""));
                Mesh leaves = mesh;
                leaves.skin.offsets = {0};
                for (const Vec3 &p : mesh.positions) {
                    const float right = shared && p.x == 0 ? 0.5F : p.x > 0 ? 1.0F : 0.0F;
                    for (const Index joint : {0U, 1U}) {
                        const float weight = joint == 1 ? right : 1 - right;
                        if (weight == 0) continue;
                        leaves.skin.joints.push_back(joint);
                        leaves.skin.weights.push_back(weight);
                    }
                    leaves.skin.offsets.push_back(static_cast<Index>(leaves.skin.joints.size()));
                }
                Rig rig;
                rig.nodes.resize(3);
                rig.nodes[0].skin = 0;
                rig.nodes[2].rotation = glm::angleAxis(angle * kDegree, DVec3(0, 1, 0));
                Skin skin;
                skin.joints = {1, 2};
                skin.inverseBindMatrix.assign(2, DMat4(1));
                rig.skins = {skin};
                Object object = makeObject(leaves);
                object.rig = RigMotion{std::make_shared<const Rig>(rig), 0};
                CHECK(worst(stretches(object), Vec2(1)) < 3e-4F);
                // As the renderer has it, which gives back what gradients that are carried along have no use for.
                RenderScene ready(smallScene(object, ggxMaterial(0.2F, 0.2F)), false);
                ready.setFrame(1);
                float unlike = 0;
                for (const SymmetricTensor &v : ready.objects()[0].steps[0].stretch)
                    unlike = std::fmax(unlike, glm::length(v.diagonal - Vec3(1)) + glm::length(v.offDiagonal));
                CHECK(unlike < 1e-3F);
            }
}

TEST_CASE("fold: halves that stretch differently keep a stretch between theirs", "[fold]") {
    for (const double angle : {0.0, 60.0, 120.0, 150.0, 170.0, 180.0})
        for (const Vec2 &s : stretches(moved(makeGrid(8, 8, 2), fold(angle, 2, 1)))) {
            INFO(angle << " degrees");
            CHECK(s.x < 2.001F);
            CHECK(s.x > 0.99F);
            CHECK(s.y > 0.97F);
            CHECK(s.y < 1.001F);
        }
}

TEST_CASE("fold: it opens and closes without a jump", "[fold]") {
    // One side stretched a little, as cloth is: the correction comes in by and by.
    std::vector<Vec2> before;
    for (double angle = 0; angle <= 180; angle += 0.25) {
        const std::vector<Vec2> now = stretches(moved(makeGrid(4, 4, 2), fold(angle, 1.02, 1)));
        for (std::size_t v = 0; v < before.size(); ++v) REQUIRE(glm::length(now[v] - before[v]) < 0.01F);
        before = now;
    }
}

TEST_CASE("fold: on a curved surface a linear map is a linear map", "[fold]") {
    const glm::dmat3 linear(1.3, 0.2, -0.4, 0.1, 0.7, 0.5, -0.6, 0.3, 1.1);
    CHECK(linearError(makeObject(makeTorus(64, 32, 0.7F, 0.25F)), linear) < 1e-3F);
}

TEST_CASE("fold: a sliver does not throw its neighbours' stretch", "[fold]") {
    // A sheet cut along x = 0; one sliver fills a T joint there: its middle corner lies on the long edge but for rounding.
    for (const float height : {0.0F, 1e-7F, 1e-6F, 1e-5F, 1e-4F, 1e-3F})
        for (const float side : {-1.0F, 1.0F})
            for (const GradientEstimator fit : kFits) {
                Mesh mesh;
                mesh.name = "joint";
                mesh.positions = {{0, -1, 0}, {0, 1, 0}, {-1, 0, 0}, {1, -1, 0}, {1, 1, 0}, {0, 0, side * height}};
                // left of the edge one triangle; right of it two quads that meet at the middle, and the sliver between.
                const std::vector<std::vector<Index>> faces{{0, 1, 2}, {0, 3, 5}, {3, 4, 5}, {4, 1, 5}, {0, 5, 1}};
                for (const auto &face : faces) {
                    mesh.cornerPositions.insert(mesh.cornerPositions.end(), face.begin(), face.end());
                    mesh.faceOffsets.push_back(static_cast<Index>(mesh.cornerPositions.size()));
                }
                INFO(nameOf(fit) << ", height " << height * side);
                // Bent gently, the middle off by what files round to.
                const Object bent = moved(
                    mesh,
                    [&](const DVec3 &p) { return DVec3(p.x, p.y + (p.x == 0 && p.y == 0 ? 1e-4 : 0.0), 0.05 * p.x * p.x + 1e-4 * p.z); },
                    fit);
                for (const Vec2 &s : stretches(bent)) {
                    CHECK(s.x < 1.5F);
                    CHECK(s.y > 0.5F);
                }
            }
}
