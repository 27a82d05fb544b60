/// A frame in one call: a FrameRender from its first sample to its last.

#include "taut/render/frame_render.h"

#include <algorithm>
#include <chrono>

namespace taut {

FrameResult renderFrame(const RenderScene &scene, const FrameOptions &options) {
    const auto start = std::chrono::steady_clock::now();
    const auto seconds = [&] { return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count(); };
    FrameOptions told = options;
    if (options.progress && options.seconds)
        told.progress = [&](double share) { return options.progress(std::min(1.0, std::max(share, seconds() / *options.seconds))); };
    FrameRender frame(scene, told);
    FrameState state = FrameState::Going;
    const bool inPasses = options.seconds.has_value();
    do state = frame.advance({inPasses ? kTimedPass : 0, 0});
    while (state == FrameState::Going && !(inPasses && seconds() >= *options.seconds));
    const StageTimes times = frame.times();
    const RayCounts counts = frame.counts();
    const std::optional<PictureNoiseReached> reached = frame.reached();
    return {std::move(frame).takeFilm(), times, counts, reached, seconds(), state != FrameState::Stopped};
}

} // namespace taut
