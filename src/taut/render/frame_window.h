#pragma once
/// The pixels of a frame that are rendered, and whether they can be.

#include "taut/render/frame_render.h"

namespace taut {

/// The tiles of the frame's own grid, as far as they lie in the window.
std::vector<Window> tilesOf(const Window &window);

/// What is asked for, or the whole frame.
Window windowOf(const FrameOptions &options, const RenderSettings &render);

/// The window, if the scene's budget has the memory for its film and the image made of it: of R, G, B and A, for what else is wanted is
/// asked for by hand. Throws InputError where it has not.
Window affordable(const Scene &scene, const Window &window, bool shares);

/// Throws InputError where options contradict each other.
void checkOptions(const FrameOptions &options, const RenderSettings &render);

} // namespace taut
