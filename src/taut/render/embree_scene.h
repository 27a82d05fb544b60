#pragma once
/// The Embree scene of a render: made once, its vertex buffers updated every frame.

#include "taut/deform/surface_motion.h"
#include "taut/render/ray_batch.h"

#include <memory>
#include <span>
#include <string_view>
#include <vector>

namespace taut {

/// Says of every meeting of a ray with a geometry that asks (EmbreeScene::ask) whether there is a surface. Called by all threads, in any
/// order along the ray, and more than once for a triangle: the answer must be the same each time.
class SurfaceTest {
  public:
    SurfaceTest() = default;
    SurfaceTest(const SurfaceTest &) = delete;
    SurfaceTest &operator=(const SurfaceTest &) = delete;
    virtual ~SurfaceTest() = default;
    /// `ray`: its place in the batch.
    [[nodiscard]] virtual bool isThere(std::size_t ray, const Hit &hit) const = 0;
};

/// The version of Embree that this was compiled with.
std::string_view embreeVersion();

struct MeshTriangles {
    std::span<const Index3> triangles;
    /// [vertices] those with the same number are at one place in every frame, to rounding; empty: none are known
    std::span<const Index> places = {};
    /// Whether a scene that refits would refit it. Hits have the same bits where none does: with Embree 4 neither has quads then.
    bool deforms = false;
};

class EmbreeScene {
  public:
    /// `refits`: meshes will be refitted between commits, each with a BVH of its own that rays take longer through; else one BVH over
    /// everything, built anew by a commit after any change.
    explicit EmbreeScene(bool refits);
    ~EmbreeScene();
    EmbreeScene(const EmbreeScene &) = delete;
    EmbreeScene &operator=(const EmbreeScene &) = delete;

    /// Adds a triangle mesh, which Embree gets as quads (triangle_pairs.h). The caller owns the buffers and keeps them in place: positions
    /// at one time, or at several equally spaced ones within the shutter; each array has one element more than is indexed (Embree reads 16
    /// bytes at each vertex). Returns its geometry number.
    Index addTriangles(const std::vector<std::span<const Vec3>> &positions, const MeshTriangles &mesh);

    /// Adds a mesh that moves as a whole: its own BVH is built here, once, around positions in a space of its own (one element more
    /// than is indexed); `renderFromLocal` holds one map, or several at equally spaced times within the shutter, between which
    /// they are interpolated entry by entry.
    Index addInstance(std::span<const Vec3> positions, const MeshTriangles &mesh, std::span<const Affine> renderFromLocal);

    /// Adds the mesh of another instance once more, on the BVH that this one has.
    Index addInstanceOf(Index geometry, std::span<const Affine> renderFromLocal);

    /// Moves an instance; as many maps as it was added with.
    void place(Index geometry, std::span<const Affine> renderFromLocal);

    /// Whether rays ask, each time they meet this geometry, if there is a surface; not so at first. Costs nothing where it does not ask.
    void ask(Index geometry, bool asks);

    /// Says that the positions of a mesh that is no instance have changed. Its BVH is refitted, or built anew where that is asked for,
    /// where the scene does not refit and where there are several times (Embree refits none of these).
    void update(Index geometry, bool rebuild);

    /// Builds or refits what has changed.
    void commit();

    /// Closest hits. `coherent` rays (neighbours side by side) go 16 wide, others 8 wide. hits.size() == rays.size(). Without a test all
    /// surfaces are there.
    void intersect(std::span<const Ray> rays, bool coherent, std::span<Hit> hits, const SurfaceTest *test = nullptr) const;

    /// True at i where ray i meets anything in [nearest, farthest].
    void occluded(std::span<const Ray> rays, std::span<unsigned char> blocked, const SurfaceTest *test = nullptr) const;

    /// BVHs behind instances.
    [[nodiscard]] std::size_t instancedBvhs() const;

    /// Bytes that Embree holds: BVHs, quads and what goes with them, not the positions it was given.
    [[nodiscard]] std::size_t bytes() const;
    /// Beside them, of what tells triangles from quads.
    [[nodiscard]] std::size_t pairBytes() const;

    /// Embree's own handle (RTCScene), for measuring bare calls.
    [[nodiscard]] void *native() const;

  private:
    struct State;
    std::unique_ptr<State> state_;
};

} // namespace taut
