#include "taut/deform/rig_poses.h"

#include <algorithm>

namespace taut {

namespace {

/// Poses kept: those of a shutter's times while one object after the other asks for them (RenderSettings::motionSteps, at most 128),
/// but of large rigs no more than take some 40 MB.
constexpr std::size_t kMostPoses = 130;
constexpr std::size_t kMostNodes = std::size_t{1} << 18;

std::size_t capacity(const Rig &rig) {
    constexpr std::size_t kWeightsPerNode = 32; // take as much as a node's matrix
    std::size_t weights = 0;
    for (const Node &node : rig.nodes) weights += node.morphWeights.size();
    return std::clamp<std::size_t>(kMostNodes / std::max<std::size_t>(1, rig.nodes.size() + weights / kWeightsPerNode), 4, kMostPoses);
}

} // namespace

void RigPoses::start(const std::shared_ptr<const Rig> &rig) {
    if (rig_ == rig) return;
    rig_ = rig;
    entries_.clear();
    next_ = 0;
    sortedClip_ = nullptr;
    told_.clear();
}

template <class Evaluate> std::shared_ptr<const Pose> RigPoses::find(const Entry &wanted, const Evaluate &evaluate) {
    const auto same = [&](const Entry &e) { return e.clip == wanted.clip && e.atRest == wanted.atRest && e.seconds == wanted.seconds; };
    if (const auto known = std::find_if(entries_.begin(), entries_.end(), same); known != entries_.end()) return known->pose;
    ++evaluations_;
    Entry made = wanted;
    made.pose = std::make_shared<const Pose>(evaluate());
    if (entries_.size() < capacity(*rig_)) return entries_.emplace_back(std::move(made)).pose;
    Entry &oldest = entries_[next_++ % entries_.size()];
    oldest = std::move(made);
    return oldest.pose;
}

std::shared_ptr<const Pose> RigPoses::at(const std::shared_ptr<const Rig> &rig, const Clip *clip, double seconds) {
    const std::lock_guard lock(mutex_);
    start(rig);
    return find({clip, false, seconds, nullptr}, [&] { return evaluatePose(*rig, clip, seconds); });
}

std::shared_ptr<const Pose> RigPoses::rest(const std::shared_ptr<const Rig> &rig, const Clip *clip) {
    const std::lock_guard lock(mutex_);
    start(rig);
    return find({clip, true, 0, nullptr}, [&] { return restPose(*rig, clip); });
}

void RigPoses::sortChannels(const Clip &clip) {
    if (sortedClip_ == &clip) return;
    channels_.assign(rig_->nodes.size(), {});
    for (const Channel &channel : clip.channels)
        if (channel.node < channels_.size()) channels_[channel.node].push_back(&channel);
    sortedClip_ = &clip;
}

bool RigPoses::isMoved(const std::shared_ptr<const Rig> &rig, const Clip *clip, Index node, ChannelPath path) {
    if (clip == nullptr) return false;
    const std::lock_guard lock(mutex_);
    start(rig);
    sortChannels(*clip);
    const auto moves = [&](const Channel *channel) { return channel->path == path && !channel->times.empty(); };
    for (; node != kNone; node = rig->nodes[node].parent)
        if (std::any_of(channels_[node].begin(), channels_[node].end(), moves)) return true;
    return false;
}

std::vector<const Channel *> RigPoses::channelsOf(const std::shared_ptr<const Rig> &rig, const Clip *clip, Index node) {
    if (clip == nullptr) return {};
    const std::lock_guard lock(mutex_);
    start(rig);
    sortChannels(*clip);
    return channels_[node];
}

bool RigPoses::once(const std::shared_ptr<const Rig> &rig, const Clip *clip, Index node, const DMat3 &above,
                    const std::function<bool()> &tell) {
    {
        const std::lock_guard lock(mutex_);
        start(rig);
        if (const auto known = told_.find({clip, node}); known != told_.end() && known->second.above == above) return known->second.answer;
    }
    const bool answer = tell();
    const std::lock_guard lock(mutex_);
    start(rig);
    told_[{clip, node}] = {above, answer};
    return answer;
}

std::size_t RigPoses::evaluations() const {
    const std::lock_guard lock(mutex_);
    return evaluations_;
}

} // namespace taut
