#pragma once
/// Errors of gradient estimators and of interpolation schemes against closed forms: a parametric surface P(u, v) deformed by
/// deformers whose Jacobian is known, so that V is known at every point.

#include "taut/deform/gradient_interpolation.h"
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

/// Relative errors of V: |V - V_true| / |V_true| in the Frobenius norm.
struct GradientError {
    double rms = 0;
    double largest = 0;
    double nanoseconds = 0; ///< of the evaluation, a vertex
};

/// At the vertices of n x n quads, without those on the border, where fits are one-sided.
GradientError estimatorError(const GradientCase &c, GradientEstimator estimator, int n);

/// At a point inside every triangle, V interpolated from exact values at its corners.
GradientError interpolationError(const GradientCase &c, GradientInterpolation scheme, int n);

/// The order p of an error that falls like h^p from n to 2 n.
double observedOrder(double coarse, double fine);

} // namespace taut::chart
