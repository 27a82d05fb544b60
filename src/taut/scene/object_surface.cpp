#include "taut/scene/object_surface.h"

#include "taut/base/stopwatch.h"
#include "taut/mesh/weld.h"

namespace taut {

namespace {

/// From control points to the points of the refined mesh, where it differs between them.
void refineOrientation(const StencilTable &stencils, Orientation &orientation) {
    if (orientation.at.empty()) return;
    std::vector<Vec3> signs;
    for (const signed char side : orientation.at) signs.emplace_back(static_cast<float>(side), 0, 0);
    std::vector<Vec3> refined;
    applyStencils(stencils, signs, refined);
    orientation.at.clear();
    for (const Vec3 &side : refined) orientation.at.push_back(side.x < 0 ? -1 : 1);
}

/// Which triangles are seen the other way round: a triangle goes with most of its corners.
void orientTriangles(ObjectSurface &object) {
    const Orientation &orientation = object.gradient.orientation;
    object.mirrored = orientation.mirrored;
    object.turned.resize(orientation.at.empty() ? 0 : object.surface.triangles.size());
    for (std::size_t t = 0; t < object.turned.size(); ++t) {
        int sum = 0;
        for (int k = 0; k < 3; ++k) sum += orientation.at[object.surface.vertexSurface[object.surface.triangles[t][k]]];
        object.turned[t] = sum < 0 ? 1 : 0;
    }
}

} // namespace

GradientEstimator defaultEstimator(const Object &object) {
    return object.gradient.value_or(object.subdivision.level > 0 ? GradientEstimator::Limit : GradientEstimator::Analytic);
}

void prepareObjectSurface(const Object &object, double fps, ObjectSurface &out) {
    prepareObjectSurface(object, fps, defaultEstimator(object), object.subdivision.level, out);
}

void prepareObjectSurface(const Object &object, double fps, GradientEstimator estimator, int subdivisionLevel, ObjectSurface &out) {
    out.object = &object;
    out.estimator = estimator;
    out.gradient.wantNormalImage = object.lean;
    SurfaceOptions options;
    options.restFromObject = restFromObject(object);
    options.smooth = object.smooth;
    options.weld = object.rig.has_value();
    options.mapTangents = object.mapTangents;
    options.fit = fitOf(estimator);
    if (subdivisionLevel > 0) {
        SubdivisionOptions subdivision = object.subdivision;
        subdivision.level = subdivisionLevel;
        out.subdivision = subdivide(options.weld ? welded(*object.mesh) : *object.mesh, subdivision);
        if (estimator == GradientEstimator::Limit) {
            options.limit = &*out.subdivision;
            options.cage = object.mesh->positions;
        }
        options.weld = false;
    }
    out.surface = buildSurface(out.mesh(), options);
    if (!object.rest.bind) {
        double ignored = 0;
        deformAtFrame(out, object.rest.frame, fps, DMat4(1), ignored, ignored);
        setRestFrom(out.surface, out.gradient);
    }
}

void compact(ObjectSurface &object) {
    if (object.subdivision) {
        object.subdivision->tangents = {};
        if (object.surface.onLimit()) object.subdivision->positions = {}; // other fits read refined points
    }
    // Gradients that are carried along start from a fit only where control points move by themselves.
    const bool controlMoves = object.object->points || !object.object->mesh->morphs.empty();
    compact(object.surface, controlMoves || object.subdivision || object.estimator != GradientEstimator::Analytic);
}

void deformAtFrame(ObjectSurface &object, double frame, double fps, const DMat4 &targetFromWorld, double &deformationSeconds,
                   double &gradientSeconds) {
    Stopwatch watch;
    const Object &source = *object.object;
    motionAtFrame(source, frame, fps, targetFromWorld, object.motion);
    const MotionState &state = object.motion.state;
    if (object.subdivision) {
        evaluatePositions(state, source.mesh->skin, object.cage);
        const bool onLimit = object.surface.onLimit();
        if (!onLimit) applyStencils(object.subdivision->positions, object.cage, object.refined);
        orientationOfPoints(state, source.mesh->skin, object.cageOrientation);
        if (!onLimit) refineOrientation(object.subdivision->positions, object.cageOrientation);
        deformationSeconds += watch.lap();
        fitGradient(object.surface, onLimit ? object.cage : object.refined, object.cageOrientation, source.name, object.gradient);
    } else {
        deformationSeconds += watch.lap();
        evaluateGradient(object.surface, state, source.mesh->skin, object.estimator, source.name, object.gradient);
    }
    orientTriangles(object);
    gradientSeconds += watch.lap();
}

void surfaceAtFrame(ObjectSurface &object, double frame, double fps, const DMat4 &targetFromWorld, double &deformationSeconds,
                    double &gradientSeconds) {
    deformAtFrame(object, frame, fps, targetFromWorld, deformationSeconds, gradientSeconds);
    Stopwatch watch;
    spreadToVertices(object.surface, object.gradient, object.vertices);
    gradientSeconds += watch.lap();
}

} // namespace taut
