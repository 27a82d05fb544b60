#pragma once
/// The Embree scene of a render: made once, its vertex buffers updated every frame.

#include "taut/render/ray_batch.h"

#include <memory>
#include <span>
#include <vector>

namespace taut {

class EmbreeScene {
  public:
    /// `dynamic`: geometry will change between commits, so that refits pay; else one BVH over everything.
    explicit EmbreeScene(bool dynamic);
    ~EmbreeScene();
    EmbreeScene(const EmbreeScene &) = delete;
    EmbreeScene &operator=(const EmbreeScene &) = delete;

    /// Adds a triangle mesh whose buffers the caller owns and keeps in place: `positions` has one element more than is indexed
    /// (Embree reads 16 bytes at each vertex). `deforms`: refitted every frame rather than rebuilt. Returns its geometry number.
    Index addTriangles(std::span<const Vec3> positions, std::span<const Index3> triangles, bool deforms);

    /// Says that a geometry's buffer contents have changed.
    void update(Index geometry);

    /// Builds or refits what has changed.
    void commit();

    /// Closest hits. `coherent` rays (neighbours side by side) go 16 wide, others 8 wide. hits.size() == rays.size().
    void intersect(std::span<const Ray> rays, bool coherent, std::span<Hit> hits) const;

    /// True at i where ray i meets anything in [nearest, farthest].
    void occluded(std::span<const Ray> rays, std::span<unsigned char> blocked) const;

    /// Embree's own handle (RTCScene), for measuring bare calls.
    [[nodiscard]] void *native() const;

  private:
    struct State;
    std::unique_ptr<State> state_;
};

} // namespace taut
