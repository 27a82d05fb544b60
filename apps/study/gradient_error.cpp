#include "study/gradient_error.h"

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

} // namespace

double relativeDifference(const SymmetricTensor &a, const SymmetricTensor &b) {
    return norm({a.diagonal - b.diagonal, a.offDiagonal - b.offDiagonal}) / norm(b);
}

void add(GradientError &error, double e) {
    error.rms += e * e;
    error.largest = std::max(error.largest, e);
}
GradientError finished(GradientError error, std::size_t count) {
    error.rms = std::sqrt(error.rms / static_cast<double>(count));
    return error;
}

std::vector<Vec3> metricsOf(const Mesh &mesh, const Surface &surface) {
    std::vector<Vec3> rest;
    for (const Index s : surface.vertexSurface) rest.push_back(mesh.positions[surface.surfacePosition[s]]);
    return restMetrics(surface, rest);
}

VertexStretches::VertexStretches(const GradientCase &c, GradientEstimator estimator, int n)
    : name_(c.name), mesh_(meshOf(c, n)), estimator_(estimator) {
    SurfaceOptions options;
    options.fit = fitOf(estimator);
    surface_ = buildSurface(mesh_, options);
    motion_ = motionOf(c, mesh_);
    if (estimator == GradientEstimator::Face) metrics_ = metricsOf(mesh_, surface_);
}

void VertexStretches::evaluate() {
    const bool onFaces = estimator_ == GradientEstimator::Face;
    // What is constant on faces has its normals from a fit, as in the renderer.
    evaluateGradient(surface_, motion_, mesh_.skin, onFaces ? GradientEstimator::Area : estimator_, name_, gradient_);
    if (onFaces) {
        spreadToVertices(surface_, gradient_, frame_);
        faceStretches(surface_, metrics_, frame_.positions, stretch_);
    } else {
        stretchesOf(surface_, gradient_, stretch_);
    }
}

void stretchesOf(const Surface &surface, const SurfaceGradient &gradient, std::vector<SymmetricTensor> &out) {
    out.resize(surface.vertexCount());
    parallelFor(out.size(), 2048, [&](std::size_t v) { out[v] = polarAt(surface, gradient, v).stretch; });
}

GradientError estimatorError(const GradientCase &c, GradientEstimator estimator, int n) {
    VertexStretches run(c, estimator, n);
    run.evaluate();
    const Surface &surface = run.surface();
    const bool onFaces = estimator == GradientEstimator::Face;
    GradientError error;
    std::size_t count = 0;
    for (std::size_t i = 0; i < run.stretch().size(); ++i) {
        // What a hit at a triangle's corner reads.
        const DVec2 uv(surface.uvs[onFaces ? surface.triangles[i].x : i]);
        if (!onFaces && (std::min(uv.x, uv.y) <= 0 || std::max(uv.x, uv.y) >= 1)) continue;
        add(error, relativeDifference(run.stretch()[i], truthAt(c, uv.x, uv.y).v));
        ++count;
    }
    return finished(error, count);
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
    GradientError error;
    const auto frobenius = [](const Vec3 &t) { return std::sqrt(static_cast<double>(t.x * t.x + 2 * t.y * t.y + t.z * t.z)); };
    for (std::size_t i = 0; i < run.stretch().size(); ++i)
        add(error, frobenius(run.stretch()[i] - run.exact()[i]) / frobenius(run.exact()[i]));
    return finished(error, run.stretch().size());
}

double observedOrder(double coarse, double fine) {
    return std::log2(coarse / fine);
}

} // namespace taut::chart
