#include "taut/scene/object_motion.h"

#include "taut/base/error.h"
#include "taut/deform/skinning.h"

#include <algorithm>
#include <cmath>

namespace taut {

namespace {

/// The object's points at a frame.
std::span<const Vec3> pointsAt(const Object &object, double frame, double fps, ObjectMotion &motion) {
    if (motion.source != object.points) {
        motion.points = object.points->open();
        motion.source = object.points;
    }
    const std::span<const Vec3> points = motion.points->at(frame, fps);
    if (points.size() != object.mesh->positions.size())
        throw InputError("object " + quoted(object.name) + ": found " + std::to_string(points.size()) + " points at frame " +
                         formatNumber(frame) + ", expected " + std::to_string(object.mesh->positions.size()) + " as in its mesh");
    if (const auto bad = std::find_if_not(points.begin(), points.end(), [](const Vec3 &p) { return isFinite(p); }); bad != points.end())
        throw InputError("object " + quoted(object.name) + ": found a point that is not finite at frame " + formatNumber(frame) +
                         " (point " + std::to_string(bad - points.begin()) + "), expected finite coordinates");
    return points;
}

} // namespace

bool deforms(const Object &object) {
    return !isRigid(object) || !object.mesh->storedM.empty();
}

bool moves(const Object &object) {
    const Placement &p = object.placement;
    return object.rig || object.points || !object.deformers.empty() || !p.translation.isConstant() || !p.rotation.isConstant() ||
           !p.scale.isConstant();
}

void motionAtFrame(const Object &object, double frame, double fps, const DMat4 &renderFromWorld, ObjectMotion &motion) {
    MotionState &state = motion.state;
    state.control = object.mesh->positions;
    state.controlMoved = false;
    state.normals = {};
    state.joints.clear();
    DMat4 sceneFromObject(1);
    const DMat4 renderFromScene = renderFromWorld * placementAt(object.placement, frame);
    std::size_t active = 0;
    for (const DeformerKeys &keys : object.deformers) {
        setDeformer(keys, frame, motion.deformer);
        if (isIdentity(motion.deformer)) continue;
        if (active == state.deformers.size()) state.deformers.emplace_back();
        state.deformers[active++] = motion.deformer; // assigned in place: no allocation after the first frame
    }
    state.deformers.resize(active);
    state.renderFromDeformed = renderFromScene;
    // Without deformers every matrix is taken to render space in double before it is rounded.
    const DMat4 target = state.deformers.empty() ? renderFromScene : DMat4(1);

    if (object.points) {
        state.control = pointsAt(object, frame, fps, motion);
        state.controlMoved = true;
    }
    DMat3 linear(renderFromScene);
    if (object.rig) {
        const std::shared_ptr<const Pose> pose = poseAtFrame(*object.rig, frame, fps);
        const std::vector<float> &weights = pose->morphWeights[object.rig->node];
        if (!object.mesh->morphs.empty() && !weights.empty()) {
            morphPositions(object.mesh->positions, object.mesh->morphs, weights, motion.control);
            state.control = motion.control;
            state.controlMoved = true;
            if (hasMorphNormals(*object.mesh)) {
                morphNormals(object.mesh->normals, object.mesh->morphs, weights, motion.normals);
                state.normals = motion.normals;
            }
        }
        if (const Skin *skin = skinOf(object)) {
            const std::vector<DMat4> joints = jointMatrices(*skin, *pose);
            for (const DMat4 &joint : joints) state.joints.push_back(affineOf(target * joint));
            sceneFromObject = DMat4(1); // glTF: the node of a skinned mesh does not move it
        } else {
            sceneFromObject = pose->worldFromNode[object.rig->node];
            linear = linear * DMat3(sceneFromObject);
        }
    }
    state.carrier = affineOf(target * sceneFromObject);
    state.mirrored = orientationOf(linear) < 0;
}

} // namespace taut
