#include "taut/deform/rig_poses.h"

#include <algorithm>

namespace taut {

namespace {

/// Poses kept: those of a shutter's times while one object after the other asks for them (RenderSettings::motionSteps, at most 128),
/// but of large rigs no more than take some 40 MB.
constexpr std::size_t kMostPoses = 130;
constexpr std::size_t kMostNodes = std::size_t{1} << 18;

std::size_t capacity(const Rig &rig) {
    return std::clamp<std::size_t>(kMostNodes / std::max<std::size_t>(1, rig.nodes.size()), 4, kMostPoses);
}

std::uint8_t bitOf(ChannelPath path) {
    return static_cast<std::uint8_t>(1U << static_cast<unsigned>(path));
}

} // namespace

void RigPoses::start(const std::shared_ptr<const Rig> &rig) {
    if (rig_ == rig) return;
    rig_ = rig;
    entries_.clear();
    next_ = 0;
    movedKnown_ = false;
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

bool RigPoses::isMoved(const std::shared_ptr<const Rig> &rig, const Clip *clip, Index node, ChannelPath path) {
    if (clip == nullptr) return false;
    const std::lock_guard lock(mutex_);
    start(rig);
    if (!movedKnown_ || movedClip_ != clip) {
        moved_.assign(rig->nodes.size(), 0);
        for (const Channel &channel : clip->channels)
            if (channel.node < moved_.size() && !channel.times.empty()) moved_[channel.node] |= bitOf(channel.path);
        for (std::size_t n = 0; n < moved_.size(); ++n) // parents come first
            if (rig->nodes[n].parent != kNone) moved_[n] |= moved_[rig->nodes[n].parent];
        movedKnown_ = true;
        movedClip_ = clip;
    }
    return (moved_[node] & bitOf(path)) != 0;
}

std::size_t RigPoses::evaluations() const {
    const std::lock_guard lock(mutex_);
    return evaluations_;
}

} // namespace taut
