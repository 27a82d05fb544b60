#pragma once
/// Surfaces under deformations whose gradient is known in closed form: a parametric surface P(u, v) deformed by deformers whose Jacobian
/// is known, so that V is known at every point.

#include "taut/deform/stretch.h"
#include "taut/deform/surface_motion.h"

#include <string>
#include <vector>

namespace taut::chart {

enum class Shape { Plane, Cylinder, Sphere, Torus };

/// One surface under one deformation, at one time.
struct GradientCase {
    std::string name;
    Shape shape = Shape::Plane;
    std::vector<DeformerKeys> deformers;
    bool skinned = false; ///< a bend by two joints with smooth weights, before the deformers
};

/// Twist, bend, shear and sine wave on every shape, and a skinned bend.
std::vector<GradientCase> gradientCases();

/// What the gradient of the deformed surface is at a point, in double.
struct GradientTruth {
    DVec3 ds, dt; ///< images of an orthonormal tangent frame, s along dP/du
    DVec3 n;      ///< unit
    SymmetricTensor v;
};
GradientTruth truthAt(const GradientCase &c, double u, double v);

/// Where a point of the undeformed surface at parameter v goes.
DVec3 deformedPoint(const GradientCase &c, const DVec3 &rest, double v);

/// n x n quads over u, v in [0, 1], which are its uvs; with exact normals, and weights where the case is skinned.
Mesh meshOf(const GradientCase &c, int n);
/// What moves the mesh; it views the mesh's positions.
MotionState motionOf(const GradientCase &c, const Mesh &mesh);

} // namespace taut::chart
