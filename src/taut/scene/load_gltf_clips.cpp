/// Which clips of a glTF file play, and what a file holds.

#include "taut/base/error.h"
#include "taut/scene/load_gltf.h"

#include <algorithm>
#include <set>

namespace taut {

namespace {

using Moved = std::set<std::pair<Index, ChannelPath>>;

Moved movedBy(const Clip &clip) {
    Moved moved;
    for (const Channel &channel : clip.channels) moved.emplace(channel.node, channel.path);
    return moved;
}

/// How much of what is not shown in a list.
constexpr std::size_t kMostNames = 4;

std::string listOf(const std::vector<std::string> &names) {
    std::string list;
    for (std::size_t i = 0; i < std::min(names.size(), kMostNames); ++i) list += (i == 0 ? "" : ", ") + quoted(names[i]);
    return list + (names.size() > kMostNames ? ", ..." : "");
}

} // namespace

std::shared_ptr<const Clip> clipsTogether(const GltfFile &file, Warnings &warnings) {
    const std::vector<Clip> &clips = file.rig.clips;
    if (clips.size() < 2) return nullptr;
    Moved taken;
    std::vector<const Clip *> playing;
    std::vector<std::string> left;
    for (const Clip &clip : clips) {
        const Moved moved = movedBy(clip);
        // Clips of one skeleton are alternatives, each whole: a channel that the first lacks would mix a walk into a jump.
        if (std::any_of(moved.begin(), moved.end(), [&](const auto &channel) { return taken.count(channel) != 0; })) {
            left.push_back(clip.name);
            continue;
        }
        taken.insert(moved.begin(), moved.end());
        playing.push_back(&clip);
    }
    if (!left.empty())
        warnings.add(file.path + ": " + std::to_string(left.size()) + " of " + std::to_string(clips.size()) +
                     " clips move what an earlier one moves and do not play (" + listOf(left) + "): `clip` chooses one");
    if (playing.size() < 2) return nullptr;
    auto together = std::make_shared<Clip>();
    for (const Clip *clip : playing) {
        together->name += (together->name.empty() ? "" : " + ") + clip->name;
        together->channels.insert(together->channels.end(), clip->channels.begin(), clip->channels.end());
        together->duration = std::max(together->duration, clip->duration);
    }
    return together;
}

SceneFile summaryOf(const GltfFile &file) {
    SceneFile summary;
    summary.path = file.path;
    for (const Clip &clip : file.rig.clips) summary.clips.emplace_back(clip.name, static_cast<double>(clip.duration));
    for (const Index node : file.sceneNodes) {
        if (file.attached[node].camera != kNone) summary.cameras.push_back(file.rig.nodes[node].name);
        if (file.attached[node].light != kNone) summary.lights.push_back(file.rig.nodes[node].name);
    }
    summary.variants = file.variants;
    summary.leftOut = file.leftOut.text();
    return summary;
}

} // namespace taut
