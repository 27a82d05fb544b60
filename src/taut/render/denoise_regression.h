#pragma once
/// First-order regression of noisy colours on features, window by window: every pixel is the mean of what the windows around it predict.
///
/// Bitterli, Rousselle, Moon, Iglesias-Guitian, Adler, Mitchell, Jarosz, Novak: Nonlinearly Weighted First-order Regression for Denoising
/// Monte Carlo Renderings (EGSR 2016). Differences: windows stand on a grid, and where none around a pixel resembles it, it gets its own;
/// weights come from features and from a guide picture instead of patches; and gloss has a say in them.
///
/// Gloss: under a distant light the slope of the half vector, seen from the surface, moves by the difference of n - wo / 2. M says in
/// which direction how much of that the lobe bears: over t1 t1^T / alphaMax^2 + t2 t2^T / alphaMin^2 the square of a difference is in units
/// of the lobe. A window is long along a highlight and short across it.

#include "taut/render/denoise_pixels.h"

namespace taut {

/// A window and what it takes for alike: differences at which a pixel counts 1 / e as much. 0: any.
struct RegressionScale {
    int radius = 7;                                                                 ///< pixels
    int stride = 4;                                                                 ///< between windows
    bool curved = false;                                                            ///< squares of the place are regressed on too
    bool lonely = true;                                                             ///< pixels that no window resembles get their own
    float normal = 0.5F, albedo = 0.2F, alpha = 0.3F, depth = 0.1F, stretch = 0.3F; ///< depth, stretch: of logarithms
    float gloss = 1;                                                                ///< in units of the lobe
    float guide = 0;                                                                ///< in units of the guide's noise
};

/// A picture that has less noise; variance of each of its pixels, the mean of three colours.
struct Guide {
    ColourPlanes colour;
    Plane variance;
};

struct Regressed {
    ColourPlanes half[2]; ///< predictions from either half of the samples
    Plane known;          ///< 1, or 0 where no window resembles the pixel
};

/// `guide`: null where there is none.
Regressed regress(const DenoisePixels &pixels, const RegressionScale &scale, const Guide *guide);

} // namespace taut
