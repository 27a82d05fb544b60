#pragma once
/// A mesh that shines, triangle by triangle. Its positions belong to the frame's geometry.

#include "taut/render/surface_step.h"
#include "taut/scene/lights/light.h"

namespace taut {

struct MeshEmitter {
    std::span<const SurfaceStep> steps; ///< at equally spaced times in the shutter
    std::span<const Affine> placements; ///< of an instanced object, whose one step is in local space
    std::span<const Index3> triangles;
    bool twoSided = false;
    bool mirrored = false;
    std::span<const unsigned char> turned; ///< ObjectSurface::turned
    [[nodiscard]] float side(Index triangle) const { return (turned.empty() ? mirrored : turned[triangle] != 0) ? -1.0F : 1.0F; }
};

/// Whether both read the same memory: what stands there may have changed.
bool operator==(const MeshEmitter &a, const MeshEmitter &b);

/// Corner of a triangle at a time in the shutter.
Vec3 emitterPosition(const MeshEmitter &emitter, Index vertex, float time);

/// Area of a triangle at a time in the shutter.
float emitterArea(const MeshEmitter &emitter, Index triangle, float time);

/// A sample of a triangle, the choice of it left out.
LightSample sampleEmitter(const MeshEmitter &emitter, Index triangle, const Vec3 &radiance, const Vec3 &point, float time,
                          const Vec2 &number);

/// Bounds of a triangle while the shutter is open.
LightBounds emitterBounds(const MeshEmitter &emitter, Index triangle, float strength);

} // namespace taut
