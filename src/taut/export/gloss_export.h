#pragma once
/// Objects of a scene as GlossMesh, frame by frame: what `taut export` writes. No image, no Embree.

#include "taut/export/gloss_mesh.h"
#include "taut/scene/object_surface.h"

namespace taut {

struct GlossOptions {
    bool restPositions = false; ///< positions, normals and tangents of the undeformed mesh, object space; M is that of the frame
    const ConventionInfo *convention = nullptr;
};

/// One object with its buffers.
struct GlossObject {
    ObjectSurface surface;
    GlossMesh mesh;
    std::vector<Index> sources;   ///< [vertices of mesh] -> render vertex of the surface
    std::vector<Index> materials; ///< [vertices of mesh] -> material of the scene
    std::vector<Vec2> restAlphas; ///< [vertices of mesh] alpha along and across the tangent, in the place of the material's; may be empty
    bool rigid = false;
    std::vector<unsigned char> flipped; ///< [triangles] of mesh: turned over
    std::size_t clipped = 0;            ///< vertices outside the convention's limits, summed over frames
};

/// Topology and what no frame changes. A render vertex that faces of several materials share becomes one vertex for each.
/// Keeps references to the scene.
void prepareGlossObject(const Scene &scene, const Object &object, GlossObject &out);

/// Brings `object.mesh` to a frame.
void glossAtFrame(const Scene &scene, double frame, const GlossOptions &options, GlossObject &object);

/// Positions of the mesh's own points (of the refined mesh under subdivision) at a frame, in the file's order: what point caches
/// hold. In world space, or in object space: deformed, but without the object's placement. Throws RunError where that is flat.
enum class PointSpace { World, Object };
void pointsAtFrame(const Scene &scene, double frame, PointSpace space, GlossObject &object, std::vector<Vec3> &out);

} // namespace taut
