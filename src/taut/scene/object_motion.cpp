#include "taut/scene/object_motion.h"

#include "taut/base/error.h"
#include "taut/deform/skinning.h"

#include <algorithm>
#include <cmath>

namespace taut {

namespace {

/// Joint matrices of the rest pose whose linear parts differ by less than this (relative) are one placement.
constexpr double kSamePlacement = 1e-4;

const Skin *skinOf(const Object &object) {
    if (!object.rig || object.mesh->skin.empty()) return nullptr;
    const Index skin = object.rig->rig->nodes[object.rig->node].skin;
    return skin == kNone ? nullptr : &object.rig->rig->skins[skin];
}

double maxAbs(const DMat3 &m) {
    double largest = 0;
    for (int c = 0; c < 3; ++c)
        for (int r = 0; r < 3; ++r) largest = std::max(largest, std::fabs(m[c][r]));
    return largest;
}

/// The placement that a skeleton in its rest pose gives the bind pose: the joints' common linear map where they agree, else the
/// median of their scales.
DMat3 skeletonPlacement(const std::vector<DMat4> &joints) {
    if (joints.empty()) return DMat3(1);
    const DMat3 first(joints.front());
    const double size = maxAbs(first);
    const bool common =
        std::all_of(joints.begin(), joints.end(), [&](const DMat4 &j) { return maxAbs(DMat3(j) - first) <= kSamePlacement * size; });
    if (common && glm::determinant(first) != 0) return first;
    std::vector<double> scales;
    for (const DMat4 &j : joints) scales.push_back(std::cbrt(std::fabs(glm::determinant(DMat3(j)))));
    std::nth_element(scales.begin(), scales.begin() + static_cast<std::ptrdiff_t>(scales.size() / 2), scales.end());
    const double median = scales[scales.size() / 2];
    return DMat3(median > 0 ? median : 1.0);
}

/// The symmetric factor S of L = R S: the shape that a placement gives, without its rotation (Higham 1986, Newton's iteration).
DMat3 withoutRotation(const DMat3 &placement) {
    DMat3 r = placement;
    for (int i = 0; i < 32; ++i) r = 0.5 * (r + glm::transpose(glm::inverse(r)));
    DMat3 s = glm::transpose(r) * placement;
    const double size = maxAbs(s);
    for (int c = 0; c < 3; ++c)
        for (int k = 0; k < 3; ++k)
            if (std::fabs(s[c][k]) < 1e-14 * size) s[c][k] = 0;
    return s;
}

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

Mat3 restFromObject(const Object &object) {
    DMat3 rest(1);
    if (object.rig) {
        const std::shared_ptr<const Pose> pose = restPoseOf(*object.rig);
        const Skin *skin = skinOf(object);
        rest = skin != nullptr ? skeletonPlacement(jointMatrices(*skin, *pose)) : DMat3(pose->worldFromNode[object.rig->node]);
    }
    rest = placementRest(object.placement) * rest;
    const double det = glm::determinant(rest);
    if (!(std::fabs(det) > 1e-30)) return Mat3(1); // a placement flattened to nothing says nothing about scale
    return Mat3(withoutRotation(det < 0 ? -rest : rest));
}

bool isRigid(const Object &object) {
    if (object.points || !object.deformers.empty() || !object.rest.bind || !object.placement.scale.isConstant()) return false;
    if (!object.rig) return true;
    if (skinOf(object) != nullptr || !object.mesh->morphs.empty()) return false;
    // A node is rigid where nothing above it scales over time.
    const RigMotion &motion = *object.rig;
    return !motion.poses->isMoved(motion.rig, clipOf(motion), motion.node, ChannelPath::Scale);
}

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
    double orientation = glm::determinant(DMat3(renderFromScene));
    if (object.rig) {
        const std::shared_ptr<const Pose> pose = poseAtFrame(*object.rig, frame, fps);
        const std::vector<float> &weights = pose->morphWeights[object.rig->node];
        if (!object.mesh->morphs.empty() && !weights.empty()) {
            morphPositions(object.mesh->positions, object.mesh->morphs, weights, motion.control);
            state.control = motion.control;
            state.controlMoved = true;
        }
        if (const Skin *skin = skinOf(object)) {
            const std::vector<DMat4> joints = jointMatrices(*skin, *pose);
            for (const DMat4 &joint : joints) state.joints.push_back(affineOf(target * joint));
            orientation *= glm::determinant(DMat3(joints.front()));
            sceneFromObject = DMat4(1); // glTF: the node of a skinned mesh does not move it
        } else {
            sceneFromObject = pose->worldFromNode[object.rig->node];
            orientation *= glm::determinant(DMat3(sceneFromObject));
        }
    }
    state.carrier = affineOf(target * sceneFromObject);
    state.mirrored = orientation < 0;
}

} // namespace taut
