#pragma once
/// The image of a frame that is denoised, and how a saved frame says that it is to be.

#include "taut/render/denoise_frames.h"
#include "taut/render/saved_frame.h"

#include <optional>

namespace taut::app {

/// Puts the denoised colours in the place of R, G and B of the film's image, and adds Noisy.R, Noisy.G and Noisy.B, which were there, and
/// DenoiseError, the standard error that is estimated to be left in a colour.
void addDenoised(const Film &film, FrameDenoiser &denoiser, Image &image);

/// Says in the metadata of a frame that its picture is to be denoised, by itself or over frames.
void markDenoised(Metadata &metadata, bool overFrames);
/// What denoises the pictures of frames with that head; none where they are not to be.
std::optional<FrameDenoiser> denoiserOf(const SavedHead &head);

} // namespace taut::app
