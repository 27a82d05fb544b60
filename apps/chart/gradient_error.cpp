#include "chart/gradient_error.h"

#include "taut/base/frame.h"
#include "taut/base/stopwatch.h"
#include "taut/deform/face_gradient.h"

#include <algorithm>
#include <array>

namespace taut::chart {

namespace {

constexpr double kPiD = 3.14159265358979323846;

/// A point of a shape with its tangents dP/du, dP/dv.
struct PointOfShape {
    DVec3 p, du, dv;
};

/// Open patches, so that no seam mixes into an order of convergence; u, v in [0, 1].
PointOfShape pointOf(Shape shape, double u, double v) {
    switch (shape) {
    case Shape::Plane: return {{2 * u - 1, 2 * v - 1, 0}, {2, 0, 0}, {0, 2, 0}};
    case Shape::Cylinder: {
        const double a = 4 * u;
        return {{0.6 * std::cos(a), 0.6 * std::sin(a), 2 * v - 1}, {-2.4 * std::sin(a), 2.4 * std::cos(a), 0}, {0, 0, 2}};
    }
    case Shape::Sphere: {
        const double a = 4 * u;
        const double b = -1 + 2 * v;
        return {{std::cos(a) * std::cos(b), std::sin(a) * std::cos(b), std::sin(b)},
                {-4 * std::sin(a) * std::cos(b), 4 * std::cos(a) * std::cos(b), 0},
                {-2 * std::cos(a) * std::sin(b), -2 * std::sin(a) * std::sin(b), 2 * std::cos(b)}};
    }
    case Shape::Torus: {
        const double a = 4 * u;
        const double b = 5 * v;
        const double r = 1 + 0.4 * std::cos(b);
        return {{r * std::cos(a), r * std::sin(a), 0.4 * std::sin(b)},
                {-4 * r * std::sin(a), 4 * r * std::cos(a), 0},
                {-2 * std::sin(b) * std::cos(a), -2 * std::sin(b) * std::sin(a), 2 * std::cos(b)}};
    }
    }
    return {};
}

/// Weight of the second joint and its derivative along v: a smooth step.
DVec2 jointWeight(double v) {
    return {v * v * (3 - 2 * v), 6 * v * (1 - v)};
}
/// The second joint turns about y.
DMat4 jointMatrix() {
    const double angle = 0.8;
    DMat4 m(1);
    m[0] = {std::cos(angle), 0, -std::sin(angle), 0};
    m[2] = {std::sin(angle), 0, std::cos(angle), 0};
    return m;
}

/// Deformed position, normal and V at a point, in double.
struct Truth {
    DVec3 ds, dt, n;
    SymmetricTensor v;
};

Truth truthAt(const GradientCase &c, double u, double v) {
    const PointOfShape s = pointOf(c.shape, u, v);
    const DVec3 e1 = glm::normalize(s.du);
    const DVec3 e2 = glm::normalize(s.dv - e1 * glm::dot(e1, s.dv));
    // Derivatives along unit tangents: du = |du| e1, dv = b e1 + d e2.
    const double a = glm::length(s.du);
    const double b = glm::dot(e1, s.dv);
    const double d = glm::dot(e2, s.dv);
    DVec3 x = s.p;
    DVec3 xu = s.du;
    DVec3 xv = s.dv;
    if (c.skinned) {
        const DVec2 w = jointWeight(v);
        const DMat4 m = jointMatrix();
        const DMat3 blend = DMat3(1) * (1 - w.x) + DMat3(m) * w.x;
        const DVec3 moved = DVec3(m * glm::dvec4(x, 1)) - x;
        xu = blend * xu;
        xv = blend * xv + moved * w.y;
        x = x + moved * w.x;
    }
    for (const DeformerKeys &keys : c.deformers) {
        const DeformedPoint image = deform(deformerAtFrame(keys, 1), x);
        x = image.position;
        xu = image.jacobian * xu;
        xv = image.jacobian * xv;
    }
    Truth t;
    t.ds = xu / a;
    t.dt = (xv - t.ds * b) / d;
    t.n = glm::normalize(glm::cross(t.ds, t.dt));
    t.v = polarGradient(Vec3(t.ds), Vec3(t.dt), Vec3(t.n)).stretch;
    return t;
}

Mesh meshOf(const GradientCase &c, int n) {
    Mesh mesh;
    mesh.name = c.name;
    const auto at = [n](int i, int j) { return static_cast<Index>(j * (n + 1) + i); };
    for (int j = 0; j <= n; ++j)
        for (int i = 0; i <= n; ++i) {
            const PointOfShape s = pointOf(c.shape, static_cast<double>(i) / n, static_cast<double>(j) / n);
            mesh.positions.emplace_back(s.p);
            mesh.normals.emplace_back(glm::normalize(glm::cross(s.du, s.dv)));
            mesh.uvs.emplace_back(static_cast<float>(i) / static_cast<float>(n), static_cast<float>(j) / static_cast<float>(n));
        }
    for (int j = 0; j < n; ++j)
        for (int i = 0; i < n; ++i) {
            for (const Index v : {at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)}) mesh.cornerPositions.push_back(v);
            mesh.faceOffsets.push_back(static_cast<Index>(mesh.cornerPositions.size()));
        }
    mesh.cornerNormals = mesh.cornerPositions;
    mesh.cornerUvs = mesh.cornerPositions;
    if (!c.skinned) return mesh;
    mesh.skin.offsets = {0};
    for (int j = 0; j <= n; ++j)
        for (int i = 0; i <= n; ++i) {
            const auto w = static_cast<float>(jointWeight(static_cast<double>(j) / n).x);
            mesh.skin.joints.insert(mesh.skin.joints.end(), {0, 1});
            mesh.skin.weights.insert(mesh.skin.weights.end(), {1 - w, w});
            mesh.skin.offsets.push_back(static_cast<Index>(mesh.skin.joints.size()));
        }
    return mesh;
}

double norm(const SymmetricTensor &t) {
    return std::sqrt(static_cast<double>(glm::dot(t.diagonal, t.diagonal) + 2 * glm::dot(t.offDiagonal, t.offDiagonal)));
}
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

DeformerKeys deformer(DeformerType type, double amount, int axis, int axis2) {
    DeformerKeys keys;
    keys.type = type;
    keys.amount = amount;
    keys.axis = axis;
    keys.axis2 = axis2;
    return keys;
}

} // namespace

std::vector<GradientCase> gradientCases() {
    DeformerKeys twist = deformer(DeformerType::Twist, 0.9, 2, 0);
    DeformerKeys bend = deformer(DeformerType::Bend, 0.8, 0, 2);
    for (DeformerKeys *keys : {&twist, &bend}) {
        keys->lower = -1.5;
        keys->upper = 1.5;
    }
    const DeformerKeys shear = deformer(DeformerType::Shear, 0.7, 0, 2);
    DeformerKeys wave = deformer(DeformerType::Wave, 0, 0, 2);
    wave.amplitude = 0.2;
    wave.wavelength = 1.7;
    std::vector<GradientCase> cases;
    for (const auto &[shape, name] : {std::pair(Shape::Plane, "plane"), std::pair(Shape::Cylinder, "cylinder"),
                                      std::pair(Shape::Sphere, "sphere"), std::pair(Shape::Torus, "torus")}) {
        cases.push_back({std::string("twist on ") + name, shape, {twist}, false});
        cases.push_back({std::string("bend on ") + name, shape, {bend}, false});
        cases.push_back({std::string("shear on ") + name, shape, {shear}, false});
        cases.push_back({std::string("sine on ") + name, shape, {wave}, false});
    }
    cases.push_back({"skinned bend of a cylinder", Shape::Cylinder, {}, true});
    return cases;
}

GradientError estimatorError(const GradientCase &c, GradientEstimator estimator, int n) {
    const Mesh mesh = meshOf(c, n);
    SurfaceOptions options;
    options.fit = estimator == GradientEstimator::Angle          ? GradientFit::Angle
                  : estimator == GradientEstimator::LeastSquares ? GradientFit::LeastSquares
                                                                 : GradientFit::Area;
    const Surface surface = buildSurface(mesh, options);
    MotionState motion;
    motion.control = mesh.positions;
    if (c.skinned) motion.joints = {Affine(1), Affine(jointMatrix())};
    for (const DeformerKeys &keys : c.deformers) motion.deformers.push_back(deformerAtFrame(keys, 1));
    SurfaceGradient gradient;
    const bool onFaces = estimator == GradientEstimator::Face;
    const GradientEstimator used = onFaces ? GradientEstimator::Area : estimator;
    evaluateGradient(surface, motion, mesh.skin, used, c.name, gradient); // the buffers' first use
    Stopwatch watch;
    evaluateGradient(surface, motion, mesh.skin, used, c.name, gradient);
    GradientError error;
    error.nanoseconds = watch.lap() * 1e9 / static_cast<double>(surface.normals.size());

    if (onFaces) {
        std::vector<SymmetricTensor> faces;
        SurfaceFrame frame;
        spreadToVertices(surface, gradient, frame);
        std::vector<Vec3> rest;
        for (std::size_t v = 0; v < surface.vertexCount(); ++v)
            rest.push_back(mesh.positions[surface.surfacePosition[surface.vertexSurface[v]]]);
        const std::vector<Vec3> metrics = restMetrics(surface, rest);
        watch.lap();
        faceStretches(surface, metrics, frame.positions, faces);
        error.nanoseconds = watch.lap() * 1e9 / static_cast<double>(faces.size());
        // What a hit at a triangle's corner reads.
        for (std::size_t i = 0; i < faces.size(); ++i) {
            const Vec2 uv = surface.uvs[surface.triangles[i].x];
            add(error, relativeDifference(faces[i], truthAt(c, static_cast<double>(uv.x), static_cast<double>(uv.y)).v));
        }
        return finished(error, faces.size());
    }
    std::size_t count = 0;
    for (std::size_t v = 0; v < surface.vertexCount(); ++v) {
        const Vec2 uv = surface.uvs[v];
        if (std::min(uv.x, uv.y) <= 0 || std::max(uv.x, uv.y) >= 1) continue;
        const Index s = surface.vertexSurface[v];
        const Vec4 &k = surface.frameCoefficients[v];
        const SymmetricTensor ours =
            polarGradient(gradient.f1[s] * k.x + gradient.f2[s] * k.y, gradient.f1[s] * k.z + gradient.f2[s] * k.w, gradient.normal[s])
                .stretch;
        add(error, relativeDifference(ours, truthAt(c, static_cast<double>(uv.x), static_cast<double>(uv.y)).v));
        ++count;
    }
    return finished(error, count);
}

GradientError interpolationError(const GradientCase &c, GradientInterpolation scheme, int n) {
    // Off the centroid, where second-order terms of a uniform grid could cancel.
    constexpr std::array<double, 3> kAt{0.5, 0.2, 0.3};
    struct Corner {
        Truth truth;
        SymmetricTensor stored;
    };
    std::vector<Corner> corners;
    for (int j = 0; j <= n; ++j)
        for (int i = 0; i <= n; ++i) {
            const Truth truth = truthAt(c, static_cast<double>(i) / n, static_cast<double>(j) / n);
            const Frame frame = smoothFrameFromNormal(Vec3(truth.n));
            corners.push_back({truth, encodeStretch(scheme, truth.v, frame.s, frame.t, frame.n)});
        }
    GradientError error;
    std::size_t count = 0;
    Stopwatch watch;
    double seconds = 0;
    for (int j = 0; j < n; ++j)
        for (int i = 0; i < n; ++i)
            for (const auto &offsets : {std::array<int, 6>{0, 0, 1, 0, 1, 1}, std::array<int, 6>{0, 0, 1, 1, 0, 1}}) {
                std::array<const Corner *, 3> at{};
                double u = 0;
                double v = 0;
                for (std::size_t k = 0; k < 3; ++k) {
                    const int x = i + offsets[2 * k];
                    const int y = j + offsets[2 * k + 1];
                    at[k] = &corners[static_cast<std::size_t>(y * (n + 1) + x)];
                    u += kAt[k] * x / n;
                    v += kAt[k] * y / n;
                }
                const Truth truth = truthAt(c, u, v);
                const Frame frame = smoothFrameFromNormal(Vec3(truth.n));
                watch.lap();
                Vec3 ours;
                if (scheme == GradientInterpolation::DsDt) {
                    Vec3 ds(0);
                    Vec3 dt(0);
                    for (std::size_t k = 0; k < 3; ++k) {
                        ds += Vec3(at[k]->truth.ds) * static_cast<float>(kAt[k]);
                        dt += Vec3(at[k]->truth.dt) * static_cast<float>(kAt[k]);
                    }
                    ours = polarInFrame({glm::dot(frame.s, ds), glm::dot(frame.t, ds)}, {glm::dot(frame.s, dt), glm::dot(frame.t, dt)})
                               .stretch;
                } else {
                    SymmetricTensor mixed{Vec3(0), Vec3(0)};
                    for (std::size_t k = 0; k < 3; ++k) {
                        const float w = scheme == GradientInterpolation::Face ? 1.0F / 3 : static_cast<float>(kAt[k]);
                        mixed.diagonal += at[k]->stored.diagonal * w;
                        mixed.offDiagonal += at[k]->stored.offDiagonal * w;
                    }
                    ours = decodeStretch(scheme, mixed, frame.s, frame.t);
                }
                seconds += watch.lap();
                const Vec3 exact = seenIn(truth.v, frame.s, frame.t);
                const auto frobenius = [](const Vec3 &t) { return std::sqrt(static_cast<double>(t.x * t.x + 2 * t.y * t.y + t.z * t.z)); };
                add(error, frobenius(ours - exact) / frobenius(exact));
                ++count;
            }
    error.nanoseconds = seconds * 1e9 / static_cast<double>(count);
    return finished(error, count);
}

double observedOrder(double coarse, double fine) {
    return std::log2(coarse / fine);
}

} // namespace taut::chart
