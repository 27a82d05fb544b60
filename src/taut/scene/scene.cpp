#include "taut/scene/scene.h"

#include <glm/gtc/matrix_transform.hpp>

#include <map>

namespace taut {

namespace {

/// World axes of a camera that looks from `position` to `lookAt`: columns x (right), y (up), z (backwards).
DMat3 axesLookingAt(const DVec3 &position, const DVec3 &lookAt, const DVec3 &up) {
    const DVec3 back = position - lookAt;
    const double distance = glm::length(back);
    const DVec3 z = distance > 0 ? back / distance : DVec3(0, 0, 1);
    DVec3 x = glm::cross(up, z);
    // Straight up or down the right stays where it is while a camera tilts there: along x, for z up and for y up.
    if (!(glm::length(x) > 1e-9 * glm::length(up))) {
        const DVec3 right = std::fabs(z.x) < 0.7 ? DVec3(1, 0, 0) : DVec3(0, 1, 0);
        x = right - z * glm::dot(right, z);
    }
    x = glm::normalize(x);
    return {x, glm::cross(z, x), z};
}

/// The rotation in an affine matrix: its columns by Gram-Schmidt from z, since z is where the camera looks.
DMat3 rotationOf(const DMat3 &m) {
    DVec3 z = m[2];
    if (!(glm::length(z) > 0)) z = DVec3(0, 0, 1);
    return axesLookingAt(z, DVec3(0), m[1]);
}

DMat4 compose(const DMat3 &linear, const DVec3 &origin) {
    DMat4 out(linear);
    out[3] = DVec4(origin, 1);
    return out;
}

DMat3 eulerXyz(const DVec3 &angles) {
    const DMat4 one(1);
    return DMat3(glm::rotate(one, angles.z, DVec3(0, 0, 1)) * glm::rotate(one, angles.y, DVec3(0, 1, 0)) *
                 glm::rotate(one, angles.x, DVec3(1, 0, 0)));
}

DMat3 scaleOf(const DVec3 &s) {
    return {DVec3(s.x, 0, 0), DVec3(0, s.y, 0), DVec3(0, 0, s.z)};
}

} // namespace

DMat4 placementAt(const Placement &placement, double frame) {
    const DMat3 linear = eulerXyz(placement.rotation.at(frame)) * scaleOf(placement.scale.at(frame));
    return compose(linear, placement.translation.at(frame)) * placement.worldFromUp;
}

DMat3 placementRest(const Placement &placement) {
    return eulerXyz(placement.rotation.first()) * scaleOf(placement.scale.first()) * DMat3(placement.worldFromUp);
}

CameraState cameraAtFrame(const Camera &camera, double frame, double fps) {
    CameraState state;
    state.fovY = camera.fovY.at(frame);
    state.orthoHeight = camera.orthoHeight.at(frame);
    state.apertureRadius = state.orthoHeight > 0 ? 0 : camera.apertureRadius.at(frame);
    state.focusDistance = camera.focusDistance.at(frame);
    if (camera.rig) {
        const RigMotion &motion = *camera.rig;
        const DMat4 placed = placementAt(camera.placement, frame) * poseAtFrame(motion, frame, fps)->worldFromNode[motion.node];
        state.worldFromCamera = compose(rotationOf(DMat3(placed)), DVec3(placed[3]));
        if (!(state.focusDistance > 0)) state.focusDistance = 1;
        return state;
    }
    const DVec3 position = camera.position.at(frame);
    const DVec3 lookAt = camera.lookAt.at(frame);
    state.worldFromCamera = compose(axesLookingAt(position, lookAt, camera.up.at(frame)), position);
    if (!(state.focusDistance > 0)) state.focusDistance = glm::distance(position, lookAt);
    return state;
}

const Clip *clipOf(const RigMotion &motion) {
    if (motion.together) return motion.together.get();
    return motion.clip == kNone ? nullptr : &motion.rig->clips[motion.clip];
}

double clipTime(const RigMotion &motion, double frame, double fps) {
    const double seconds = (frame - 1) / fps;
    const Clip *clip = clipOf(motion);
    if (!motion.loop || clip == nullptr) return seconds;
    const double duration = clip->duration;
    if (!(duration > 0)) return seconds;
    return seconds - duration * std::floor(seconds / duration);
}

std::shared_ptr<const Pose> poseAtFrame(const RigMotion &motion, double frame, double fps) {
    return motion.poses->at(motion.rig, clipOf(motion), clipTime(motion, frame, fps));
}

std::shared_ptr<const Pose> restPoseOf(const RigMotion &motion) {
    return motion.poses->rest(motion.rig, clipOf(motion));
}

void sharePoses(Scene &scene) {
    std::map<const Rig *, std::shared_ptr<RigPoses>> known;
    for (Object &object : scene.objects)
        if (object.rig) object.rig->poses = known.try_emplace(object.rig->rig.get(), object.rig->poses).first->second;
}

} // namespace taut
