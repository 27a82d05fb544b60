#include "taut/scene/object_surface.h"

#include "taut/base/stopwatch.h"
#include "taut/mesh/weld.h"

namespace taut {

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
    object.mirrored = state.mirrored;
    if (object.subdivision) {
        evaluatePositions(state, source.mesh->skin, object.cage);
        const bool onLimit = object.surface.onLimit();
        if (!onLimit) applyStencils(object.subdivision->positions, object.cage, object.refined);
        deformationSeconds += watch.lap();
        fitGradient(object.surface, onLimit ? object.cage : object.refined, state.mirrored, source.name, object.gradient);
    } else {
        deformationSeconds += watch.lap();
        evaluateGradient(object.surface, state, source.mesh->skin, object.estimator, source.name, object.gradient);
    }
    gradientSeconds += watch.lap();
}

void surfaceAtFrame(ObjectSurface &object, double frame, double fps, const DMat4 &targetFromWorld, double &deformationSeconds,
                    double &gradientSeconds) {
    deformAtFrame(object, frame, fps, targetFromWorld, deformationSeconds, gradientSeconds);
    Stopwatch watch;
    spreadToVertices(object.surface, object.gradient, object.frame);
    gradientSeconds += watch.lap();
}

} // namespace taut
