#pragma once
/// Errors of gradient estimators on limit surfaces against B-splines.

#include "study/gradient_error.h"

#include "taut/mesh/subdivide.h"

namespace taut::chart {

/// V at the vertices of the limit surface of a cage of n x n quads, refined `level` times: the cage's points are deformed. On a regular
/// grid the limit is the bicubic B-spline, whose derivatives are known.
class LimitStretches {
  public:
    LimitStretches(const GradientCase &c, GradientEstimator estimator, int n, int level);
    LimitStretches(const LimitStretches &) = delete;
    LimitStretches &operator=(const LimitStretches &) = delete;
    void evaluate();
    /// Without vertices within one quad of the cage's border, where there are no B-splines.
    [[nodiscard]] GradientError error() const;
    [[nodiscard]] std::size_t vertexCount() const { return surface_.vertexCount(); }

  private:
    GradientCase case_;
    GradientEstimator estimator_;
    int n_;
    Mesh cage_;
    Subdivision subdivision_;
    Surface surface_;
    MotionState motion_;
    std::vector<Vec3> deformed_, refined_; // points of the cage, and of the limit where a fit wants them
    std::vector<Vec3> metrics_;
    SurfaceGradient gradient_;
    SurfaceFrame frame_;
    std::vector<SymmetricTensor> stretch_;
};

} // namespace taut::chart
