#include "resources.h"

#include "taut/base/peak_memory.h"
#include "taut/render/light_groups.h"

#include <algorithm>
#include <chrono>

namespace taut::app {

namespace {

using Clock = std::chrono::steady_clock;

constexpr int kPatch = 16;  ///< pixels
constexpr int kPatches = 8; ///< along either side of the picture
constexpr int kSamples = 2;

double secondsSince(Clock::time_point start) {
    return std::chrono::duration<double>(Clock::now() - start).count();
}

/// Seconds of one thread for one sample of one pixel, on average over patches that lie evenly in the window. A patch is one tile: one
/// thread renders it.
double sampleSeconds(const RenderScene &scene, FrameOptions options) {
    const Window w = options.window;
    options.spp = kSamples;
    options.noise.reset();
    options.picture.reset();
    options.seconds.reset();
    double seconds = 0;
    std::uint64_t samples = 0;
    for (int i = 0; i < kPatches * kPatches; ++i) {
        const int x = (w.x0 + w.width() * (2 * (i % kPatches) + 1) / (2 * kPatches)) / kPatch * kPatch;
        const int y = (w.y0 + w.height() * (2 * (i / kPatches) + 1) / (2 * kPatches)) / kPatch * kPatch;
        options.window = {std::max(x, w.x0), std::max(y, w.y0), std::min(x + kPatch, w.x1), std::min(y + kPatch, w.y1)};
        FrameRender patch(scene, options);
        patch.advance();
        seconds += patch.seconds();
        samples += static_cast<std::uint64_t>(options.window.width()) * static_cast<std::uint64_t>(options.window.height()) * kSamples;
    }
    return seconds / static_cast<double>(samples);
}

} // namespace

Resources measureResources(RenderScene &scene, const FrameOptions &options, Clock::time_point began) {
    Resources resources;
    resources.serialSeconds = secondsSince(began);
    const auto start = Clock::now();
    StageTimes times;
    scene.setFrame(scene.scene().render.frames.front(), times);
    resources.updateSeconds = secondsSince(start);
    FrameOptions whole = options;
    if (whole.window.empty()) whole.window = {0, 0, scene.scene().render.width, scene.scene().render.height};
    const double pixels = static_cast<double>(whole.window.width()) * whole.window.height();
    resources.frameSeconds = sampleSeconds(scene, whole) * pixels * whole.spp;
    // A pixel's exact sums and counts, its means as floats, and these once more as a file.
    const auto channels = static_cast<double>(Film({}, whole.aovs, layersOf(whole.layers, scene.scene())).channelNames().size());
    const bool shares = whole.picture && mayShare(whole, scene.scene().render);
    const double pixel = channels * (sizeof(ExactSum) + 2 * sizeof(float)) + 2 * sizeof(std::uint32_t) +
                         (shares ? static_cast<double>(sizeof(SharedSums::Shares)) : 0);
    resources.megabytes = peakMegabytes() + pixels * pixel / 1e6;
    return resources;
}

} // namespace taut::app
