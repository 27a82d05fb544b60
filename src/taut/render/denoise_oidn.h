#pragma once
/// Intel's Open Image Denoise in the place of the filters of denoise_regression.h, where CMake found it: then TAUT_OPEN_IMAGE_DENOISE is
/// defined and denoise_oidn.cpp compiled.

#include "taut/render/denoise_regression.h"

namespace taut {

/// Both halves of the samples, each denoised with albedo and normal; so errors are estimated as those of the other filters are. Throws
/// RunError where the library fails.
Regressed openImageDenoise(const DenoisePixels &pixels);

} // namespace taut
