/// glTF 2.0, section 3.11: animations.

#include "taut/formats/gltf_accessors.h"

#include <algorithm>
#include <array>

namespace taut {

namespace {

constexpr std::array<std::string_view, 3> kInterpolations{"STEP", "LINEAR", "CUBICSPLINE"};
constexpr std::array<std::string_view, 4> kPaths{"translation", "rotation", "scale", "weights"};

std::vector<float> readTimes(const GltfSource &source, const GltfValue &reference) {
    std::vector<float> times = accessorFloats(source, reference, 1);
    for (std::size_t k = 1; k < times.size(); ++k)
        if (!(times[k] > times[k - 1]))
            reference.fail("key " + std::to_string(k) + " at " + std::to_string(times[k]) + " s after " + std::to_string(times[k - 1]) +
                               " s",
                           "strictly increasing times");
    return times;
}

/// Floats of a key (for cubic splines, of each of its three), and how many of them make one element of the accessor.
struct Width {
    std::size_t perKey;
    int perElement;
};

Width widthOf(const GltfSource &source, ChannelPath path, const GltfValue &target) {
    if (path == ChannelPath::Rotation) return {4, 4};
    if (path != ChannelPath::Weights) return {3, 3};
    const GltfValue node = source["nodes"][static_cast<std::size_t>(target["node"].integer(0))];
    const std::size_t morphs = gltfMorphCount(gltfMeshOf(source, node));
    if (morphs == 0) target["path"].fail("'weights' of a node whose mesh has no morph targets", "a node with morph targets");
    return {morphs, 1};
}

Channel readChannel(const GltfSource &source, const GltfValue &gltf, const GltfValue &samplers, const std::vector<Index> &nodeOf) {
    const GltfValue target = gltf["target"];
    Channel channel;
    channel.node = nodeOf[target["node"].index(nodeOf.size(), "nodes")];
    channel.path = static_cast<ChannelPath>(target["path"].choice(kPaths));
    const GltfValue keys = samplers[gltf["sampler"].index(samplers.size(), "samplers in this animation")];
    if (keys.has("interpolation")) channel.interpolation = static_cast<Interpolation>(keys["interpolation"].choice(kInterpolations));
    const Width width = widthOf(source, channel.path, target);
    channel.width = static_cast<Index>(width.perKey);
    channel.times = readTimes(source, keys["input"]);
    channel.values = accessorFloats(source, keys["output"], width.perElement);
    const std::size_t expected = channel.times.size() * width.perKey * (channel.interpolation == Interpolation::CubicSpline ? 3 : 1);
    if (channel.values.size() != expected)
        keys["output"].fail(std::to_string(channel.values.size()) + " numbers",
                            std::to_string(expected) + " for " + std::to_string(channel.times.size()) + " keys of " +
                                std::string(kPaths[static_cast<std::size_t>(channel.path)]));
    return channel;
}

/// The matrix of a node as translation, rotation and scale, so that channels can take the place of one. glTF forbids to animate such a
/// node, and wants matrices that can be taken apart; files do the one and keep the other.
void takeApart(Node &node) {
    if (!node.matrix) return;
    const DMat4 &m = *node.matrix;
    DMat3 linear(m);
    for (int axis = 0; axis < 3; ++axis) node.scale[axis] = glm::length(linear[axis]);
    if (glm::determinant(linear) < 0) node.scale.x = -node.scale.x;
    for (int axis = 0; axis < 3; ++axis) {
        if (node.scale[axis] == 0) return; // flat: it stays a matrix, without motion
        linear[axis] /= node.scale[axis];
    }
    node.rotation = glm::normalize(glm::quat_cast(linear));
    node.translation = DVec3(m[3]);
    node.matrix.reset();
}

} // namespace

void readGltfClips(const GltfSource &source, GltfFile &file, const std::vector<Index> &nodeOf, Warnings &warnings) {
    const GltfValue animations = source["animations"];
    for (std::size_t a = 0; a < animations.size(); ++a) {
        const GltfValue gltf = animations[a];
        const GltfValue channels = gltf["channels"];
        const GltfValue samplers = gltf["samplers"];
        Clip clip;
        clip.name = gltf.nameOr("clip", a);
        std::vector<GltfValue> targeted; // glTF asks to leave out what has no target node
        std::size_t lost = 0;
        for (std::size_t c = 0; c < channels.size(); ++c) {
            const GltfValue target = channels[c]["target"];
            if (target["path"].text() == "pointer") // KHR_animation_pointer
                file.leftOut.add("animation channel of a pointer");
            else if (target.has("node"))
                targeted.push_back(channels[c]);
            else
                ++lost;
        }
        if (lost != 0) warnings.add(gltf.place() + ": " + std::to_string(lost) + " channels without a target node are left out");
        for (const GltfValue &channel : targeted) {
            clip.channels.push_back(readChannel(source, channel, samplers, nodeOf));
            clip.duration = std::max(clip.duration, clip.channels.back().times.back());
            if (clip.channels.back().path != ChannelPath::Weights) takeApart(file.rig.nodes[clip.channels.back().node]);
        }
        file.rig.clips.push_back(std::move(clip));
    }
}

} // namespace taut
