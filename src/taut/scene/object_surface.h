#pragma once
/// One object of a scene as a deforming surface: topology built once, positions, normals and surface gradient at any frame.
/// What the renderer traces and what `taut export` writes.

#include "taut/mesh/subdivide.h"
#include "taut/scene/object_motion.h"

#include <optional>

namespace taut {

/// Buffers of one object. "Target space" is wherever `targetFromWorld` of the last evaluation leads: camera space for the
/// renderer, world space for the export.
struct ObjectSurface {
    const Object *object = nullptr;
    std::optional<Subdivision> subdivision;
    Surface surface;
    ObjectMotion motion;
    GradientEstimator estimator = GradientEstimator::Analytic;
    std::vector<Vec3> cage;      ///< subdivision: control points in target space
    Orientation cageOrientation; ///< subdivision: of the map at the control points
    std::vector<Vec3> refined;   ///< subdivision, estimators other than Limit: limit points in target space
    SurfaceGradient gradient;
    DeformedVertices vertices;         ///< filled by surfaceAtFrame
    bool mirrored = false;             ///< triangles are seen the other way round
    std::vector<unsigned char> turned; ///< [triangles] the same for each, where they differ; else empty

    [[nodiscard]] bool isMirrored(Index triangle) const { return turned.empty() ? mirrored : turned[triangle] != 0; }
    [[nodiscard]] const Mesh &mesh() const { return subdivision ? subdivision->mesh : *object->mesh; }
};

/// The material slot of a triangle.
inline Index slotOfTriangle(const ObjectSurface &object, Index triangle) {
    return object.surface.triangleSlots.empty() ? 0 : object.surface.triangleSlots[triangle];
}

/// The material of a triangle, an index into Scene::materials: by its slot, or the object's last one; the scene's first where the object
/// has none.
inline Index materialOfTriangle(const ObjectSurface &object, Index triangle) {
    const std::vector<Index> &materials = object.object->materials;
    if (materials.empty()) return 0;
    return materials[std::min<std::size_t>(slotOfTriangle(object, triangle), materials.size() - 1)];
}

/// What an object uses where neither its file nor a plan says: Limit under subdivision, else Analytic.
GradientEstimator defaultEstimator(const Object &object);

/// Builds topology and the rest state. Keeps a reference to `object`.
void prepareObjectSurface(const Object &object, double fps, GradientEstimator estimator, int subdivisionLevel, ObjectSurface &out);
/// With the object's default estimator and its own level.
void prepareObjectSurface(const Object &object, double fps, ObjectSurface &out);

/// Gives back what evaluating frames has no use for: the surface has taken over what it needs of a subdivision.
void compact(ObjectSurface &object);

/// Positions and gradient of the surface vertices at a frame, in target space. Adds the seconds that positions took to
/// `deformationSeconds`, those of gradients to `gradientSeconds`.
void deformAtFrame(ObjectSurface &object, double frame, double fps, const DMat4 &targetFromWorld, double &deformationSeconds,
                   double &gradientSeconds);

/// deformAtFrame(), spread to the render vertices: positions, normals, ds and dt in object.vertices.
void surfaceAtFrame(ObjectSurface &object, double frame, double fps, const DMat4 &targetFromWorld, double &deformationSeconds,
                    double &gradientSeconds);

} // namespace taut
