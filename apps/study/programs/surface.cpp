/// taut_surface_bench. A million vertices a frame: deform, gradient, normals, M and the BVH of a subdivided mesh beside what OpenSubdiv's
/// own position stencils cost and what the memory moves, in one run; with the allocations of every frame after the first, counted.

#include "study/measures/timing.h"
#include "study/scenes/scenes.h"

#include "taut/base/parallel.h"
#include "taut/render/render_scene.h"

#include <opensubdiv/far/stencilTableFactory.h>
#include <opensubdiv/far/topologyDescriptor.h>
#include <opensubdiv/osd/bufferDescriptor.h>
#include <opensubdiv/osd/cpuEvaluator.h>

#include <atomic>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <new>

namespace {
std::atomic<std::size_t> allocations{0};
}

void *operator new(std::size_t size) {
    ++allocations;
    if (void *p = std::malloc(size == 0 ? 1 : size)) return p;
    throw std::bad_alloc();
}
void operator delete(void *p) noexcept {
    std::free(p);
}
void operator delete(void *p, std::size_t) noexcept {
    std::free(p);
}

namespace {

using namespace taut;
using namespace taut::chart;
namespace Far = OpenSubdiv::Far;
namespace Osd = OpenSubdiv::Osd;

constexpr int kLevel = 4;
constexpr int kRounds = 9;
constexpr std::size_t kGrain = 4096;

/// OpenSubdiv's stencils of the refined (not limit) positions, evaluated in ranges by TBB: Debian's build brings no TBB evaluator.
class OsdStencils {
  public:
    explicit OsdStencils(const Mesh &cage) {
        std::vector<int> sizes;
        std::vector<int> corners(cage.cornerPositions.begin(), cage.cornerPositions.end());
        for (std::size_t f = 0; f < cage.faceCount(); ++f) sizes.push_back(static_cast<int>(cage.faceOffsets[f + 1] - cage.faceOffsets[f]));
        Far::TopologyDescriptor topology;
        topology.numVertices = static_cast<int>(cage.positions.size());
        topology.numFaces = static_cast<int>(sizes.size());
        topology.numVertsPerFace = sizes.data();
        topology.vertIndicesPerFace = corners.data();
        using Factory = Far::TopologyRefinerFactory<Far::TopologyDescriptor>;
        const std::unique_ptr<Far::TopologyRefiner> refiner(
            Factory::Create(topology, Factory::Options(OpenSubdiv::Sdc::SCHEME_CATMARK, OpenSubdiv::Sdc::Options())));
        refiner->RefineUniform(Far::TopologyRefiner::UniformOptions(kLevel));
        Far::StencilTableFactory::Options options;
        options.generateIntermediateLevels = false;
        table_.reset(Far::StencilTableFactory::Create(*refiner, options));
        out_.resize(static_cast<std::size_t>(table_->GetNumStencils()));
    }
    void evaluate(const std::vector<Vec3> &cage) {
        const Osd::BufferDescriptor three(0, 3, 3);
        tbb::parallel_for(tbb::blocked_range<int>(0, table_->GetNumStencils(), kGrain), [&](const tbb::blocked_range<int> &r) {
            // The evaluator writes from its destination's start, whatever the range.
            Osd::CpuEvaluator::EvalStencils(&cage[0].x, three, &out_[static_cast<std::size_t>(r.begin())].x, three,
                                            table_->GetSizes().data(), table_->GetOffsets().data(), table_->GetControlIndices().data(),
                                            table_->GetWeights().data(), r.begin(), r.end());
        });
    }
    [[nodiscard]] std::size_t size() const { return out_.size(); }

  private:
    std::unique_ptr<const Far::StencilTable> table_;
    std::vector<Vec3> out_;
};

Scene deformingTorus() {
    Scene scene;
    Object torus = objectOf(makeTorus(64, 64, 1, 0.4F));
    torus.subdivision.level = kLevel;
    torus.deformers = {deformer(DeformerType::Twist, ramp(2, 100), 2, 0, 1), deformer(DeformerType::Shear, ramp(1, 100), 0, 2)};
    scene.objects.push_back(std::move(torus));
    scene.materials = {brushedMetal(0.1F, 0.1F)};
    scene.render.frames = {1, 100};
    return scene;
}

} // namespace

int main() {
    const Scene scene = deformingTorus();
    const Object &object = scene.objects[0];
    const Mesh &cage = *object.mesh;
    OsdStencils osd(cage);
    const Subdivision subdivision = subdivide(cage, object.subdivision);
    std::vector<Vec3> limit;
    RenderObject whole;
    prepareRenderObject(object, scene.render, defaultPlan(scene).meshes[0], 1, true, whole);
    const std::size_t vertices = whole.surface.normals.size();
    double ignored = 0;
    const auto move = [&](int frame) { moveObject(whole, 0, frame, scene.render.fps, DMat4(1), ignored, ignored); };
    move(1);

    // Worker threads allocate when they first join in: a few frames go by until all have.
    constexpr int kCounted = 20;
    std::size_t before = 0;
    for (int frame = 2; frame < 12 + kCounted; ++frame) {
        if (frame == 12) before = allocations;
        move(frame);
    }
    const std::size_t counted = allocations - before;

    SurfaceGradient gradient;
    std::vector<Vec4> source(64U << 20U >> 4U);
    std::vector<Vec4> target(source.size());
    EmbreeScene embree(true);
    const Index geometry = embree.addTriangles({whole.steps[0].positions}, {whole.surface.triangles});
    embree.commit();
    const auto updateBvh = [&](bool rebuild) {
        embree.update(geometry, rebuild);
        embree.commit();
    };
    int frame = 1;
    const std::pair<const char *, std::function<void()>> named[] = {
        {"copy 64 MiB", [&] { parallelFor(source.size(), kGrain, [&](std::size_t i) { target[i] = source[i]; }); }},
        {"OpenSubdiv, positions", [&] { osd.evaluate(cage.positions); }},
        {"limit positions", [&] { applyStencils(subdivision.positions, cage.positions, limit); }},
        {"limit positions, normals, dx/ds, dx/dt", [&] { fitGradient(whole.surface, cage.positions, false, "torus", gradient); }},
        {"all: deform, gradient, V, vertices", [&] { move(++frame); }},
        {"BVH refit", [&] { updateBvh(false); }},
        {"BVH rebuild", [&] { updateBvh(true); }}};
    std::vector<std::function<void()>> rows;
    for (const auto &[name, run] : named) rows.push_back(run);
    std::vector<Measured> ms = timeInterleaved(rows, kRounds);
    for (Measured &m : ms) m = m * 1e3;
    std::printf("%zu vertices, %zu triangles, %zu weights, %d repetitions in turn\n", vertices, whole.surface.triangles.size(),
                whole.surface.stencilPositions.size(), kRounds);
    for (std::size_t i = 0; i < ms.size(); ++i) std::printf("%-42s %8.2f +/- %.2f ms\n", named[i].first, ms[i].value, ms[i].spread);
    const double bandwidth = 2 * 64.0 / 1024 / (ms[0].value * 1e-3);
    // Rows read once, vertices written once.
    const double bytes = static_cast<double>(whole.surface.stencilPositions.size()) * 16 + static_cast<double>(vertices) * 48;
    std::printf("memory moves %.1f GiB/s; the rows and vertices of the gradient at that speed: %.2f ms\n", bandwidth,
                bytes / (bandwidth * 1024 * 1024 * 1024) * 1e3);
    std::printf("gradient and V over positions and normals: +%.0f %%\n", 100 * (ms[4].value / ms[3].value - 1));
    std::printf("positions, normals and gradient over OpenSubdiv's positions: %.2f\n", ms[3].value / ms[1].value);
    std::printf("allocations in %d frames after the first: %zu\n", kCounted, counted);
    return counted == 0 ? 0 : 1;
}
