/// glTF 2.0, section 3.11: animations.

#include "taut/formats/gltf_accessors.h"
#include "taut/formats/gltf_source.h"

#include <algorithm>
#include <array>

namespace taut {

namespace {

constexpr std::array<std::string_view, 3> kInterpolations{"STEP", "LINEAR", "CUBICSPLINE"};
constexpr std::array<std::string_view, 4> kPaths{"translation", "rotation", "scale", "weights"};

/// The number of `name` in `valid`.
template <std::size_t N>
std::size_t choose(const GltfSource &source, const std::string &where, std::string_view name,
                   const std::array<std::string_view, N> &valid) {
    const auto found = std::find(valid.begin(), valid.end(), name);
    if (found == valid.end()) failUnknownName({source.path + ": " + where, 0, 0, -1}, name, valid);
    return static_cast<std::size_t>(found - valid.begin());
}

std::vector<float> readTimes(const GltfSource &source, int accessor, const std::string &where) {
    std::vector<float> times = accessorFloats(source, accessor, 1, where);
    for (std::size_t k = 1; k < times.size(); ++k)
        if (!(times[k] > times[k - 1]))
            failGltf(source.path, where,
                     "key " + std::to_string(k) + " at " + std::to_string(times[k]) + " s after " + std::to_string(times[k - 1]) + " s",
                     "strictly increasing times");
    return times;
}

/// Floats of a key (for cubic splines, of each of its three), and how many of them make one element of the accessor.
struct Width {
    std::size_t perKey;
    int perElement;
};

Width widthOf(const GltfSource &source, ChannelPath path, int gltfNode, const std::string &where) {
    if (path == ChannelPath::Rotation) return {4, 4};
    if (path != ChannelPath::Weights) return {3, 3};
    const std::size_t morphs = gltfMorphCount(source, source.model.nodes[static_cast<std::size_t>(gltfNode)].mesh);
    if (morphs == 0)
        failGltf(source.path, where + ".target.path", "'weights' of a node whose mesh has no morph targets", "a node with morph targets");
    return {morphs, 1};
}

Channel readChannel(const GltfSource &source, const tinygltf::Animation &animation, std::size_t c, const std::string &clipPath,
                    const std::vector<Index> &nodeOf) {
    const tinygltf::AnimationChannel &gltf = animation.channels[c];
    const std::string where = jsonPath(clipPath + ".channels", c);
    Channel channel;
    channel.node = nodeOf[checkedIndex(source, where + ".target.node", gltf.target_node, nodeOf.size(), "nodes")];
    channel.path = static_cast<ChannelPath>(choose(source, where + ".target.path", gltf.target_path, kPaths));
    const Index sampler = checkedIndex(source, where + ".sampler", gltf.sampler, animation.samplers.size(), "samplers in this animation");
    const tinygltf::AnimationSampler &keys = animation.samplers[sampler];
    const std::string samplerPath = jsonPath(clipPath + ".samplers", sampler);
    channel.interpolation = static_cast<Interpolation>(choose(source, samplerPath + ".interpolation", keys.interpolation, kInterpolations));
    const Width width = widthOf(source, channel.path, gltf.target_node, where);
    channel.width = static_cast<Index>(width.perKey);
    channel.times = readTimes(source, keys.input, samplerPath + ".input");
    channel.values = accessorFloats(source, keys.output, width.perElement, samplerPath + ".output");
    const std::size_t expected = channel.times.size() * width.perKey * (channel.interpolation == Interpolation::CubicSpline ? 3 : 1);
    if (channel.values.size() != expected)
        failGltf(source.path, samplerPath + ".output", std::to_string(channel.values.size()) + " numbers",
                 std::to_string(expected) + " for " + std::to_string(channel.times.size()) + " keys of " +
                     std::string(kPaths[static_cast<std::size_t>(channel.path)]));
    return channel;
}

} // namespace

void readGltfClips(const GltfSource &source, GltfFile &file, const std::vector<Index> &nodeOf, Warnings &warnings) {
    for (std::size_t a = 0; a < source.model.animations.size(); ++a) {
        const tinygltf::Animation &gltf = source.model.animations[a];
        const std::string where = jsonPath("animations", a);
        Clip clip;
        clip.name = nameOr(gltf.name, "clip", a);
        // tinygltf leaves out channels without a target node, which is what glTF asks for.
        const std::size_t listed = source.json["animations"][a].value("channels", nlohmann::json::array()).size();
        if (listed != gltf.channels.size())
            warnings.add(source.path + ": " + where + ": " + std::to_string(listed - gltf.channels.size()) +
                         " channels without a target node are left out");
        for (std::size_t c = 0; c < gltf.channels.size(); ++c) {
            clip.channels.push_back(readChannel(source, gltf, c, where, nodeOf));
            clip.duration = std::max(clip.duration, clip.channels.back().times.back());
        }
        file.rig.clips.push_back(std::move(clip));
    }
}

} // namespace taut
