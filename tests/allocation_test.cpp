/// What a frame allocates after the first: nothing, whatever computes the gradient.

#include "catch.h"
#include "mesh_fixtures.h"

#include "taut/deform/surface_motion.h"

#include <cstdlib>
#include <new>
#include <optional>

namespace {

thread_local std::size_t allocations = 0;

void *counted(std::size_t bytes) {
    ++allocations;
    if (void *memory = std::malloc(bytes != 0 ? bytes : 1)) return memory;
    throw std::bad_alloc();
}

} // namespace

void *operator new(std::size_t bytes) {
    return counted(bytes);
}
void *operator new[](std::size_t bytes) {
    return counted(bytes);
}
// All forms that a program may pair with the deletes below: else those of a sanitizer would be, whose memory is not malloc's.
void *operator new(std::size_t bytes, const std::nothrow_t &) noexcept {
    ++allocations;
    return std::malloc(bytes != 0 ? bytes : 1);
}
void *operator new[](std::size_t bytes, const std::nothrow_t &) noexcept {
    ++allocations;
    return std::malloc(bytes != 0 ? bytes : 1);
}
void operator delete(void *memory) noexcept {
    std::free(memory);
}
void operator delete[](void *memory) noexcept {
    std::free(memory);
}
void operator delete(void *memory, std::size_t) noexcept {
    std::free(memory);
}
void operator delete[](void *memory, std::size_t) noexcept {
    std::free(memory);
}

using namespace taut;
using namespace taut::test;

namespace {

/// Allocations of one call. Loops of these meshes are shorter than a task, so that all runs on this thread.
template <class F> std::size_t allocationsOf(const F &f) {
    const std::size_t before = allocations;
    f();
    return allocations - before;
}

/// A torus skinned by two joints.
Mesh skinnedTorus() {
    Mesh mesh = torus(12, 8);
    mesh.skin.offsets.assign(1, 0);
    for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
        const float share = 0.5F + 0.4F * std::sin(static_cast<float>(v));
        for (const Index joint : {0U, 1U}) {
            mesh.skin.joints.push_back(joint);
            mesh.skin.weights.push_back(joint == 0 ? share : 1 - share);
        }
        mesh.skin.offsets.push_back(static_cast<Index>(mesh.skin.joints.size()));
    }
    return mesh;
}

} // namespace

TEST_CASE("the counter of allocations counts", "[allocation]") {
    CHECK(allocationsOf([] { const std::vector<int> some(3); }) == 1);
    CHECK(allocationsOf([] {}) == 0);
}

TEST_CASE("A second frame of a surface allocates nothing", "[allocation][surface]") {
    const Mesh mesh = skinnedTorus();
    for (const auto &[estimator, name] : kEstimators) {
        for (const bool subdivided : {false, true}) {
            if (estimator == GradientEstimator::Limit && !subdivided) continue;
            if (estimator == GradientEstimator::Analytic && subdivided) continue;
            INFO(name << (subdivided ? ", subdivided" : ""));
            std::optional<Subdivision> subdivision;
            SurfaceOptions options;
            options.fit = fitOf(estimator);
            if (subdivided) subdivision = subdivide(mesh, {.level = 1});
            if (estimator == GradientEstimator::Limit) {
                options.limit = &*subdivision;
                options.cage = mesh.positions;
            }
            const Surface surface = buildSurface(subdivided ? subdivision->mesh : mesh, options);
            MotionState motion;
            motion.control = mesh.positions;
            motion.joints = {Affine(1), Affine(2)};
            DeformerKeys keys;
            keys.type = DeformerType::Twist;
            keys.amount = 0.5;
            motion.deformers = {deformerAtFrame(keys, 1)};
            std::vector<Vec3> cage;
            std::vector<Vec3> refined;
            SurfaceGradient gradient;
            gradient.wantNormalImage = estimator == GradientEstimator::Analytic;
            DeformedVertices frame;
            const auto run = [&, e = estimator] {
                if (subdivided) {
                    evaluatePositions(motion, mesh.skin, cage);
                    if (!surface.onLimit()) applyStencils(subdivision->positions, cage, refined);
                    fitGradient(surface, surface.onLimit() ? cage : refined, false, mesh.name, gradient);
                } else {
                    evaluateGradient(surface, motion, mesh.skin, e, mesh.name, gradient);
                }
                spreadToVertices(surface, gradient, frame);
            };
            CHECK(allocationsOf(run) > 0);
            CHECK(allocationsOf(run) == 0);
        }
    }
}
