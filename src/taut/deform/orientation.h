#pragma once
/// Which side of a moved surface is outside: where the map turns space over, the winding of moved faces names the inner side.

#include "taut/deform/affine.h"

#include <atomic>
#include <vector>

namespace taut {

/// What a map does to orientation at the points of a mesh.
struct Orientation {
    bool mirrored = false;       ///< everywhere; not read where `at` says
    std::vector<signed char> at; ///< [points]: 1 kept, -1 turned over; empty: the same everywhere

    Orientation(bool everywhere = false) : mirrored(everywhere) {} // NOLINT: the same everywhere is an orientation
};

/// Gathers an Orientation point by point, from many threads.
class OrientationGatherer {
  public:
    /// `varies`: it may differ from point to point; else it is `usual` everywhere, which also decides where a map is too flat to tell.
    OrientationGatherer(bool usual, bool varies, std::size_t count, Orientation &out) : out_(out), usual_(usual), varies_(varies) {
        if (varies) out_.at.resize(count);
    }
    /// `side`: orientationOf() the map at the point. Returns whether it is turned over.
    bool set(std::size_t point, int side) {
        if (!varies_) return usual_;
        const bool turned = side == 0 ? usual_ : side < 0;
        out_.at[point] = turned ? -1 : 1;
        std::atomic<bool> &seen = turned ? turned_ : kept_;
        if (!seen.load(std::memory_order_relaxed)) seen.store(true, std::memory_order_relaxed);
        return turned;
    }
    void finish() {
        out_.mirrored = varies_ ? turned_ && !kept_ : usual_;
        if (!(turned_ && kept_)) out_.at.clear();
    }

  private:
    Orientation &out_;
    bool usual_, varies_;
    std::atomic<bool> turned_{false}, kept_{false};
};

struct MotionState;
struct SkinWeights;

/// Of a motion's map at the control points.
void orientationOfPoints(const MotionState &motion, const SkinWeights &skin, Orientation &out);

} // namespace taut
