#include "taut/scene/check_parts.h"

namespace taut {

namespace {

bool isFinite(const DVec3 &v) {
    return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}
bool isFinite(const DMat4 &m) {
    for (int c = 0; c < 4; ++c)
        if (!isFinite(DVec3(m[c])) || !std::isfinite(m[c].w)) return false;
    return true;
}
bool areFinite(const std::vector<float> &values) {
    return firstWhere(values.size(), [&](std::size_t i) { return !std::isfinite(values[i]); }) == values.size();
}

void checkNode(const Part &part, const Rig &rig, Index n) {
    const Node &node = rig.nodes[n];
    if (node.parent != kNone && node.parent >= n)
        part.fail("rig.nodes", "node " + std::to_string(n) + " before its parent", "parents before their children");
    checkOptionalIndex(part, "rig.nodes.skin", node.skin, rig.skins.size(), "skins");
    if (!isFinite(node.translation) || !isFinite(node.scale) || !(glm::dot(node.rotation, node.rotation) < kInfinity) ||
        (node.matrix && !isFinite(*node.matrix)) || !areFinite(node.morphWeights))
        part.fail("rig.nodes", "numbers that are not finite in node " + std::to_string(n), "finite numbers");
}

void checkChannel(const Part &part, const Channel &channel, std::size_t nodes) {
    checkIndex(part, "rig.clips.channels.node", channel.node, nodes, "nodes");
    const Index width = channel.path == ChannelPath::Rotation ? 4 : channel.path == ChannelPath::Weights ? channel.width : 3;
    checkCount(part, "rig.clips.channels.width", channel.width, width);
    const std::size_t perKey = channel.width * (channel.interpolation == Interpolation::CubicSpline ? 3U : 1U);
    checkCount(part, "rig.clips.channels.values", channel.values.size(), channel.times.size() * perKey);
    if (!areFinite(channel.times) || !areFinite(channel.values))
        part.fail("rig.clips.channels", "numbers that are not finite", "finite numbers");
    for (std::size_t k = 1; k < channel.times.size(); ++k)
        if (!(channel.times[k] > channel.times[k - 1]))
            part.fail("rig.clips.channels.times", "key " + std::to_string(k) + " not after the one before", "increasing times");
}

} // namespace

void checkRig(const Part &part, const Rig &rig) {
    for (Index n = 0; n < rig.nodes.size(); ++n) checkNode(part, rig, n);
    for (const Skin &skin : rig.skins) {
        if (skin.joints.empty()) part.fail("rig.skins.joints", "none", "at least one");
        for (const Index joint : skin.joints) checkIndex(part, "rig.skins.joints", joint, rig.nodes.size(), "nodes");
        checkCount(part, "rig.skins.inverseBindMatrix", skin.inverseBindMatrix.size(), skin.joints.size());
        for (const DMat4 &matrix : skin.inverseBindMatrix)
            if (!isFinite(matrix)) part.fail("rig.skins.inverseBindMatrix", "numbers that are not finite", "finite numbers");
    }
    for (const Clip &clip : rig.clips)
        for (const Channel &channel : clip.channels) checkChannel(part, channel, rig.nodes.size());
}

void checkMotion(const Part &part, const RigMotion &motion) {
    checkIndex(part, "rig.node", motion.node, motion.rig->nodes.size(), "nodes");
    checkOptionalIndex(part, "rig.clip", motion.clip, motion.rig->clips.size(), "clips");
}

void checkDeformer(const Part &part, const DeformerKeys &keys) {
    checkVector(part, "deformers.centre", keys.centre);
    for (const int axis : {keys.axis, keys.axis2}) checkInteger(part, "deformers.axis", axis, {0, 2});
    switch (keys.type) {
    case DeformerType::Stretch: checkKeys(part, "deformers.factor", keys.factor, kPositive); break;
    case DeformerType::Shear: checkKeys(part, "deformers.amount", keys.amount, kAnyNumber); break;
    case DeformerType::Bend: part.failOn("deformers", mistakeInBend(keys)); [[fallthrough]];
    case DeformerType::Twist:
        checkKeys(part, "deformers.amount", keys.amount, kDegrees, radians(1));
        part.failOn("deformers", mistakeInRange(keys));
        break;
    case DeformerType::Taper:
        checkKeys(part, "deformers.amount", keys.amount, kTaper);
        part.failOn("deformers", mistakeInRange(keys));
        break;
    case DeformerType::Lattice: {
        part.failOn("deformers", mistakeInLatticeBox(keys));
        std::size_t points = 1;
        for (const int count : keys.latticePoints) {
            checkInteger(part, "deformers.latticePoints", count, kLatticePoints);
            points *= static_cast<std::size_t>(count);
        }
        if (keys.latticeOffsets.size() > points) checkCount(part, "deformers.latticeOffsets", keys.latticeOffsets.size(), points);
        for (const Keyed<DVec3> &offset : keys.latticeOffsets) checkKeys(part, "deformers.latticeOffsets", offset);
        break;
    }
    case DeformerType::Wave:
        checkKeys(part, "deformers.amplitude", keys.amplitude, kAnyNumber);
        checkKeys(part, "deformers.wavelength", keys.wavelength, kPositive);
        checkKeys(part, "deformers.phase", keys.phase, kDegrees, radians(1));
        break;
    }
    // setDeformer() evaluates all of them, whatever the type.
    for (const Keyed<double> *unused : {&keys.amount, &keys.amplitude, &keys.wavelength, &keys.phase})
        if (unused->keys.empty()) part.fail("deformers", "no key", "at least one");
    if (keys.factor.keys.empty()) part.fail("deformers.factor", "no key", "at least one");
}

} // namespace taut
