#include "taut/deform/surface_motion.h"

#include "taut/base/error.h"
#include "taut/base/frame.h"
#include "taut/base/parallel.h"
#include "taut/deform/carried_block.h"
#include "taut/deform/ring_stretch.h"
#include "taut/deform/skin_hinges.h"
#include "taut/deform/skinning.h"
#include "taut/deform/surface_normal.h"

#include <atomic>
#include <cstring>

namespace taut {

namespace {

void resizeAll(SurfaceGradient &out, std::size_t count) {
    for (auto *array : {&out.position, &out.f1, &out.f2, &out.normal})
        if (array->size() != count) array->resize(count);
}

/// Derivatives along e1 and e2 at surface vertex s, from its stencil. The weights sum to zero, so points are taken relative to one of
/// them: far from the origin that keeps digits.
void differentiate(const Surface &surface, std::size_t s, std::span<const Vec3> points, Vec3 &f1, Vec3 &f2) {
    f1 = Vec3(0);
    f2 = Vec3(0);
    const Index begin = surface.stencilOffsets[s];
    const Vec3 origin = points[surface.stencilPositions[begin]];
    for (Index k = begin; k < surface.stencilOffsets[s + 1]; ++k) {
        const Vec3 p = points[surface.stencilPositions[k]] - origin;
        f1 += p * surface.stencilWeights[k].x;
        f2 += p * surface.stencilWeights[k].y;
    }
}

/// Four floats in a register.
using Lanes = float __attribute__((vector_size(16)));

Lanes load(const Vec4 &v) {
    Lanes lanes;
    std::memcpy(&lanes, &v, sizeof lanes);
    return lanes;
}
Vec3 toVec3(const Lanes &lanes) {
    return {lanes[0], lanes[1], lanes[2]};
}

/// The derivatives and the position on a limit surface.
void differentiateLimit(const Surface &surface, std::size_t s, const std::vector<Vec4> &points, Vec3 &position, Vec3 &f1, Vec3 &f2) {
    const Index begin = surface.stencilOffsets[s];
    const Index end = surface.stencilOffsets[s + 1];
    const Lanes origin = load(points[surface.stencilPositions[begin]]);
    Lanes x{};
    Lanes d1{};
    Lanes d2{};
    for (Index k = begin; k < end; ++k) {
        const Lanes p = load(points[surface.stencilPositions[k]]) - origin;
        const Vec2 w = surface.stencilWeights[k];
        x += p * surface.stencilPoints[k];
        d1 += p * w.x;
        d2 += p * w.y;
    }
    position = toVec3(origin + x);
    f1 = toVec3(d1);
    f2 = toVec3(d2);
}

/// Finishes the gradient of a fit in a space whose rest shape is `restFromSpace`^-1 of rest space. The normal is the
/// unit vector whose components along the fitted tangents are the slopes recorded at rest, scaled with the surface, so that at
/// rest, under rigid motion and under uniform scaling the file's own normals come back. Where the space is `mirrored` the normal
/// is the one on the side of cross(f1, f2), which then is the inner one.
void raiseFit(const Surface &surface, std::size_t s, const Mat3 &restFromSpace, bool mirrored, Vec3 &f1, Vec3 &f2, Vec3 &normal) {
    f1 = restFromSpace * f1;
    f2 = restFromSpace * f2;
    const Vec2 slope = mirrored ? -surface.slope[s] : surface.slope[s];
    const Vec3 cross = glm::cross(f1, f2);
    const float area = glm::length(cross);
    if (isCollapsed(area, f1, f2)) {
        normal = collapsedNormal(f1, f2, surface.normals[s]);
        return;
    }
    const Vec3 upright = cross / area;
    if (slope == Vec2(0)) { // a limit surface: the tangents span the tangent plane
        normal = upright;
        return;
    }
    const float scale = std::sqrt(area / std::sqrt(1 + glm::dot(slope, slope)));
    const Vec2 target = slope * scale;
    // In-plane part: solve the Gram system for the vector with the wanted dot products.
    const float g11 = glm::dot(f1, f1);
    const float g12 = glm::dot(f1, f2);
    const float g22 = glm::dot(f2, f2);
    const float inverse = 1 / (area * area); // = det of the Gram matrix
    const Vec3 inPlane = f1 * ((g22 * target.x - g12 * target.y) * inverse) + f2 * ((g11 * target.y - g12 * target.x) * inverse);
    normal = glm::normalize(inPlane + upright * std::sqrt(std::fmax(0.0F, 1 - glm::dot(inPlane, inPlane))));
    f1 -= normal * glm::dot(normal, f1);
    f2 -= normal * glm::dot(normal, f2);
}

/// Turns a fit to the normal that its file gives the morphed surface, which is taken on the side of the faces (NormalsFollowWinding): a
/// rotation, so that the stretch is that of the points.
void turnToNormal(const Vec3 &given, Vec3 &f1, Vec3 &f2, Vec3 &n) {
    const Vec3 unit = unitOf(given);
    if (unit == Vec3(0)) return;
    const Vec3 target = glm::dot(unit, n) < 0 ? -unit : unit;
    const Vec3 axis = glm::cross(n, target);
    const float share = 1 / (1 + glm::dot(n, target));
    const auto turn = [&](const Vec3 &x) {
        const Vec3 across = glm::cross(axis, x);
        return x + across + glm::cross(axis, across) * share;
    };
    f1 = turn(f1);
    f2 = turn(f2);
    n = target;
}

/// Image of x and of tangents under the linear blend skin at a surface vertex:
/// f' = sum w B f + sum (B x) dw.
struct Blend {
    Affine map{0};
    Vec3 drift1{0}, drift2{0};
};

Blend blendAt(const Surface &surface, std::size_t s, const MotionState &motion, const SkinWeights &skin, const Vec3 &x) {
    Blend blend;
    const Index position = surface.surfacePosition[s];
    blend.map = blendedTransform(skin, position, motion.joints, motion.carrier);
    if (!isSkinned(skin, position, motion.joints)) return blend;
    const Vec3 centre = transformPoint(blend.map, x);
    for (Index i = surface.weightGradientOffsets[s]; i < surface.weightGradientOffsets[s + 1]; ++i) {
        // The gradients of the weights sum to zero: taking Bx relative to the blended point keeps digits.
        const Vec3 image = transformPoint(motion.joints[surface.weightGradientJoints[i]], x) - centre;
        blend.drift1 += image * surface.weightGradients[i].x;
        blend.drift2 += image * surface.weightGradients[i].y;
    }
    return blend;
}

/// At a hinge the product rule gives way to a fit to the skinned positions where the faces around say that it is wrong.
void fitHinge(const Surface &surface, std::size_t s, const MotionState &motion, const SkinWeights &skin, const Affine &map, Vec3 &f1,
              Vec3 &f2, Vec3 &n) {
    const Vec3 origin = transformPoint(map, motion.control[surface.surfacePosition[s]]);
    const auto edgeTo = [&](Index p) {
        return transformPoint(blendedTransform(skin, p, motion.joints, motion.carrier), motion.control[p]) - origin;
    };
    const float weight = foldWeight(ringStretch(surface, s, edgeTo), surface.ringTilts[s], rightStretch(f1, f2));
    if (!(weight > 0)) return;
    Vec3 g1(0);
    Vec3 g2(0);
    Vec3 normal(0);
    for (Index k = surface.stencilOffsets[s]; k < surface.stencilOffsets[s + 1]; ++k) {
        const Vec3 p = edgeTo(surface.stencilPositions[k]);
        g1 += p * surface.stencilWeights[k].x;
        g2 += p * surface.stencilWeights[k].y;
    }
    const bool mirrored = glm::determinant(Mat3(map[0], map[1], map[2])) < 0;
    raiseFit(surface, s, Mat3(1), mirrored, g1, g2, normal);
    unfold(surface, s, edgeTo, normal, g1, g2);
    f1 += (g1 - f1) * weight;
    f2 += (g2 - f2) * weight;
    n += (normal * (mirrored ? -glm::length(n) : glm::length(n)) - n) * weight;
}

/// Returns what the deformers' Jacobians do to orientation, orientationOf() of their product.
int applyDeformers(const MotionState &motion, DVec3 &x, DVec3 &f1, DVec3 &f2, DVec3 &n) {
    int side = 1;
    for (const Deformer &deformer : motion.deformers) {
        const DeformedPoint image = deform(deformer, x);
        side *= orientationOf(image.jacobian);
        x = image.position;
        f1 = image.jacobian * f1;
        f2 = image.jacobian * f2;
        n = image.jacobian * n;
    }
    x = DVec3(motion.renderFromDeformed * DVec4(x, 1));
    const DMat3 linear(motion.renderFromDeformed);
    f1 = linear * f1;
    f2 = linear * f2;
    n = linear * n;
    return side;
}

void throwNotFinite(const std::string &name) {
    throw RunError("mesh '" + name + "': the deformation gives positions that are not finite");
}

} // namespace

void evaluateGradient(const Surface &surface, const MotionState &motion, const SkinWeights &skin, GradientEstimator estimator,
                      const std::string &name, SurfaceGradient &out) {
    if (estimator != GradientEstimator::Analytic) {
        evaluatePositions(motion, skin, out.moved);
        orientationOfPoints(motion, skin, out.movedOrientation);
        fitGradient(surface, out.moved, out.movedOrientation, name, out);
        return;
    }
    const std::size_t count = surface.normals.size();
    resizeAll(out, count);
    if (out.wantNormalImage && out.normalImage.size() != count) out.normalImage.resize(count);
    const Mat3 objectFromRest = inverseOf(surface.restFromObject);
    const Mat3 restNormalFromObject = glm::transpose(objectFromRest);
    const bool normalsMorph = !motion.normals.empty() && !surface.morphedNormals.empty();
    const Mat3 carrierFromRest = Mat3(motion.carrier[0], motion.carrier[1], motion.carrier[2]) * objectFromRest;
    const bool skinned = !motion.joints.empty() && !skin.empty();
    const int placed = motion.placedSide();
    const int carried = orientationOf(DMat3(linearOf(motion.carrier))) * placed;
    OrientationGatherer orientation(motion.mirrored, motion.turnsVary(skin), count, out.orientation);
    std::atomic<bool> finite{true};
    if (!motion.controlMoved && !skinned) {
        const CarryingMap map{motion.carrier, carrierFromRest, motion.deformers, motion.renderFromDeformed};
        carryVertices(surface, motion.control, map, carried, orientation, finite, out);
        orientation.finish();
        if (!finite) throwNotFinite(name);
        return;
    }
    parallelFor(count, kVertexGrain, [&](std::size_t s) {
        int side = carried;
        const Vec3 x = motion.control[surface.surfacePosition[s]];
        auto [f1, f2, n] = surface.frameAt(s);
        if (motion.controlMoved && surface.stencilOffsets[s] != surface.stencilOffsets[s + 1]) {
            differentiate(surface, s, motion.control, f1, f2);
            raiseFit(surface, s, surface.restFromObject, false, f1, f2, n);
            const auto edgeTo = [&](Index p) { return surface.restFromObject * (motion.control[p] - x); };
            unfold(surface, s, edgeTo, n, f1, f2);
            if (normalsMorph && surface.morphedNormals[s] != kNone)
                turnToNormal(restNormalFromObject * motion.normals[surface.morphedNormals[s]], f1, f2, n);
        }
        Vec3 position;
        if (skinned) {
            const Blend blend = blendAt(surface, s, motion, skin, x);
            side = orientationOf(DMat3(linearOf(blend.map))) * placed;
            position = transformPoint(blend.map, x);
            f1 = transformVector(blend.map, objectFromRest * f1) + blend.drift1;
            f2 = transformVector(blend.map, objectFromRest * f2) + blend.drift2;
            n = transformVector(blend.map, objectFromRest * n);
            if (isHinge(surface, s)) fitHinge(surface, s, motion, skin, blend.map, f1, f2, n);
        } else {
            position = transformPoint(motion.carrier, x);
            f1 = carrierFromRest * f1;
            f2 = carrierFromRest * f2;
            n = carrierFromRest * n;
        }
        if (!motion.deformers.empty()) {
            DVec3 dx(position);
            DVec3 df1(f1);
            DVec3 df2(f2);
            DVec3 dn(n);
            side *= applyDeformers(motion, dx, df1, df2, dn);
            position = Vec3(dx);
            f1 = Vec3(df1);
            f2 = Vec3(df2);
            n = Vec3(dn);
        }
        if (out.wantNormalImage) out.normalImage[s] = n;
        const bool mirrored = orientation.set(s, side);
        const Vec3 normal = normalOf(f1, f2, mirrored ? -n : n);
        out.position[s] = position;
        out.f1[s] = f1;
        out.f2[s] = f2;
        out.normal[s] = mirrored ? -normal : normal;
        if (!isFinite(position)) finite = false;
    });
    orientation.finish();
    if (!finite) throwNotFinite(name);
}

namespace {

/// What the map does at a surface vertex, from the points that it is computed from: on a limit surface as most of their weight says.
bool isMirroredAt(const Surface &surface, std::size_t s, const Orientation &points) {
    if (points.at.empty()) return points.mirrored;
    if (!surface.onLimit()) return points.at[surface.surfacePosition[s]] < 0;
    float sum = 0; // of weights relative to the first point's
    const Index begin = surface.stencilOffsets[s];
    const Index end = surface.stencilOffsets[s + 1];
    if (begin == end) return points.mirrored;
    const auto origin = static_cast<float>(points.at[surface.stencilPositions[begin]]);
    for (Index k = begin; k < end; ++k)
        sum += surface.stencilPoints[k] * (static_cast<float>(points.at[surface.stencilPositions[k]]) - origin);
    return origin + sum < 0;
}

} // namespace

void fitGradient(const Surface &surface, std::span<const Vec3> renderPoints, const Orientation &points, const std::string &name,
                 SurfaceGradient &out) {
    const std::size_t count = surface.normals.size();
    resizeAll(out, count);
    std::atomic<bool> finite{true};
    const bool onLimit = surface.onLimit();
    if (onLimit) {
        if (out.points.size() != renderPoints.size()) out.points.resize(renderPoints.size());
        parallelFor(renderPoints.size(), kVertexGrain, [&](std::size_t i) { out.points[i] = Vec4(renderPoints[i], 0); });
    }
    out.orientation.mirrored = points.mirrored;
    out.orientation.at.resize(points.at.empty() ? 0 : count);
    parallelFor(count, kVertexGrain, [&](std::size_t s) {
        const bool mirrored = isMirroredAt(surface, s, points);
        if (!points.at.empty()) out.orientation.at[s] = mirrored ? -1 : 1;
        bool known = surface.stencilOffsets[s] != surface.stencilOffsets[s + 1];
        if (onLimit) {
            known = surface.slope[s].x < kInfinity; // RestAtLoneVertex
            differentiateLimit(surface, s, out.points, out.position[s], out.f1[s], out.f2[s]);
        } else {
            out.position[s] = renderPoints[surface.surfacePosition[s]];
            if (known) differentiate(surface, s, renderPoints, out.f1[s], out.f2[s]);
        }
        if (known) {
            raiseFit(surface, s, Mat3(1), mirrored, out.f1[s], out.f2[s], out.normal[s]);
            const auto edgeTo = [&](Index p) { return renderPoints[p] - out.position[s]; };
            if (!onLimit) unfold(surface, s, edgeTo, out.normal[s], out.f1[s], out.f2[s]);
        } else {
            const Frame frame = surface.frameAt(s);
            out.f1[s] = frame.s;
            out.f2[s] = frame.t;
            out.normal[s] = frame.n;
        }
        if (mirrored) out.normal[s] = -out.normal[s];
        if (!isFinite(out.position[s])) finite = false;
    });
    if (!finite) throwNotFinite(name);
}

void evaluatePositions(const MotionState &motion, const SkinWeights &skin, std::vector<Vec3> &out) {
    skinPositions(skin, motion.joints, motion.carrier, motion.control, out);
    if (motion.deformers.empty()) return;
    parallelFor(out.size(), kVertexGrain, [&](std::size_t v) {
        DVec3 x(out[v]);
        for (const Deformer &deformer : motion.deformers) x = deform(deformer, x).position;
        out[v] = Vec3(DVec3(motion.renderFromDeformed * DVec4(x, 1)));
    });
}

void spreadToVertices(const Surface &surface, const SurfaceGradient &gradient, DeformedVertices &out) {
    const std::size_t count = surface.vertexCount();
    if (out.positions.size() != count + 1) out.positions.resize(count + 1);
    for (auto *array : {&out.normals, &out.ds, &out.dt})
        if (array->size() != count) array->resize(count);
    parallelFor(count, kVertexGrain, [&](std::size_t v) {
        const VertexGradient g = gradientAt(surface, gradient, v);
        out.positions[v] = gradient.position[surface.vertexSurface[v]];
        out.normals[v] = g.n;
        out.ds[v] = g.ds;
        out.dt[v] = g.dt;
    });
}

void setRestFrom(Surface &surface, const SurfaceGradient &gradient) {
    parallelFor(surface.vertexCount(), kVertexGrain, [&](std::size_t v) {
        Vec4 &k = surface.tangentCoefficients[v];
        const auto [ds, dt, n] = gradientAt(surface, gradient, v);
        // A = [[a, b], [0, d]] in the frame with s along ds; [ds dt] A^-1 is orthonormal.
        const float a = glm::length(ds);
        if (!(a > 0)) return;
        const float b = glm::dot(ds, dt) / a;
        const Vec3 across = dt - ds * (b / a);
        const float d = glm::length(across);
        if (!(d > 1e-6F * glm::length(dt))) return; // collapsed at the rest frame: keeps the bind pose
        k = {k.x / a, k.y / a, (k.z - k.x * (b / a)) / d, (k.w - k.y * (b / a)) / d};
    });
}

} // namespace taut
