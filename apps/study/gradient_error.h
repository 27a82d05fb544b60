#pragma once
/// Errors of gradient estimators and of interpolation schemes against closed forms, and what their evaluation is timed by.

#include "study/gradient_cases.h"

#include "taut/deform/estimators.h"

namespace taut::chart {

/// V at the vertices (Face: on the triangles) of n x n quads, by an estimator: all that a frame does for it, positions included.
class VertexStretches {
  public:
    VertexStretches(const GradientCase &c, GradientEstimator estimator, int n);
    VertexStretches(const VertexStretches &) = delete;
    VertexStretches &operator=(const VertexStretches &) = delete;
    void evaluate();
    [[nodiscard]] const Surface &surface() const { return surface_; }
    [[nodiscard]] const std::vector<SymmetricTensor> &stretch() const { return stretch_; }

  private:
    std::string name_;
    Mesh mesh_;
    GradientEstimator estimator_;
    Surface surface_;
    MotionState motion_;
    std::vector<Vec3> metrics_;
    SurfaceGradient gradient_;
    SurfaceFrame frame_;
    std::vector<SymmetricTensor> stretch_;
};

/// restMetrics() of a mesh that is at rest as it stands.
std::vector<Vec3> metricsOf(const Mesh &mesh, const Surface &surface);
/// V at the render vertices of a surface.
void stretchesOf(const Surface &surface, const SurfaceGradient &gradient, std::vector<SymmetricTensor> &out);

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

/// Relative errors of V: |V - V_true| / |V_true| in the Frobenius norm.
struct GradientError {
    double rms = 0;
    double largest = 0;
};

/// At the vertices of n x n quads, without those on the border, where fits are one-sided.
GradientError estimatorError(const GradientCase &c, GradientEstimator estimator, int n);

/// At a point inside every triangle.
GradientError interpolationError(const GradientCase &c, GradientInterpolation scheme, int n);

/// Relative error |a - b| / |b| of tensors in the Frobenius norm.
double relativeDifference(const SymmetricTensor &a, const SymmetricTensor &b);
/// Adds one error to the sum that finished() turns into a mean.
void add(GradientError &error, double e);
GradientError finished(GradientError error, std::size_t count);

/// The order p of an error that falls like h^p from n to 2 n.
double observedOrder(double coarse, double fine);

} // namespace taut::chart
