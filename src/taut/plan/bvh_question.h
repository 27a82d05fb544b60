#pragma once
/// What is done to the BVHs of the meshes that deform. The choice changes no picture beyond rounding, so that time alone decides.

#include "taut/plan/bvh_policy.h"
#include "taut/plan/question.h"
#include "taut/scene/object_surface.h"

namespace taut {

/// A mesh that deforms, as the choice between kinds of BVH sees it.
struct DeformingMesh {
    std::size_t triangles = 0;
    bool blurred = false; ///< several times in the shutter: Embree refits none of these
};
/// Whether BVHs that can be refitted pay for a scene with these meshes and about this many rays a frame: they are updated ten times
/// quicker than a fresh one is built, and traced more slowly.
bool refitsPay(std::span<const DeformingMesh> meshes, double rays, const BvhCosts &costs = {});

/// Triangles of an object that is refined to a level, without building them. More than there will be where faces of the cage repeat a
/// corner.
std::size_t triangleCount(const Object &object, int subdivisionLevel);

/// The kind that pays for a scene whose objects are refined to these levels.
BvhKind chooseBvh(const Scene &scene, std::span<const int> levels, const BvhCosts &costs = {});

/// What the policy will do with a mesh, by its shape at some of its frames.
class BvhForecast {
  public:
    explicit BvhForecast(double rays, const BvhCosts &costs = {}) : rays_(rays), costs_(costs) {}

    /// Every so many-th frame of `frames` is looked at.
    [[nodiscard]] static std::size_t stride(std::size_t frames);
    /// Takes in the next frame of the object as it stands (deformAtFrame).
    void add(const ObjectSurface &object);

    /// The question as its own: `kind` is the scene's; named is what most frames get.
    [[nodiscard]] Question question(BvhKind kind) const;

  private:
    double rays_;
    BvhCosts costs_;
    BvhPolicy policy_;
    std::vector<Vec3> positions_; // [render vertices + 1], as Embree has them
    std::size_t triangles_ = 0;
    double refitSeconds_ = 0;        // sum over the frames after the first
    int frames_ = -1, rebuilds_ = 0; // after the first; of them with a new build
};

} // namespace taut
