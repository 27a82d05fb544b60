#pragma once
/// Parallel loops over index ranges. Every caller writes disjoint outputs, so results do not depend on the schedule.

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <cstddef>

namespace taut {

/// Chunk for loops over vertices or faces that do little for each.
inline constexpr std::size_t kVertexGrain = 2048;

/// Calls f(i) for i in [0, count), in chunks of at least `grain`.
template <class F> void parallelFor(std::size_t count, std::size_t grain, const F &f) {
    if (count <= grain) {
        for (std::size_t i = 0; i < count; ++i) f(i);
        return;
    }
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, count, grain), [&](const tbb::blocked_range<std::size_t> &range) {
        for (std::size_t i = range.begin(); i != range.end(); ++i) f(i);
    });
}

} // namespace taut
