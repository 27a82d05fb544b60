#pragma once
/// Takes the noise out of a picture: several joint filters of colour and features, and of each pixel their mean by the inverse squares of
/// their errors, which are estimated from two halves of the samples; the unfiltered picture is among them.
///
/// Rousselle, Manzi, Zwicker: Robust Denoising using Feature and Color Information (Pacific Graphics 2013): several filters and
/// error estimates. The filters are those of denoise_regression.h. The same bits for any number of threads, and for a film that
/// was merged or restored.

#include "taut/render/film.h"

namespace taut {

struct Denoised {
    std::vector<float> rgb;   ///< [pixels x 3] linear, row by row over the film's window
    std::vector<float> error; ///< [pixels] standard error that is estimated to be left in a colour
};

/// Of a film that keeps sums for denoising (FrameOptions::denoiseBlock). Throws InputError of another.
Denoised denoise(const Film &film);

/// The block of a film's halves (denoise_sums.h) for so many samples a pixel; `known`: there will be exactly so many.
int denoiseBlockOf(int samples, bool known);

} // namespace taut
