#include "study/measures/gradient_error.h"

#include "taut/base/frame.h"
#include "taut/base/parallel.h"
#include "taut/deform/face_gradient.h"

#include <algorithm>
#include <array>

namespace taut::chart {

namespace {

double norm(const SymmetricTensor &t) {
    return std::sqrt(static_cast<double>(glm::dot(t.diagonal, t.diagonal) + 2 * glm::dot(t.offDiagonal, t.offDiagonal)));
}

/// Relative error of tensors in the Frobenius norm.
double relativeDifference(const SymmetricTensor &a, const SymmetricTensor &b) {
    return norm({a.diagonal - b.diagonal, a.offDiagonal - b.offDiagonal}) / norm(b);
}

GradientError errorOf(const std::vector<double> &errors) {
    GradientError error;
    for (const double e : errors) {
        error.rms += e * e;
        error.largest = std::max(error.largest, e);
    }
    error.rms = std::sqrt(error.rms / static_cast<double>(errors.size()));
    return error;
}

/// V at the render vertices of a surface.
void stretchesOf(const Surface &surface, const SurfaceGradient &gradient, std::vector<SymmetricTensor> &out) {
    out.resize(surface.vertexCount());
    parallelFor(out.size(), 2048, [&](std::size_t v) { out[v] = polarAt(surface, gradient, v).stretch; });
}

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

SurfaceStretches::SurfaceStretches(const GradientCase &c, GradientEstimator estimator, int n, std::optional<int> level)
    : case_(c), estimator_(estimator), n_(n), mesh_(meshOf(c, n)) {
    SurfaceOptions options;
    options.fit = fitOf(estimator); // what is constant on faces has its normals from it
    if (level) {
        SubdivisionOptions subdivision;
        subdivision.level = *level;
        subdivision_ = subdivide(mesh_, subdivision);
        if (estimator == GradientEstimator::Limit) {
            options.limit = &*subdivision_;
            options.cage = mesh_.positions;
        }
    }
    const Mesh &mesh = subdivision_ ? subdivision_->mesh : mesh_;
    surface_ = buildSurface(mesh, options);
    motion_ = motionOf(c, mesh_);
    if (!onFaces()) return;
    std::vector<Vec3> rest;
    for (const Index s : surface_.vertexSurface) rest.push_back(mesh.positions[surface_.surfacePosition[s]]);
    metrics_ = restMetrics(surface_, rest);
}

void SurfaceStretches::evaluate() {
    if (!subdivision_) {
        evaluateGradient(surface_, motion_, mesh_.skin, onFaces() ? GradientEstimator::Area : estimator_, case_.name, gradient_);
    } else {
        evaluatePositions(motion_, mesh_.skin, deformed_);
        const bool limit = estimator_ == GradientEstimator::Limit;
        if (!limit) applyStencils(subdivision_->positions, deformed_, refined_);
        fitGradient(surface_, limit ? deformed_ : refined_, false, case_.name, gradient_);
    }
    if (onFaces()) {
        spreadToVertices(surface_, gradient_, frame_);
        faceStretches(surface_, metrics_, frame_.positions, stretch_);
    } else {
        stretchesOf(surface_, gradient_, stretch_);
    }
}

GradientError SurfaceStretches::error() const {
    std::vector<DVec3> rest;
    std::vector<DVec3> deformed;
    for (std::size_t i = 0; i < mesh_.positions.size(); ++i) {
        rest.emplace_back(mesh_.positions[i]);
        deformed.push_back(deformedPoint(case_, rest.back(), static_cast<double>(mesh_.uvs[i].y)));
    }
    const double border = subdivision_ ? 1.0 / n_ - 1e-6 : onFaces() ? -1 : 1e-9;
    std::vector<double> errors;
    for (std::size_t i = 0; i < stretch_.size(); ++i) {
        // What a hit at a triangle's corner reads.
        const DVec2 uv(surface_.uvs[onFaces() ? surface_.triangles[i].x : i]);
        if (std::min(uv.x, uv.y) < border || std::max(uv.x, uv.y) > 1 - border) continue;
        const SymmetricTensor exact =
            subdivision_ ? stretchBetween(splineTangents(rest, n_, uv), splineTangents(deformed, n_, uv)) : truthAt(case_, uv.x, uv.y).v;
        errors.push_back(relativeDifference(stretch_[i], exact));
    }
    return errorOf(errors);
}

GradientError estimatorError(const GradientCase &c, GradientEstimator estimator, int n, std::optional<int> level) {
    SurfaceStretches run(c, estimator, n, level);
    run.evaluate();
    return run.error();
}

HitStretches::HitStretches(const GradientCase &c, GradientInterpolation scheme, int n) : scheme_(scheme) {
    const auto corner = [n](int i, int j) { return static_cast<Index>(j * (n + 1) + i); };
    for (int j = 0; j <= n; ++j)
        for (int i = 0; i <= n; ++i) {
            const GradientTruth truth = truthAt(c, static_cast<double>(i) / n, static_cast<double>(j) / n);
            const Frame frame = smoothFrameFromNormal(Vec3(truth.n));
            stored_.push_back(encodeStretch(scheme, truth.v, frame.s, frame.t, frame.n));
            if (scheme != GradientInterpolation::DsDt) continue;
            ds_.emplace_back(truth.ds);
            dt_.emplace_back(truth.dt);
        }
    // Off the centroid, where second-order terms of a uniform grid could cancel.
    constexpr std::array<double, 3> kAt{0.5, 0.2, 0.3};
    for (int j = 0; j < n; ++j)
        for (int i = 0; i < n; ++i)
            for (const auto &offsets : {std::array<int, 6>{0, 0, 1, 0, 1, 1}, std::array<int, 6>{0, 0, 1, 1, 0, 1}}) {
                Index3 corners;
                DVec2 uv(0);
                for (int k = 0; k < 3; ++k) {
                    const auto at = static_cast<std::size_t>(k);
                    corners[k] = corner(i + offsets[2 * at], j + offsets[2 * at + 1]);
                    uv += kAt[at] * DVec2(i + offsets[2 * at], j + offsets[2 * at + 1]) / static_cast<double>(n);
                }
                const GradientTruth truth = truthAt(c, uv.x, uv.y);
                const Frame frame = smoothFrameFromNormal(Vec3(truth.n));
                hits_.push_back({corners, Vec3(DVec3(kAt[0], kAt[1], kAt[2])), frame.s, frame.t});
                exact_.push_back(seenIn(truth.v, frame.s, frame.t));
            }
    if (scheme != GradientInterpolation::Face) return;
    for (const Hit &hit : hits_) faces_.push_back(mixed(stored_, hit.corners, Vec3(1.0F / 3)));
}

SymmetricTensor HitStretches::mixed(const std::vector<SymmetricTensor> &at, const Index3 &t, const Vec3 &b) {
    return {at[t.x].diagonal * b.x + at[t.y].diagonal * b.y + at[t.z].diagonal * b.z,
            at[t.x].offDiagonal * b.x + at[t.y].offDiagonal * b.y + at[t.z].offDiagonal * b.z};
}

void HitStretches::evaluate() {
    stretch_.resize(hits_.size());
    for (std::size_t i = 0; i < hits_.size(); ++i) {
        const Hit &hit = hits_[i];
        const Index3 &t = hit.corners;
        const Vec3 &b = hit.weights;
        if (scheme_ == GradientInterpolation::DsDt) {
            const Vec3 ds = ds_[t.x] * b.x + ds_[t.y] * b.y + ds_[t.z] * b.z;
            const Vec3 dt = dt_[t.x] * b.x + dt_[t.y] * b.y + dt_[t.z] * b.z;
            stretch_[i] = polarInFrame({glm::dot(hit.s, ds), glm::dot(hit.t, ds)}, {glm::dot(hit.s, dt), glm::dot(hit.t, dt)}).stretch;
        } else if (scheme_ == GradientInterpolation::Face) {
            stretch_[i] = seenIn(faces_[i], hit.s, hit.t);
        } else {
            stretch_[i] = decodeStretch(scheme_, mixed(stored_, t, b), hit.s, hit.t);
        }
    }
}

GradientError interpolationError(const GradientCase &c, GradientInterpolation scheme, int n) {
    HitStretches run(c, scheme, n);
    run.evaluate();
    std::vector<double> errors;
    const auto frobenius = [](const Vec3 &t) { return std::sqrt(static_cast<double>(t.x * t.x + 2 * t.y * t.y + t.z * t.z)); };
    for (std::size_t i = 0; i < run.stretch().size(); ++i)
        errors.push_back(frobenius(run.stretch()[i] - run.exact()[i]) / frobenius(run.exact()[i]));
    return errorOf(errors);
}

double observedOrder(double coarse, double fine) {
    return std::log2(coarse / fine);
}

} // namespace taut::chart
