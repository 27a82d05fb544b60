#include "study/scenes/gradient_cases.h"

#include "study/scenes/scenes.h"

#include "taut/deform/deformer.h"

namespace taut::chart {

namespace {

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

} // namespace

std::vector<GradientCase> gradientCases() {
    const std::pair<const char *, DeformerKeys> deformers[] = {{"twist on ", deformer(DeformerType::Twist, 0.9, 2, 0, 1.5)},
                                                               {"bend on ", deformer(DeformerType::Bend, 0.8, 0, 2, 1.5)},
                                                               {"shear on ", deformer(DeformerType::Shear, 0.7, 0, 2)},
                                                               {"sine on ", deformer(DeformerType::Wave, 0.2, 0, 2, 1, 1.7)}};
    std::vector<GradientCase> cases;
    for (const auto &[shape, name] : {std::pair(Shape::Plane, "plane"), std::pair(Shape::Cylinder, "cylinder"),
                                      std::pair(Shape::Sphere, "sphere"), std::pair(Shape::Torus, "torus")})
        for (const auto &[what, keys] : deformers) cases.push_back({std::string(what) + name, shape, {keys}, false});
    cases.push_back({"skinned bend of a cylinder", Shape::Cylinder, {}, true});
    return cases;
}

GradientTruth truthAt(const GradientCase &c, double u, double v) {
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
    GradientTruth t;
    t.ds = xu / a;
    t.dt = (xv - t.ds * b) / d;
    t.n = glm::normalize(glm::cross(t.ds, t.dt));
    t.v = polarGradient(Vec3(t.ds), Vec3(t.dt), Vec3(t.n)).stretch;
    return t;
}

Mesh meshOf(const GradientCase &c, int n) {
    Mesh mesh = makeGrid(n, n, 1);
    mesh.name = c.name;
    for (int j = 0; j <= n; ++j)
        for (int i = 0; i <= n; ++i) {
            const PointOfShape s = pointOf(c.shape, static_cast<double>(i) / n, static_cast<double>(j) / n);
            const auto v = static_cast<std::size_t>(j * (n + 1) + i);
            mesh.positions[v] = s.p;
            mesh.normals[v] = glm::normalize(glm::cross(s.du, s.dv));
        }
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

DVec3 deformedPoint(const GradientCase &c, const DVec3 &rest, double v) {
    DVec3 x = rest;
    if (c.skinned) x += jointWeight(v).x * (DVec3(jointMatrix() * glm::dvec4(x, 1)) - x);
    for (const DeformerKeys &keys : c.deformers) x = deform(deformerAtFrame(keys, 1), x).position;
    return x;
}

MotionState motionOf(const GradientCase &c, const Mesh &mesh) {
    MotionState motion;
    motion.control = mesh.positions;
    if (c.skinned) motion.joints = {Affine(1), Affine(jointMatrix())};
    for (const DeformerKeys &keys : c.deformers) motion.deformers.push_back(deformerAtFrame(keys, 1));
    return motion;
}

} // namespace taut::chart
