#include "taut/render/frame_window.h"

#include "taut/base/error.h"

#include <algorithm>

namespace taut {

std::vector<Window> tilesOf(const Window &window) {
    constexpr int kTile = AdaptivePasses::kTile;
    std::vector<Window> tiles;
    for (int y = window.y0 / kTile * kTile; y < window.y1; y += kTile)
        for (int x = window.x0 / kTile * kTile; x < window.x1; x += kTile)
            tiles.push_back(
                {std::max(x, window.x0), std::max(y, window.y0), std::min(x + kTile, window.x1), std::min(y + kTile, window.y1)});
    return tiles;
}

Window windowOf(const FrameOptions &options, const RenderSettings &render) {
    return options.window.empty() ? Window{0, 0, render.width, render.height} : options.window;
}

bool mayShare(const FrameOptions &options, const RenderSettings &render) {
    return !render.boxFilter && options.aovs.empty() && options.layers.words().empty() && options.denoiseBlock == 0;
}

Window affordable(const Scene &scene, const Window &window, bool shares) {
    if (!scene.budget || window.empty()) return window;
    constexpr std::size_t channels = 4;
    const double pixel = 2 * sizeof(std::uint32_t) + static_cast<double>(channels) * (sizeof(ExactSum) + sizeof(float)) +
                         (shares ? sizeof(SharedSums::Shares) : 0);
    scene.budget->require(pixel * window.width() * window.height(), scene.path,
                          "a picture of " + std::to_string(window.width()) + " x " + std::to_string(window.height()) + " pixels of " +
                              std::to_string(channels) + " channels");
    return window;
}

void checkOptions(const FrameOptions &options, const RenderSettings &render) {
    const Window whole{0, 0, render.width, render.height};
    if (options.spp < 1) throw InputError("frame: found " + std::to_string(options.spp) + " samples a pixel, expected at least 1");
    if (options.firstSample < 0 || options.firstSample > (1 << 30))
        throw InputError("frame: found first sample " + std::to_string(options.firstSample) + ", expected 0 to 2^30");
    if (options.picture && options.spp < 2)
        throw InputError("frame: found 1 sample a pixel beside an error of the picture, expected at least 2: one tells nothing of noise");
    if (options.noise && options.picture) throw InputError("frame: found two goals of adaptive sampling, expected one");
    if ((options.noise || options.picture) && options.firstSample > 0)
        throw InputError("frame: found a first sample of an adaptive frame, expected all of its samples together");
    if (options.shares && (options.firstSample > 0 || options.noise || !mayShare(options, render)))
        throw InputError(
            "frame: found pixels that share their samples beside AOVs, layers, a denoiser, a box filter, a noise level of each "
            "pixel or a first sample, expected R, G, B and A alone");
    if (!whole.contains(windowOf(options, render))) throw InputError("frame: found a window beyond the frame, expected one within");
}

} // namespace taut
