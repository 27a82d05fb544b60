#include "study/limit_error.h"

#include "taut/deform/face_gradient.h"

#include <algorithm>
#include <array>

namespace taut::chart {

namespace {

/// Basis functions of the uniform cubic B-spline at t in [0, 1], and their derivatives.
using Weights = std::array<double, 4>;
Weights splineWeights(double t) {
    return {(1 - t) * (1 - t) * (1 - t) / 6, (3 * t * t * t - 6 * t * t + 4) / 6, (-3 * t * t * t + 3 * t * t + 3 * t + 1) / 6,
            t * t * t / 6};
}
Weights splineSlopes(double t) {
    return {-(1 - t) * (1 - t) / 2, (3 * t * t - 4 * t) / 2, (-3 * t * t + 2 * t + 1) / 2, t * t / 2};
}

/// dP/du and dP/dv of the bicubic B-spline over (n + 1)^2 control points, rows of rising v.
struct Tangents {
    DVec3 du{0}, dv{0};
};
Tangents splineTangents(const std::vector<DVec3> &points, int n, const DVec2 &uv) {
    const DVec2 at = uv * static_cast<double>(n);
    const int i = std::clamp(static_cast<int>(at.x + 1e-4), 1, n - 2);
    const int j = std::clamp(static_cast<int>(at.y + 1e-4), 1, n - 2);
    const Weights wu = splineWeights(at.x - i);
    const Weights wv = splineWeights(at.y - j);
    const Weights su = splineSlopes(at.x - i);
    const Weights sv = splineSlopes(at.y - j);
    Tangents t;
    for (std::size_t b = 0; b < 4; ++b)
        for (std::size_t a = 0; a < 4; ++a) {
            const std::size_t row = static_cast<std::size_t>(j - 1) + b;
            const DVec3 &p = points[row * static_cast<std::size_t>(n + 1) + static_cast<std::size_t>(i - 1) + a];
            t.du += su[a] * wv[b] * p;
            t.dv += wu[a] * sv[b] * p;
        }
    return t;
}

/// V of the map that takes one pair of tangents to another.
SymmetricTensor stretchBetween(const Tangents &rest, const Tangents &deformed) {
    const DVec3 e1 = glm::normalize(rest.du);
    const double along = glm::dot(e1, rest.dv);
    const double across = glm::length(rest.dv - e1 * along);
    const DVec3 ds = deformed.du / glm::length(rest.du);
    const DVec3 dt = (deformed.dv - ds * along) / across;
    return polarGradient(Vec3(ds), Vec3(dt), Vec3(glm::normalize(glm::cross(ds, dt)))).stretch;
}

} // namespace

LimitStretches::LimitStretches(const GradientCase &c, GradientEstimator estimator, int n, int level)
    : case_(c), estimator_(estimator), n_(n), cage_(meshOf(c, n)) {
    SubdivisionOptions subdivision;
    subdivision.level = level;
    subdivision_ = subdivide(cage_, subdivision);
    SurfaceOptions options;
    if (estimator == GradientEstimator::Limit) {
        options.limit = &subdivision_;
        options.cage = cage_.positions;
    } else {
        options.fit = fitOf(estimator);
    }
    surface_ = buildSurface(subdivision_.mesh, options);
    motion_ = motionOf(c, cage_);
    if (estimator == GradientEstimator::Face) metrics_ = metricsOf(subdivision_.mesh, surface_);
}

void LimitStretches::evaluate() {
    evaluatePositions(motion_, cage_.skin, deformed_);
    if (estimator_ == GradientEstimator::Limit) {
        fitGradient(surface_, deformed_, false, case_.name, gradient_);
    } else {
        applyStencils(subdivision_.positions, deformed_, refined_);
        fitGradient(surface_, refined_, false, case_.name, gradient_);
    }
    if (estimator_ == GradientEstimator::Face) {
        spreadToVertices(surface_, gradient_, frame_);
        faceStretches(surface_, metrics_, frame_.positions, stretch_);
    } else {
        stretchesOf(surface_, gradient_, stretch_);
    }
}

GradientError LimitStretches::error() const {
    std::vector<DVec3> rest;
    std::vector<DVec3> deformed;
    for (std::size_t i = 0; i < cage_.positions.size(); ++i) {
        rest.emplace_back(cage_.positions[i]);
        deformed.push_back(deformedPoint(case_, rest.back(), static_cast<double>(cage_.uvs[i].y)));
    }
    const bool onFaces = estimator_ == GradientEstimator::Face;
    const double border = 1.0 / n_ - 1e-6;
    GradientError error;
    std::size_t count = 0;
    for (std::size_t i = 0; i < stretch_.size(); ++i) {
        const DVec2 uv(surface_.uvs[onFaces ? surface_.triangles[i].x : i]);
        if (std::min(uv.x, uv.y) < border || std::max(uv.x, uv.y) > 1 - border) continue;
        const SymmetricTensor exact = stretchBetween(splineTangents(rest, n_, uv), splineTangents(deformed, n_, uv));
        add(error, relativeDifference(stretch_[i], exact));
        ++count;
    }
    return finished(error, count);
}

} // namespace taut::chart
