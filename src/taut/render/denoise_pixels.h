#pragma once
/// The sums of a film as the denoiser reads them: means of both halves, variances of means, features; a plane of floats each.

#include "taut/render/film.h"

#include <array>

namespace taut {

/// [pixels] row by row; those that loops read by many at once have kPlaneSlack values more.
using Plane = std::vector<float>;
inline constexpr int kPlaneSlack = 16;
using ColourPlanes = std::array<Plane, 3>;

struct DenoisePixels {
    int width = 0, height = 0;
    [[nodiscard]] std::size_t count() const { return static_cast<std::size_t>(width) * static_cast<std::size_t>(height); }
    [[nodiscard]] std::size_t stored() const { return count() + kPlaneSlack; } ///< values of a plane
    bool halves = true;                                                        ///< every pixel has samples in both halves
    ColourPlanes mean;    ///< of all samples; at outlines with the coverage that probes know
    ColourPlanes half[2]; ///< of the first and of the second half of them; 0 where there is none
    Plane samples;        ///< how many
    Plane share[2];       ///< of the samples that are in that half
    Plane variance;       ///< of `mean`, that of three colours; of a half it is this over its share
    Plane alpha;          ///< share of the probes that met a surface or a light
    Plane cover;          ///< share of the probes that saw something; 1 where nobody says otherwise
    Plane edge;           ///< 1 where surfaces end in the pixel or beside it, else 0
    Plane trust;          ///< 1; 0 for a pixel that one bright sample made: it is not believed
    // Means over the probes (denoise_probes.cpp); what hit nothing counts as 0.
    std::array<Plane, 3> normal, albedo;
    Plane featureNoise[2]; ///< variance of the means of normal and of albedo, the mean of three channels
    // Means over the hits.
    Plane depth;
    std::array<Plane, 3> halfway;
    std::array<Plane, 2> stretch;
    std::array<Plane, 6> gloss;
    std::array<Plane, 2> motion; ///< pixels to the frame before
    Plane moving;                ///< share of the probes whose motion is known
};

/// Means around pixels, of those where surfaces end and of the others by themselves: at an outline everything errs in ways of its own.
class Around {
  public:
    Around(const DenoisePixels &pixels, int radius);
    void average(Plane &values) const;

  private:
    const DenoisePixels &p_;
    int radius_;
    Plane edges_; ///< share of the pixels around
};

/// The rectangle of a film's window that holds the pixels which are not known exactly, and some around them; empty: all are known.
Window noisyPart(const Film &film);
/// Of the pixels of a part of the film's window. Throws InputError where the film keeps no sums for denoising.
DenoisePixels denoisePixelsOf(const Film &film, const Window &part);

/// Mean over the pixels of the square window of this radius that lie in the picture.
void boxMean(Plane &plane, int width, int height, int radius);

} // namespace taut
