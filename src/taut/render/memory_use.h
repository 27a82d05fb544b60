#pragma once
/// What the meshes of a scene occupy while they are rendered, beside the least that they could.

#include "taut/render/render_scene.h"

namespace taut {

/// Bytes, by what they are for.
struct MemoryUse {
    std::size_t triangles = 0;
    std::size_t vertices = 0; ///< of the rendered surfaces
    std::size_t embree = 0;   ///< BVHs and quads, as Embree itself counts
    std::size_t shown = 0;    ///< what hits read: indices, pairs, positions, normals, tangents, UVs, stretch
    std::size_t motion = 0;   ///< what brings them to the next frame: rest frames, stencils, gradients
    std::size_t source = 0;   ///< meshes as they were read
    std::size_t policy = 0;   ///< for choosing between refit and rebuild
    [[nodiscard]] std::size_t rendering() const { return embree + shown + motion + policy; }
    [[nodiscard]] std::size_t total() const { return rendering() + source; }
    /// Embree's BVHs and quads, indices, and position, normal, UV, ds and dt at every vertex.
    [[nodiscard]] std::size_t least() const { return embree + 12 * triangles + (12 + 12 + 8 + 24) * vertices; }
};

/// Meshes that objects share count once.
MemoryUse memoryUse(const RenderScene &scene);

} // namespace taut
