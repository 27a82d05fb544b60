#pragma once
/// Poses of a rig by clip and time: evaluated once, however many meshes hang from its nodes. A file of n nodes has n objects that
/// ask for the pose of the same frame, and a pose holds all n nodes.

#include "taut/deform/animation.h"

#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <utility>

namespace taut {

/// Safe to use from several threads. Knows one rig at a time, by its address, and keeps it alive: a rig is not rewritten once it
/// has been asked for; another one starts anew. Clips are those of the rig.
class RigPoses {
  public:
    /// evaluatePose() at a time.
    std::shared_ptr<const Pose> at(const std::shared_ptr<const Rig> &rig, const Clip *clip, double seconds);
    /// restPose().
    std::shared_ptr<const Pose> rest(const std::shared_ptr<const Rig> &rig, const Clip *clip);
    /// Whether `clip` has a channel of this path with keys at a node or at one above it.
    bool isMoved(const std::shared_ptr<const Rig> &rig, const Clip *clip, Index node, ChannelPath path);
    /// The channels of `clip` that move a node, in the clip's order.
    std::vector<const Channel *> channelsOf(const std::shared_ptr<const Rig> &rig, const Clip *clip, Index node);
    /// Remembers what was told of a node below a linear map: `tell`'s answer is asked for once for each clip and node while the map and
    /// the rig stay. `tell` may use this object.
    bool once(const std::shared_ptr<const Rig> &rig, const Clip *clip, Index node, const DMat3 &above, const std::function<bool()> &tell);
    /// How many poses were evaluated so far, rest poses with them.
    [[nodiscard]] std::size_t evaluations() const;

  private:
    struct Entry {
        const Clip *clip;
        bool atRest;
        double seconds;
        std::shared_ptr<const Pose> pose;
    };
    void sortChannels(const Clip &clip);
    void start(const std::shared_ptr<const Rig> &rig);
    template <class Evaluate> std::shared_ptr<const Pose> find(const Entry &wanted, const Evaluate &evaluate);

    mutable std::mutex mutex_;
    std::shared_ptr<const Rig> rig_;
    std::vector<Entry> entries_; ///< the oldest is overwritten
    std::size_t next_ = 0;
    std::size_t evaluations_ = 0;
    const Clip *sortedClip_ = nullptr;
    std::vector<std::vector<const Channel *>> channels_; ///< [nodes] of sortedClip_
    struct Told {
        DMat3 above;
        bool answer;
    };
    std::map<std::pair<const Clip *, Index>, Told> told_;
};

} // namespace taut
