#include "taut/render/surface_step.h"

#include "taut/base/frame.h"
#include "taut/base/parallel.h"
#include "taut/base/stopwatch.h"
#include "taut/deform/face_gradient.h"
#include "taut/deform/polar_batch.h"
#include "taut/deform/stored_gloss.h"

#include <algorithm>

namespace taut {

namespace {

constexpr std::size_t kGrain = 2048;
/// Vertices that the V of a uniformly stretched mesh is the mean of.
constexpr std::size_t kUniformSamples = 64;

void resizeStep(SurfaceStep &step, std::size_t count) {
    if (step.normals.size() == count) return;
    step.positions.resize(count + 1);
    step.normals.resize(count);
    step.tangents.resize(count);
}

SymmetricTensor operator*(const SymmetricTensor &t, float s) {
    return {t.diagonal * s, t.offDiagonal * s};
}
SymmetricTensor operator+(const SymmetricTensor &a, const SymmetricTensor &b) {
    return {a.diagonal + b.diagonal, a.offDiagonal + b.offDiagonal};
}

/// From the gradient at the surface vertices to what hits read.
void fillStep(RenderObject &object, SurfaceStep &out) {
    const MeshPlan &plan = object.plan;
    const Surface &surface = object.surface;
    const std::size_t count = surface.vertexCount();
    resizeStep(out, count);
    const bool stored = !object.storedPoisson.empty();
    const bool follows = stored || (object.object->follow && plan.stretch != StretchModel::Constant);
    const bool perVertex = follows && plan.stretch != StretchModel::Uniform && plan.estimator != GradientEstimator::Face;
    const bool vectors = perVertex && plan.interpolation == GradientInterpolation::DsDt;
    const bool tensors = perVertex && !object.stretchOnFaces() && !vectors;
    const bool leans = perVertex && plan.stretch == StretchModel::Leaning && !object.gradient.normalImage.empty();
    const bool plain = object.object->follow && !leans && !vectors && !stored && plan.interpolation == GradientInterpolation::Stretch;
    if (tensors && out.stretch.size() != count) out.stretch.resize(count);
    if (leans && out.lean.size() != count) out.lean.resize(count);
    if (leans && object.roughens && out.inverseLambda.size() != count) out.inverseLambda.resize(count);
    if (vectors && out.ds.size() != count) {
        out.ds.resize(count);
        out.dt.resize(count);
    }
    const auto fillVertex = [&](std::size_t v, const PolarGradient &polar) {
        const Index s = surface.vertexSurface[v];
        const Vec3 n = object.gradient.normal[s];
        out.positions[v] = object.gradient.position[s];
        out.normals[v] = n;
        out.tangents[v] = polar.tangent;
        if (plain) {
            if (tensors) out.stretch[v] = polar.stretch;
            return;
        }
        const VertexGradient g = gradientAt(object.surface, object.gradient, v);
        // As other renderers do: the tangent is the normalised image of t0, whatever the shear.
        if (!object.object->follow) {
            const float length = glm::length(g.ds);
            if (length > 0) out.tangents[v] = Vec4(g.ds / length, polar.tangent.w);
        }
        float scale = 1;
        if (leans) {
            const Lean lean = leanOf(object.gradient.normalImage[surface.vertexSurface[v]], g.n);
            scale = lean.inverseLambda;
            out.lean[v] = lean.tangential;
            if (object.roughens) out.inverseLambda[v] = scale;
        }
        if (vectors) {
            out.ds[v] = g.ds * scale;
            out.dt[v] = g.dt * scale;
        } else if (tensors) {
            SymmetricTensor stretch = polar.stretch * scale;
            if (stored) {
                const StoredColumns m =
                    storedColumns(object.mesh(), surface, v, g.ds, g.dt, g.n, object.object->follow, object.storedPoisson[v]);
                stretch = polarGradient(m.x, m.y, g.n).stretch;
            }
            if (plan.interpolation != GradientInterpolation::Stretch) {
                const Frame frame = smoothFrameFromNormal(g.n);
                stretch = encodeStretch(plan.interpolation, stretch, frame.s, frame.t, g.n);
            }
            out.stretch[v] = stretch;
        }
    };
    const std::size_t blocks = (count + PolarBlock::kSize - 1) / PolarBlock::kSize;
    parallelFor(blocks, kGrain / PolarBlock::kSize, [&](std::size_t b) {
        const std::size_t begin = b * PolarBlock::kSize;
        const std::size_t size = std::min(PolarBlock::kSize, count - begin);
        PolarBlock block;
        if (size < PolarBlock::kSize) block = {};
        for (std::size_t i = 0; i < size; ++i) {
            const Index s = surface.vertexSurface[begin + i];
            const SurfaceGradient &g = object.gradient;
            block.set(i, g.f1[s], g.f2[s], g.normal[s], surface.tangentCoefficients[begin + i]);
        }
        splitPolar(block);
        for (std::size_t i = 0; i < size; ++i) fillVertex(begin + i, block.at(i));
    });
    if (!follows) return;
    if (plan.estimator == GradientEstimator::Face) {
        faceStretches(surface, object.metrics, out.positions, out.stretch);
    } else if (plan.stretch == StretchModel::Uniform) {
        const std::size_t stride = std::max<std::size_t>(1, count / kUniformSamples);
        SymmetricTensor sum{Vec3(0), Vec3(0)};
        std::size_t samples = 0;
        for (std::size_t v = 0; v < count; v += stride, ++samples) {
            const VertexGradient g = gradientAt(object.surface, object.gradient, v);
            sum = sum + polarGradient(g.ds, g.dt, g.n).stretch;
        }
        out.stretch.resize(1);
        out.stretch[0] = sum * (1 / static_cast<float>(samples));
    } else if (perVertex && object.stretchOnFaces()) {
        if (out.stretch.size() != surface.triangles.size()) out.stretch.resize(surface.triangles.size());
        parallelFor(out.stretch.size(), kGrain, [&](std::size_t i) {
            SymmetricTensor sum{Vec3(0), Vec3(0)};
            for (int k = 0; k < 3; ++k) {
                const VertexGradient g = gradientAt(object.surface, object.gradient, surface.triangles[i][k]);
                sum = sum + polarGradient(g.ds, g.dt, g.n).stretch;
            }
            out.stretch[i] = sum * (1.0F / 3);
        });
    }
}

/// The surface of a rigid object after `map`, whose linear part is `rotation` (or a reflection) after rest space's.
void fillRigid(const RenderObject &object, const Affine &map, const Mat3 &rotation, SurfaceStep &out) {
    const Surface &surface = object.surface;
    resizeStep(out, surface.vertexCount());
    const float hand = object.mirrored ? -1.0F : 1.0F;
    const std::vector<Vec3> &points = object.mesh().positions;
    parallelFor(surface.vertexCount(), kGrain, [&](std::size_t v) {
        const Index s = surface.vertexSurface[v];
        const Vec4 &t = object.restTangents[v];
        out.positions[v] = transformPoint(map, points[surface.surfacePosition[s]]);
        out.normals[v] = glm::normalize(rotation * surface.normals[s]);
        out.tangents[v] = Vec4(glm::normalize(rotation * Vec3(t)), t.w * hand);
    });
}

/// A rigid object's carrier is a rotation, or a reflection, after the constant placement that rest space has behind it.
bool moveRigid(RenderObject &object, std::size_t step, double frame, double fps, const DMat4 &renderFromWorld) {
    motionAtFrame(*object.object, frame, fps, renderFromWorld, object.motion);
    const MotionState &state = object.motion.state;
    object.mirrored = state.mirrored;
    const Mat3 &restFromObject = object.surface.restFromObject;
    const Mat3 objectFromRest = inverseOf(restFromObject);
    const Mat3 rotation = linearOf(state.carrier) * objectFromRest;
    if (!object.instanced) { // asked for one frame
        fillRigid(object, state.carrier, rotation, object.steps[step]);
        return true;
    }
    if (object.steps[0].normals.empty()) {
        fillRigid(object, {restFromObject[0], restFromObject[1], restFromObject[2], -object.localCentre}, Mat3(1), object.steps[0]);
        object.restTangents.clear();
        object.restTangents.shrink_to_fit();
    }
    const Affine placement{rotation[0], rotation[1], rotation[2], transformPoint(state.carrier, objectFromRest * object.localCentre)};
    if (object.placements[step] == placement) return false;
    object.placements[step] = placement;
    return true;
}

/// Middle of the box around a mesh, in rest space.
Vec3 centreOf(const std::vector<Vec3> &points, const Mat3 &restFromObject) {
    Vec3 lower(kInfinity);
    Vec3 upper(-kInfinity);
    for (const Vec3 &p : points) {
        const Vec3 q = restFromObject * p;
        lower = glm::min(lower, q);
        upper = glm::max(upper, q);
    }
    return points.empty() ? Vec3(0) : 0.5F * lower + 0.5F * upper;
}

} // namespace

void prepareRenderObject(const Object &object, const RenderSettings &render, const MeshPlan &plan, std::size_t times, bool animated,
                         RenderObject &out) {
    out.plan = plan;
    const bool stored = !object.mesh->storedM.empty();
    out.rigid = !deforms(object);
    if (stored) { // M is per vertex whatever moves; its square root is what is interpolated
        out.plan.stretch = StretchModel::PerVertex;
        out.plan.interpolation = GradientInterpolation::Stretch;
        if (out.plan.estimator == GradientEstimator::Face) out.plan.estimator = defaultEstimator(object);
    }
    out.instanced = out.rigid && (animated || times > 1);
    out.steps.resize(out.instanced ? 1 : times);
    if (out.object == nullptr) prepareObjectSurface(object, render.fps, out.plan.estimator, out.plan.subdivisionLevel, out);
    compact(out);
    const Surface &surface = out.surface;
    if (out.plan.estimator == GradientEstimator::Face && !out.rigid) {
        std::vector<Vec3> rest(surface.vertexCount());
        for (std::size_t v = 0; v < rest.size(); ++v)
            rest[v] = surface.restFromObject * out.mesh().positions[surface.surfacePosition[surface.vertexSurface[v]]];
        out.metrics = restMetrics(surface, rest);
    }
    if (!out.rigid) return;
    if (out.subdivision) out.subdivision->positions = {};
    out.gradient = {}; // of a plan that looked at its frames
    out.cage = std::vector<Vec3>();
    out.refined = std::vector<Vec3>();
    if (out.instanced) {
        out.placements.assign(times, Affine(0));
        out.localCentre = centreOf(out.mesh().positions, surface.restFromObject);
    }
    out.restTangents.resize(surface.vertexCount());
    for (std::size_t v = 0; v < out.restTangents.size(); ++v) {
        const Frame frame = surface.frameAt(surface.vertexSurface[v]);
        const Vec4 &k = surface.tangentCoefficients[v];
        out.restTangents[v] = Vec4(tangentsFrom(k, frame.s, frame.t).ds, k.x * k.w - k.y * k.z < 0 ? -1.0F : 1.0F);
    }
    out.surface.tangentCoefficients.clear(); // the tangents are all that was wanted of these
    compact(out.surface, false);
}

bool moveObject(RenderObject &object, std::size_t step, double frame, double fps, const DMat4 &renderFromWorld, double &deformationSeconds,
                double &gradientSeconds) {
    Stopwatch watch;
    if (object.rigid) {
        const bool moved = moveRigid(object, step, frame, fps, renderFromWorld);
        deformationSeconds += watch.lap();
        return moved;
    }
    deformAtFrame(object, frame, fps, renderFromWorld, deformationSeconds, gradientSeconds);
    watch.lap();
    fillStep(object, object.steps[step]);
    gradientSeconds += watch.lap();
    return true;
}

} // namespace taut
