#pragma once
/// Errors of gradient estimators and of interpolation schemes against closed forms, and what their evaluation is timed by.

#include "study/scenes/gradient_cases.h"

#include "taut/deform/estimators.h"
#include "taut/mesh/subdivide.h"

#include <optional>

namespace taut::chart {

/// Relative errors of V: |V - V_true| / |V_true| in the Frobenius norm.
struct GradientError {
    double rms = 0;
    double largest = 0;
};

/// V at the vertices (Face: on the triangles) of n x n quads, by an estimator: all that a frame does for it, positions included. With a
/// level: of the limit surface, refined so often, of a cage of n x n quads, whose points are deformed. On a regular grid the limit is the
/// bicubic B-spline, whose derivatives are known.
class SurfaceStretches {
  public:
    SurfaceStretches(const GradientCase &c, GradientEstimator estimator, int n, std::optional<int> level = {});
    SurfaceStretches(const SurfaceStretches &) = delete;
    SurfaceStretches &operator=(const SurfaceStretches &) = delete;
    void evaluate();
    /// Without vertices on the border, where fits are one-sided; of limits within one quad of it, where there are no B-splines.
    [[nodiscard]] GradientError error() const;
    [[nodiscard]] const Surface &surface() const { return surface_; }

  private:
    [[nodiscard]] bool onFaces() const { return estimator_ == GradientEstimator::Face; }

    GradientCase case_;
    GradientEstimator estimator_;
    int n_;
    Mesh mesh_;
    std::optional<Subdivision> subdivision_;
    Surface surface_;
    MotionState motion_;
    std::vector<Vec3> deformed_, refined_; // points of the cage, and of the limit where a fit wants them
    std::vector<Vec3> metrics_;
    SurfaceGradient gradient_;
    DeformedVertices frame_;
    std::vector<SymmetricTensor> stretch_;
};

/// V at a point inside every triangle of n x n quads, interpolated from exact values at its corners.
class HitStretches {
  public:
    HitStretches(const GradientCase &c, GradientInterpolation scheme, int n);
    void evaluate();
    /// (ss, st, tt) in the frame of the hit.
    [[nodiscard]] const std::vector<Vec3> &stretch() const { return stretch_; }
    [[nodiscard]] const std::vector<Vec3> &exact() const { return exact_; }

  private:
    struct Hit {
        Index3 corners;
        Vec3 weights;
        Vec3 s, t;
    };
    static SymmetricTensor mixed(const std::vector<SymmetricTensor> &at, const Index3 &t, const Vec3 &b);

    GradientInterpolation scheme_;
    std::vector<SymmetricTensor> stored_; // [corners]
    std::vector<SymmetricTensor> faces_;  // [triangles]
    std::vector<Vec3> ds_, dt_;           // [corners]
    std::vector<Hit> hits_;
    std::vector<Vec3> exact_, stretch_;
};

GradientError estimatorError(const GradientCase &c, GradientEstimator estimator, int n, std::optional<int> level = {});

/// At a point inside every triangle.
GradientError interpolationError(const GradientCase &c, GradientInterpolation scheme, int n);

/// The order p of an error that falls like h^p from n to 2 n.
double observedOrder(double coarse, double fine);

} // namespace taut::chart
