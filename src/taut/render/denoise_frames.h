#pragma once
/// Denoising over frames: what the frame before shows of the same point of the same surface, taken where it agrees with this one.
///
/// The motion is exact: a point of a face was where that face was (FrameBefore). Light does not move with surfaces, so the older colour is
/// held against the denoised newer one, and counts by the inverse of the error that shows: a highlight that has moved on leaves nothing.

#include "taut/render/denoise.h"
#include "taut/render/denoise_pixels.h"

#include <memory>

namespace taut {

class FrameDenoiser {
  public:
    /// Not over frames: each is denoised by itself.
    explicit FrameDenoiser(bool overFrames);
    FrameDenoiser(FrameDenoiser &&) noexcept;
    FrameDenoiser &operator=(FrameDenoiser &&) noexcept;
    ~FrameDenoiser();

    [[nodiscard]] bool overFrames() const { return overFrames_; }
    /// The next frame's picture. Throws as denoise().
    Denoised next(const Film &film);

  private:
    struct Before;
    bool overFrames_;
    std::unique_ptr<Before> before_;
};

} // namespace taut
