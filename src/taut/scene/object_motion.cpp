#include "taut/scene/object_motion.h"

#include "taut/base/frame_set.h"
#include "taut/deform/animation.h"
#include "taut/deform/skinning.h"
#include "taut/mesh/read_mesh.h"

#include <algorithm>
#include <cmath>

namespace taut {

namespace {

/// Joint matrices of the rest pose whose linear parts differ by less than this (relative) are one placement.
constexpr double kSamePlacement = 1e-4;

Affine toAffine(const DMat4 &m) {
    return Affine(Vec3(m[0]), Vec3(m[1]), Vec3(m[2]), Vec3(m[3]));
}

const Clip *clipOf(const GltfMotion &motion) {
    return motion.clip == kNone ? nullptr : &motion.file->clips[motion.clip];
}

const Skin *skinOf(const Object &object) {
    if (!object.gltf || object.mesh->skin.empty()) return nullptr;
    const Index skin = object.gltf->file->nodes[object.gltf->node].skin;
    return skin == kNone ? nullptr : &object.gltf->file->skins[skin];
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

const std::vector<Vec3> &sequenceFrame(const Object &object, int frame, ObjectMotion &motion) {
    const auto known = motion.sequenceFrames.find(frame);
    if (known != motion.sequenceFrames.end()) return known->second;
    if (motion.sequenceFrames.size() >= 4) motion.sequenceFrames.clear(); // two are needed at a time
    return motion.sequenceFrames.emplace(frame, readSequencePositions(pathOfFrame(object.sequence->pattern, frame), *object.mesh))
        .first->second;
}

void sequenceControl(const Object &object, double frame, ObjectMotion &motion) {
    const std::vector<int> &frames = object.sequence->frames;
    const auto next = std::upper_bound(frames.begin(), frames.end(), frame, [](double f, int key) { return f < key; });
    const int after = next == frames.end() ? frames.back() : *next;
    const int before = next == frames.begin() ? frames.front() : *(next - 1);
    motion.control = sequenceFrame(object, before, motion);
    if (before == after || frame <= before) return;
    const float u = static_cast<float>((frame - before) / (after - before));
    const std::vector<Vec3> &other = sequenceFrame(object, after, motion);
    for (std::size_t i = 0; i < motion.control.size(); ++i) motion.control[i] = glm::mix(motion.control[i], other[i], u);
}

const std::vector<Vec3> &cacheSample(std::int64_t number, std::int64_t other, ObjectMotion &motion) {
    for (std::size_t i = 0; i < 2; ++i)
        if (motion.cacheNumbers[i] == number) return motion.cacheSamples[i];
    const std::size_t slot = motion.cacheNumbers[0] == other ? 1 : 0;
    motion.cache->read(static_cast<std::uint32_t>(number), motion.cacheSamples[slot]);
    motion.cacheNumbers[slot] = number;
    return motion.cacheSamples[slot];
}

/// Positions from the point cache, linear between its samples.
void cacheControl(const Object &object, double frame, double fps, ObjectMotion &motion) {
    if (!motion.cache) motion.cache = std::make_shared<PointCacheReader>(object.cache->path);
    const double sample = motion.cache->info().sampleAtFrame(frame, fps);
    const auto before = static_cast<std::int64_t>(std::floor(sample));
    const auto u = static_cast<float>(sample - static_cast<double>(before));
    const std::vector<Vec3> &first = cacheSample(before, before + 1, motion);
    motion.control = first;
    if (u == 0) return;
    const std::vector<Vec3> &second = cacheSample(before + 1, before, motion);
    for (std::size_t i = 0; i < motion.control.size(); ++i) motion.control[i] = glm::mix(motion.control[i], second[i], u);
}

} // namespace

Mat3 restFromObject(const Object &object) {
    DMat3 rest(1);
    if (object.gltf) {
        const GltfFile &file = *object.gltf->file;
        const Pose pose = restPose(file, clipOf(*object.gltf));
        const Skin *skin = skinOf(object);
        rest = skin != nullptr ? skeletonPlacement(jointMatrices(*skin, pose)) : DMat3(pose.worldFromNode[object.gltf->node]);
    }
    rest = placementRest(object.placement) * rest;
    const double det = glm::determinant(rest);
    if (!(std::fabs(det) > 1e-30)) return Mat3(1); // a placement flattened to nothing says nothing about scale
    return Mat3(withoutRotation(det < 0 ? -rest : rest));
}

bool isRigid(const Object &object) {
    if (object.sequence || object.cache || !object.deformers.empty() || !object.rest.bind || !object.placement.scale.isConstant())
        return false;
    if (!object.gltf) return true;
    if (skinOf(object) != nullptr || !object.mesh->morphs.empty()) return false;
    // A node is rigid where nothing above it scales over time.
    const Clip *clip = clipOf(*object.gltf);
    if (clip == nullptr) return true;
    const GltfFile &file = *object.gltf->file;
    for (Index node = object.gltf->node; node != kNone; node = file.nodes[node].parent)
        for (const Channel &channel : clip->channels)
            if (channel.node == node && channel.path == ChannelPath::Scale) return false;
    return true;
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

    if (object.sequence) {
        sequenceControl(object, frame, motion);
        state.control = motion.control;
        state.controlMoved = true;
    }
    if (object.cache) {
        cacheControl(object, frame, fps, motion);
        state.control = motion.control;
        state.controlMoved = true;
    }
    double orientation = glm::determinant(DMat3(renderFromScene));
    if (object.gltf) {
        const GltfFile &file = *object.gltf->file;
        const Pose pose = evaluatePose(file, clipOf(*object.gltf), clipTime(*object.gltf, frame, fps));
        const std::vector<float> &weights = pose.morphWeights[object.gltf->node];
        if (!object.mesh->morphs.empty() && !weights.empty()) {
            morphPositions(object.mesh->positions, object.mesh->morphs, weights, motion.control);
            state.control = motion.control;
            state.controlMoved = true;
        }
        if (const Skin *skin = skinOf(object)) {
            const std::vector<DMat4> joints = jointMatrices(*skin, pose);
            for (const DMat4 &joint : joints) state.joints.push_back(toAffine(target * joint));
            orientation *= glm::determinant(DMat3(joints.front()));
            sceneFromObject = DMat4(1); // glTF: the node of a skinned mesh does not move it
        } else {
            sceneFromObject = pose.worldFromNode[object.gltf->node];
            orientation *= glm::determinant(DMat3(sceneFromObject));
        }
    }
    state.carrier = toAffine(target * sceneFromObject);
    state.mirrored = orientation < 0;
}

} // namespace taut
