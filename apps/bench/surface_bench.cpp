/// A million vertices a frame: deform, gradient, normals, M and the BVH of a subdivided mesh beside what OpenSubdiv's own position
/// stencils cost and what the memory moves, in one run; with the allocations of every frame after the first, counted.

#include "taut/base/parallel.h"
#include "taut/base/stopwatch.h"
#include "taut/mesh/shapes.h"
#include "taut/render/render_scene.h"

#include <opensubdiv/far/stencilTableFactory.h>
#include <opensubdiv/far/topologyDescriptor.h>
#include <opensubdiv/osd/bufferDescriptor.h>
#include <opensubdiv/osd/cpuEvaluator.h>

#include <algorithm>
#include <atomic>
#include <cstdio>
#include <cstdlib>
#include <functional>
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
namespace Far = OpenSubdiv::Far;
namespace Osd = OpenSubdiv::Osd;

constexpr int kLevel = 4;
constexpr int kRepetitions = 9;
constexpr std::size_t kGrain = 4096;

/// Medians of repeated runs, in milliseconds, all measured in turn.
struct Row {
    std::string name;
    std::function<void(int)> run;
    std::vector<double> times;
    [[nodiscard]] double median() const {
        std::vector<double> sorted = times;
        std::sort(sorted.begin(), sorted.end());
        return sorted[sorted.size() / 2];
    }
    [[nodiscard]] double spread() const {
        std::vector<double> sorted = times;
        std::sort(sorted.begin(), sorted.end());
        return sorted[3 * sorted.size() / 4] - sorted[sorted.size() / 4];
    }
};

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
    Object object;
    object.name = "torus";
    object.mesh = std::make_shared<const Mesh>(makeTorus(64, 64, 1, 0.4F));
    object.materials = {0};
    object.subdivision.level = kLevel;
    DeformerKeys twist;
    twist.type = DeformerType::Twist;
    twist.axis = 2;
    twist.amount.keys = {{1, 0.0}, {100, 2.0}};
    DeformerKeys shear;
    shear.type = DeformerType::Shear;
    shear.axis = 0;
    shear.axis2 = 2;
    shear.amount.keys = {{1, 0.0}, {100, 1.0}};
    object.deformers = {twist, shear};
    scene.objects.push_back(std::move(object));
    scene.materials = {Material{}};
    scene.materials[0].type = BsdfType::Conductor;
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
    moveObject(whole, 0, 1, scene.render.fps, DMat4(1), ignored, ignored);

    SurfaceGradient gradient;
    std::vector<Vec4> source(64U << 20U >> 4U);
    std::vector<Vec4> target(source.size());
    EmbreeScene embree(true);
    const Index geometry = embree.addTriangles({whole.steps[0].positions}, whole.surface.triangles);
    embree.commit();

    // Worker threads allocate when they first join in: a few frames go by until all have.
    constexpr int kCounted = 20;
    std::size_t before = 0;
    for (int frame = 2; frame < 12 + kCounted; ++frame) {
        if (frame == 12) before = allocations;
        moveObject(whole, 0, frame, scene.render.fps, DMat4(1), ignored, ignored);
    }
    const std::size_t counted = allocations - before;

    std::vector<Row> rows;
    rows.push_back({"copy 64 MiB", [&](int) { parallelFor(source.size(), kGrain, [&](std::size_t i) { target[i] = source[i]; }); }, {}});
    rows.push_back({"OpenSubdiv, positions", [&](int) { osd.evaluate(cage.positions); }, {}});
    rows.push_back({"limit positions", [&](int) { applyStencils(subdivision.positions, cage.positions, limit); }, {}});
    rows.push_back(
        {"limit positions, normals, dx/ds, dx/dt", [&](int) { fitGradient(whole.surface, cage.positions, false, "torus", gradient); }, {}});
    rows.push_back({"all: deform, gradient, V, vertices",
                    [&](int i) { moveObject(whole, 0, 2 + i, scene.render.fps, DMat4(1), ignored, ignored); },
                    {}});
    rows.push_back({"BVH refit",
                    [&](int) {
                        embree.update(geometry, false);
                        embree.commit();
                    },
                    {}});
    rows.push_back({"BVH rebuild",
                    [&](int) {
                        embree.update(geometry, true);
                        embree.commit();
                    },
                    {}});
    for (int i = 0; i < kRepetitions; ++i)
        for (Row &row : rows) {
            Stopwatch watch;
            row.run(i);
            row.times.push_back(watch.lap() * 1e3);
        }
    std::printf("%zu vertices, %zu triangles, %zu weights, %d repetitions in turn\n", vertices, whole.surface.triangles.size(),
                whole.surface.stencilPositions.size(), kRepetitions);
    for (const Row &row : rows) std::printf("%-42s %8.2f ms (middle half within %.2f)\n", row.name.c_str(), row.median(), row.spread());
    const double bandwidth = 2 * 64.0 / 1024 / (rows[0].median() * 1e-3);
    // Rows read once, vertices written once.
    const double bytes = static_cast<double>(whole.surface.stencilPositions.size()) * 16 + static_cast<double>(vertices) * 48;
    std::printf("memory moves %.1f GiB/s; the rows and vertices of the gradient at that speed: %.2f ms\n", bandwidth,
                bytes / (bandwidth * 1024 * 1024 * 1024) * 1e3);
    std::printf("gradient and V over positions and normals: +%.0f %%\n", 100 * (rows[4].median() / rows[3].median() - 1));
    std::printf("positions, normals and gradient over OpenSubdiv's positions: %.2f\n", rows[3].median() / rows[1].median());
    std::printf("allocations in %d frames after the first: %zu\n", kCounted, counted);
    return counted == 0 ? 0 : 1;
}
