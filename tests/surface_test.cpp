/// The surface gradient against closed forms: rest, rigid motion, deformers, skins; and the named policies where there is none.

#include "catch.h"
#include "render_fixtures.h"

#include "taut/base/frame.h"
#include "taut/deform/stretch.h"
#include "taut/deform/surface_motion.h"

#include <random>

using namespace taut;
using namespace taut::test;

namespace {

struct Evaluated {
    Surface surface;
    SurfaceGradient gradient;
    DeformedVertices frame;
};

Evaluated evaluateMesh(const Mesh &mesh, const std::vector<DeformerKeys> &deformers, GradientEstimator estimator,
                       const Affine &carrier = Affine(1), const Mat3 &rest = Mat3(1)) {
    Evaluated e;
    SurfaceOptions options;
    options.restFromObject = rest;
    e.surface = buildSurface(mesh, options);
    MotionState motion;
    motion.control = mesh.positions;
    motion.carrier = carrier;
    motion.mirrored = glm::determinant(Mat3(carrier[0], carrier[1], carrier[2])) < 0;
    for (const DeformerKeys &keys : deformers) motion.deformers.push_back(deformerAtFrame(keys, 1));
    evaluateGradient(e.surface, motion, mesh.skin, estimator, mesh.name, e.gradient);
    spreadToVertices(e.surface, e.gradient, e.frame);
    return e;
}

/// Largest deviation of (ds, dt) from an orthonormal pair of length `scale`.
float deviationFromRigid(const DeformedVertices &frame, float scale = 1) {
    float worst = 0;
    for (std::size_t v = 0; v < frame.ds.size(); ++v) {
        const float s2 = scale * scale;
        worst =
            std::max({worst, std::fabs(glm::dot(frame.ds[v], frame.ds[v]) / s2 - 1), std::fabs(glm::dot(frame.dt[v], frame.dt[v]) / s2 - 1),
                      std::fabs(glm::dot(frame.ds[v], frame.dt[v])) / s2, std::fabs(glm::dot(frame.ds[v], frame.normals[v])) / scale});
    }
    return worst;
}

Mesh withoutUvs(Mesh mesh) {
    mesh.uvs.clear();
    mesh.cornerUvs.clear();
    return mesh;
}
Mesh withoutNormals(Mesh mesh) {
    mesh.normals.clear();
    mesh.cornerNormals.clear();
    return mesh;
}
Mesh mirroredHalf(Mesh mesh) { // u runs back on the far half
    for (Vec2 &uv : mesh.uvs) uv.x = std::fabs(uv.x - 0.5F);
    return mesh;
}
Mesh jittered(Mesh mesh) { // uneven triangles: the one-rings are not symmetric
    std::mt19937 random(5);
    std::uniform_real_distribution<float> shift(-0.01F, 0.01F);
    for (Vec3 &p : mesh.positions) p += Vec3(shift(random), shift(random), shift(random));
    return mesh;
}

std::vector<std::pair<const char *, Mesh>> fixtures() {
    return {{"torus", makeTorus(32, 16, 1, 0.4F)},
            {"torus without uvs", withoutUvs(makeTorus(32, 16, 1, 0.4F))},
            {"torus without normals", withoutNormals(makeTorus(32, 16, 1, 0.4F))},
            {"torus with mirrored uvs", mirroredHalf(makeTorus(32, 16, 1, 0.4F))},
            {"coarse torus", makeTorus(7, 5, 1, 0.4F)},
            {"jittered torus", jittered(makeTorus(32, 16, 1, 0.4F))},
            {"sphere", makeSphere(24, 12, 1)},
            {"grid", makeGrid(5, 7, 2)}};
}

/// Rotation and scale as an affine map.
Affine similarity(float scale) {
    const Mat3 r = glm::mat3_cast(glm::normalize(Quat(0.3F, -0.5F, 0.2F, 0.7F))) * scale;
    return {r[0], r[1], r[2], Vec3(3, -2, 5)};
}

} // namespace

TEST_CASE("At rest, under rigid motion and uniform scale the gradient is exactly that", "[surface][rigid]") {
    for (const auto &[name, mesh] : fixtures())
        for (const GradientEstimator estimator : {GradientEstimator::Analytic, GradientEstimator::Area}) {
            INFO(name << ", estimator " << static_cast<int>(estimator));
            const Evaluated rest = evaluateMesh(mesh, {}, estimator);
            CHECK(deviationFromRigid(rest.frame) < 2e-5F);
            for (std::size_t v = 0; v < rest.frame.normals.size(); ++v)
                REQUIRE(glm::dot(rest.frame.normals[v], rest.surface.normals[rest.surface.vertexSurface[v]]) > 0.999999F);
            CHECK(deviationFromRigid(evaluateMesh(mesh, {}, estimator, similarity(1)).frame) < 4e-5F);
            CHECK(deviationFromRigid(evaluateMesh(mesh, {}, estimator, similarity(2)).frame, 2) < 4e-5F);
            // The rest placement carries scale: nothing is left of it.
            CHECK(deviationFromRigid(evaluateMesh(mesh, {}, estimator, similarity(100), Mat3(100)).frame) < 2e-4F);
            // A mirrored placement keeps normals outward.
            Affine mirror = similarity(1);
            mirror[0] = -mirror[0];
            const Evaluated mirrored = evaluateMesh(mesh, {}, estimator, mirror);
            CHECK(deviationFromRigid(mirrored.frame) < 4e-5F);
            const Vec3 n0 = rest.frame.normals[3];
            CHECK(glm::dot(mirrored.frame.normals[3], transformVector(mirror, n0)) > 0.9999F);
        }
}

TEST_CASE("Deformers carry the gradient exactly, and the fit converges to it with second order", "[surface][convergence]") {
    DeformerKeys twist;
    twist.type = DeformerType::Twist;
    twist.amount = 1.3;
    DeformerKeys bend;
    bend.type = DeformerType::Bend;
    bend.axis = 0;
    bend.axis2 = 2;
    bend.lower = -2; // the torus lies within: the bend is smooth there
    bend.upper = 2;
    bend.amount = 1.0;
    DeformerKeys wave;
    wave.type = DeformerType::Wave;
    wave.axis = 0;
    wave.axis2 = 2;
    wave.amplitude = 0.1;
    wave.wavelength = 1.5;
    const std::vector<std::pair<const char *, std::vector<DeformerKeys>>> stacks{{"shear", {shearDeformer(0.8, 0, 2)}},
                                                                                 {"stretch", {stretchDeformer(DVec3(2, 0.7, 1.2))}},
                                                                                 {"twist", {twist}},
                                                                                 {"bend", {bend}},
                                                                                 {"wave", {wave}},
                                                                                 {"twist then shear", {twist, shearDeformer(0.5, 0, 2)}}};
    for (const auto &[name, deformers] : stacks) {
        INFO(name);
        std::vector<double> errors;
        for (const int n : {24, 48, 96}) {
            const Mesh mesh = makeTorus(2 * n, n, 1, 0.4F);
            const Evaluated exact = evaluateMesh(mesh, deformers, GradientEstimator::Analytic);
            const Evaluated fit = evaluateMesh(mesh, deformers, GradientEstimator::Area);
            // The analytic gradient against differences of the deformed parametric torus, in double.
            double worst = 0;
            double sum = 0;
            const auto at = [&](double u, double v) {
                const double k = 6.283185307179586;
                DVec3 x((1 + 0.4 * std::cos(k * v)) * std::cos(k * u), (1 + 0.4 * std::cos(k * v)) * std::sin(k * u),
                        0.4 * std::sin(k * v));
                const double rest = k * (1 + 0.4 * std::cos(k * v)); // |dX/du|
                for (const DeformerKeys &keys : deformers) x = deform(deformerAtFrame(keys, 1), x).position;
                return std::pair(x, rest);
            };
            for (std::size_t i = 0; i < exact.frame.ds.size(); ++i) {
                const DVec2 uv(exact.surface.uvs[i]);
                constexpr double h = 1e-5;
                const DVec3 ds = (at(uv.x + h, uv.y).first - at(uv.x - h, uv.y).first) / (2 * h * at(uv.x, uv.y).second);
                const DVec3 dt = (at(uv.x, uv.y + h).first - at(uv.x, uv.y - h).first) / (2 * h * 6.283185307179586 * 0.4);
                worst = std::max({worst, glm::length(DVec3(exact.frame.ds[i]) - ds), glm::length(DVec3(exact.frame.dt[i]) - dt)});
                sum += glm::length(DVec3(fit.frame.ds[i]) - ds) + glm::length(DVec3(fit.frame.dt[i]) - dt);
            }
            CHECK(worst < 2e-5);
            errors.push_back(sum / static_cast<double>(exact.frame.ds.size()));
        }
        if (errors[0] < 1e-4) { // a linear map is fitted exactly: what is left is rounding, which grows as triangles shrink
            CHECK(errors[2] < 2e-4);
            continue;
        }
        CHECK(std::log2(errors[0] / errors[1]) > 1.7);
        CHECK(std::log2(errors[1] / errors[2]) > 1.7);
        CHECK(errors[2] < 0.01);
    }
}

TEST_CASE("Skinning carries the gradient of its weights", "[surface][skin]") {
    // A strip along x whose weight runs from 0 to 1 linearly: its gradient is known exactly.
    Mesh mesh = makeGrid(32, 8, 2);
    mesh.skin.offsets.assign(1, 0);
    for (const Vec3 &p : mesh.positions) {
        const float w = (p.x + 1) / 2;
        mesh.skin.joints.insert(mesh.skin.joints.end(), {0, 1});
        mesh.skin.weights.insert(mesh.skin.weights.end(), {1 - w, w});
        mesh.skin.offsets.push_back(static_cast<Index>(mesh.skin.joints.size()));
    }
    const Surface surface = buildSurface(mesh, {});
    const Mat3 turn = glm::mat3_cast(glm::angleAxis(0.9F, glm::normalize(Vec3(0.2F, 1, 0.1F))));
    MotionState motion;
    motion.control = mesh.positions;
    motion.joints = {Affine(1), Affine(turn[0], turn[1], turn[2], Vec3(0.1F, 0.4F, -0.3F))};
    SurfaceGradient gradient;
    evaluateGradient(surface, motion, mesh.skin, GradientEstimator::Analytic, mesh.name, gradient);
    DeformedVertices frame;
    spreadToVertices(surface, gradient, frame);
    for (std::size_t v = 0; v < frame.ds.size(); ++v) {
        const Vec3 x = mesh.positions[surface.surfacePosition[surface.vertexSurface[v]]];
        const float w = (x.x + 1) / 2;
        const Vec3 moved = transformPoint(motion.joints[1], x);
        const Vec3 ds = (1 - w) * Vec3(1, 0, 0) + w * turn[0] + 0.5F * (moved - x);
        const Vec3 dt = (1 - w) * Vec3(0, 1, 0) + w * turn[1];
        REQUIRE(glm::length(frame.ds[v] - ds) < 2e-5F);
        REQUIRE(glm::length(frame.dt[v] - dt) < 2e-5F);
        REQUIRE(std::fabs(glm::dot(frame.normals[v], glm::normalize(glm::cross(ds, dt)))) > 0.99999F);
    }
}

TEST_CASE("The gradient does not jump at a uv seam", "[surface][seam]") {
    const Evaluated e = evaluateMesh(makeTorus(40, 20, 1, 0.4F), {shearDeformer(0.8, 0, 2)}, GradientEstimator::Area);
    int seams = 0;
    for (std::size_t a = 0; a < e.surface.vertexCount(); ++a)
        for (std::size_t b = a + 1; b < e.surface.vertexCount(); ++b) {
            if (e.surface.vertexSurface[a] != e.surface.vertexSurface[b]) continue;
            ++seams;
            REQUIRE(glm::length(e.frame.ds[a] - e.frame.ds[b]) < 1e-4F);
            REQUIRE(glm::length(e.frame.dt[a] - e.frame.dt[b]) < 1e-4F);
        }
    CHECK(seams >= 59);
}

TEST_CASE("Named policies: mirrored and missing uvs, degenerate faces, collapse", "[surface][policy]") {
    SECTION("TangentFromUv: mirrored uvs turn b0 over") {
        const Evaluated e = evaluateMesh(mirroredHalf(makeTorus(32, 16, 1, 0.4F)), {}, GradientEstimator::Analytic);
        CHECK(e.surface.mirroredVertices > 200);
        int turned = 0;
        for (std::size_t v = 0; v < e.surface.vertexCount(); ++v)
            turned += glm::dot(glm::cross(e.frame.ds[v], e.frame.dt[v]), e.frame.normals[v]) < 0 ? 1 : 0;
        CHECK(turned == static_cast<int>(e.surface.mirroredVertices));
    }
    SECTION("SmoothFieldNoUv: the fall-back field turns slowly") {
        const Evaluated e = evaluateMesh(withoutUvs(makeSphere(64, 32, 1)), {}, GradientEstimator::Analytic);
        CHECK(e.surface.fallbackTangents == e.surface.vertexCount());
        for (const Index3 &t : e.surface.triangles) {
            if (e.frame.normals[t.x].z < -0.8F) continue; // around the one singular point
            REQUIRE(glm::dot(e.frame.ds[t.x], e.frame.ds[t.y]) > 0.9F);
        }
    }
    SECTION("SkipDegenerateFace and RestAtLoneVertex") {
        Mesh mesh = makeGrid(4, 4, 1);
        // A face on a line, sharing a corner with the grid, and one whose corners coincide, alone.
        const auto add = [&](const std::vector<Vec3> &points, Index shared) {
            for (std::size_t i = 0; i < points.size(); ++i) {
                Index at = shared;
                if (i > 0 || shared == kNone) {
                    at = static_cast<Index>(mesh.positions.size());
                    mesh.positions.push_back(points[i]);
                }
                mesh.cornerPositions.push_back(at);
                mesh.cornerUvs.push_back(0);
                mesh.cornerNormals.push_back(0);
            }
            mesh.faceOffsets.push_back(static_cast<Index>(mesh.cornerPositions.size()));
        };
        add({mesh.positions[0], Vec3(2, -0.5F, 0), Vec3(3, -0.5F, 0)}, 0);
        add({Vec3(5), Vec3(5), Vec3(5)}, kNone);
        const Evaluated e = evaluateMesh(mesh, {shearDeformer(1.0)}, GradientEstimator::Area);
        CHECK(e.surface.degenerateFaces == 2);
        CHECK(e.surface.loneVertices >= 3);
        for (std::size_t v = 0; v < e.surface.vertexCount(); ++v) {
            REQUIRE(isFinite(e.frame.ds[v]));
            REQUIRE(isFinite(e.frame.normals[v]));
            REQUIRE(glm::length(e.frame.normals[v]) == Approx(1).epsilon(1e-4));
        }
    }
    SECTION("KeepRestNormal: a surface crushed to a line or a point") {
        for (const DVec3 &factor : {DVec3(1, 0, 0), DVec3(0, 0, 0), DVec3(1e-20, 1, 1), DVec3(0, 1, 0)})
            for (const GradientEstimator estimator : {GradientEstimator::Analytic, GradientEstimator::Area}) {
                const Evaluated e = evaluateMesh(makeTorus(16, 8, 1, 0.4F), {stretchDeformer(factor)}, estimator);
                for (std::size_t v = 0; v < e.surface.vertexCount(); ++v) {
                    const PolarGradient polar = polarGradient(e.frame.ds[v], e.frame.dt[v], e.frame.normals[v]);
                    REQUIRE(glm::length(e.frame.normals[v]) == Approx(1).epsilon(1e-3));
                    REQUIRE(isFinite(polar.stretch.diagonal));
                    REQUIRE(isFinite(polar.stretch.offDiagonal));
                    REQUIRE(isFinite(Vec3(polar.tangent)));
                }
            }
    }
}

TEST_CASE("A later frame as the rest state", "[surface][rest]") {
    const Mesh mesh = makeTorus(32, 16, 1, 0.4F);
    Evaluated e = evaluateMesh(mesh, {shearDeformer(0.8, 0, 2)}, GradientEstimator::Analytic);
    CHECK(deviationFromRigid(e.frame) > 0.3F);
    setRestFrom(e.surface, e.gradient);
    spreadToVertices(e.surface, e.gradient, e.frame);
    CHECK(deviationFromRigid(e.frame) < 2e-5F);
}

TEST_CASE("Polar decomposition: V R is the gradient again", "[surface][polar]") {
    std::mt19937 random(2);
    std::normal_distribution<float> gauss;
    for (int i = 0; i < 2000; ++i) {
        const Vec3 n = glm::normalize(Vec3(gauss(random), gauss(random), gauss(random)));
        const Frame frame = smoothFrameFromNormal(n);
        const Vec3 ds = frame.s * gauss(random) + frame.t * gauss(random);
        const Vec3 dt = frame.s * gauss(random) + frame.t * gauss(random);
        const PolarGradient polar = polarGradient(ds, dt, n);
        const Vec3 tangent(polar.tangent);
        const Vec3 bitangent = glm::cross(n, tangent) * polar.tangent.w;
        const float size = glm::length(ds) + glm::length(dt);
        CHECK(glm::length(polar.stretch.times(tangent) - ds) < 2e-5F * size);
        CHECK(glm::length(polar.stretch.times(bitangent) - dt) < 2e-5F * size);
        CHECK(glm::dot(tangent, n) == Approx(0).margin(1e-5));
        CHECK(glm::dot(polar.stretch.times(n), n) == Approx(std::sqrt(std::fabs(glm::dot(glm::cross(ds, dt), n)))).margin(1e-4 * size));
    }
}
