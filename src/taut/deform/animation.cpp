#include "taut/deform/animation.h"

#include <algorithm>
#include <cstddef>
#include <utility>

namespace taut {
namespace {

/// The keys around a time. Outside the keys both are the end key, and u = 0.
struct KeySpan {
    std::size_t previous = 0;
    std::size_t next = 0;
    double u = 0;        ///< position between the keys, [0, 1)
    double interval = 0; ///< seconds between the keys
};

KeySpan keysAround(const std::vector<float> &times, double seconds) {
    if (!(seconds > times.front())) return {};
    if (seconds >= times.back()) return {times.size() - 1, times.size() - 1, 0, 0};
    const auto after = std::upper_bound(times.begin(), times.end(), seconds, [](double s, float time) { return s < time; });
    const auto next = static_cast<std::size_t>(after - times.begin());
    const double start = times[next - 1];
    const double interval = times[next] - start;
    return {next - 1, next, (seconds - start) / interval, interval};
}

enum KeyPart { InTangent, Value, OutTangent };

double keyComponent(const Channel &channel, std::size_t key, KeyPart part, std::size_t component) {
    const std::size_t element = channel.interpolation == Interpolation::CubicSpline ? 3 * key + part : key;
    return channel.values[element * channel.width + component];
}

/// One float of the channel, interpolated for itself. Written as value + change, so that equal keys give their value exactly.
double componentAt(const Channel &channel, const KeySpan &span, std::size_t component) {
    const double from = keyComponent(channel, span.previous, Value, component);
    if (channel.interpolation == Interpolation::Step || span.previous == span.next) return from;
    const double change = keyComponent(channel, span.next, Value, component) - from;
    const double u = span.u;
    if (channel.interpolation == Interpolation::Linear) return from + u * change;
    // glTF 2.0, appendix C: tangents are per second, so the Hermite basis has them times the interval.
    const double out = span.interval * keyComponent(channel, span.previous, OutTangent, component);
    const double in = span.interval * keyComponent(channel, span.next, InTangent, component);
    return from + u * u * (3 - 2 * u) * change + u * (1 - u) * ((1 - u) * out - u * in);
}

DVec3 vectorAt(const Channel &channel, const KeySpan &span) {
    return {componentAt(channel, span, 0), componentAt(channel, span, 1), componentAt(channel, span, 2)};
}

/// `q` with unit length; no rotation where it has none.
DQuat unitRotation(const DQuat &q) {
    const double length = glm::length(q);
    return length > 0 && std::isfinite(length) ? q / length : DQuat(1, 0, 0, 0);
}

DQuat keyRotation(const Channel &channel, std::size_t key) {
    const auto part = [&](std::size_t component) { return keyComponent(channel, key, Value, component); };
    return unitRotation(DQuat(part(3), part(0), part(1), part(2)));
}

/// Spherical interpolation along the shorter of the two arcs (appendix C), of unit quaternions.
DQuat shortestSlerp(const DQuat &from, DQuat to, double u) {
    if (glm::dot(from, to) < 0) to = -to;
    const double angle = 2 * std::atan2(glm::length(to - from), glm::length(to + from)); // keeps its digits where acos does not
    if (angle < 1e-6) return unitRotation(from + (to - from) * u);
    return unitRotation((from * std::sin((1 - u) * angle) + to * std::sin(u * angle)) / std::sin(angle));
}

DQuat rotationAt(const Channel &channel, const KeySpan &span) {
    if (channel.interpolation == Interpolation::Linear && span.previous != span.next)
        return shortestSlerp(keyRotation(channel, span.previous), keyRotation(channel, span.next), span.u);
    return unitRotation(
        DQuat(componentAt(channel, span, 3), componentAt(channel, span, 0), componentAt(channel, span, 1), componentAt(channel, span, 2)));
}

/// Translation, rotation and scale of a node without a matrix.
struct LocalTransform {
    DVec3 translation{0};
    DQuat rotation{1, 0, 0, 0};
    DVec3 scale{1};
};

DMat4 matrixOf(const LocalTransform &local) {
    const DMat3 rotation = glm::mat3_cast(local.rotation);
    DMat4 matrix(1);
    for (int axis = 0; axis < 3; ++axis) matrix[axis] = DVec4(rotation[axis] * local.scale[axis], 0);
    matrix[3] = DVec4(local.translation, 1);
    return matrix;
}

/// The state of all nodes before they are composed.
struct LocalPose {
    std::vector<LocalTransform> transforms;       ///< [nodes]
    std::vector<std::vector<float>> morphWeights; ///< [nodes]
};

LocalPose storedPose(const Rig &rig) {
    LocalPose pose;
    pose.transforms.reserve(rig.nodes.size());
    pose.morphWeights.reserve(rig.nodes.size());
    for (const Node &node : rig.nodes) {
        pose.transforms.push_back({node.translation, unitRotation(node.rotation), node.scale});
        pose.morphWeights.push_back(node.morphWeights);
    }
    return pose;
}

Pose composed(const Rig &rig, LocalPose &&local) {
    Pose pose;
    pose.morphWeights = std::move(local.morphWeights);
    pose.worldFromNode.reserve(rig.nodes.size());
    for (std::size_t i = 0; i < rig.nodes.size(); ++i) {
        const Node &node = rig.nodes[i];
        const DMat4 parentFromNode = node.matrix ? *node.matrix : matrixOf(local.transforms[i]);
        pose.worldFromNode.push_back(node.parent == kNone ? parentFromNode : pose.worldFromNode[node.parent] * parentFromNode);
    }
    return pose;
}

/// A channel that moves nothing: without a target or without keys.
bool isIdle(const Rig &rig, const Channel &channel) {
    return channel.node >= rig.nodes.size() || channel.times.empty();
}

void applyChannel(const Channel &channel, double seconds, LocalPose &pose) {
    if (channel.path == ChannelPath::Weights) {
        pose.morphWeights[channel.node] = evaluateChannel(channel, seconds);
        return;
    }
    // A node with a matrix is not animated (glTF 2.0, 3.11): composed() takes its matrix and leaves these aside.
    LocalTransform &transform = pose.transforms[channel.node];
    const KeySpan span = keysAround(channel.times, seconds);
    switch (channel.path) {
    case ChannelPath::Translation: transform.translation = vectorAt(channel, span); break;
    case ChannelPath::Rotation: transform.rotation = rotationAt(channel, span); break;
    case ChannelPath::Scale: transform.scale = vectorAt(channel, span); break;
    case ChannelPath::Weights: break;
    }
}

} // namespace

bool hasEqualKeys(const Channel &channel) {
    const bool cubic = channel.interpolation == Interpolation::CubicSpline;
    for (std::size_t key = 0; key < channel.times.size(); ++key)
        for (std::size_t c = 0; c < channel.width; ++c) {
            if (keyComponent(channel, key, Value, c) != keyComponent(channel, 0, Value, c)) return false;
            if (cubic && (keyComponent(channel, key, InTangent, c) != 0 || keyComponent(channel, key, OutTangent, c) != 0)) return false;
        }
    return true;
}

std::vector<float> evaluateChannel(const Channel &channel, double seconds) {
    std::vector<float> values(channel.width, 0.0F);
    if (channel.times.empty()) return values;
    const KeySpan span = keysAround(channel.times, seconds);
    if (channel.path == ChannelPath::Rotation) {
        const DQuat q = rotationAt(channel, span);
        return {static_cast<float>(q.x), static_cast<float>(q.y), static_cast<float>(q.z), static_cast<float>(q.w)};
    }
    for (std::size_t c = 0; c < values.size(); ++c) values[c] = static_cast<float>(componentAt(channel, span, c));
    return values;
}

Pose evaluatePose(const Rig &rig, const Clip *clip, double seconds) {
    LocalPose pose = storedPose(rig);
    if (clip != nullptr)
        for (const Channel &channel : clip->channels)
            if (!isIdle(rig, channel)) applyChannel(channel, seconds, pose);
    return composed(rig, std::move(pose));
}

Pose restPose(const Rig &rig, const Clip *clip) {
    LocalPose pose = storedPose(rig);
    if (clip != nullptr)
        for (const Channel &channel : clip->channels)
            if (channel.path == ChannelPath::Scale && !isIdle(rig, channel) && hasEqualKeys(channel)) applyChannel(channel, 0, pose);
    return composed(rig, std::move(pose));
}

std::vector<DMat4> jointMatrices(const Skin &skin, const Pose &pose) {
    std::vector<DMat4> matrices;
    matrices.reserve(skin.joints.size());
    for (std::size_t i = 0; i < skin.joints.size(); ++i) matrices.push_back(pose.worldFromNode[skin.joints[i]] * skin.inverseBindMatrix[i]);
    return matrices;
}

} // namespace taut
