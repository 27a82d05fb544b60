#pragma once
/// The image files of a frame, as `taut render` and `taut merge` write them.

#include "taut/render/denoise_frames.h"
#include "taut/render/saved_frame.h"

#include <string>
#include <vector>

namespace taut::app {

/// Throws InputError where a name is no image's, or several frames would go into one image.
void checkOutputs(const std::vector<std::string> &outputs, std::size_t frames);

/// The paths of a frame's images, of patterns.
std::vector<std::string> pathsOf(const std::vector<std::string> &outputs, int frame);

/// Whether all of these files are there.
bool areThere(const std::vector<std::string> &paths);

/// Throws RunError where a file beside `path` can't be written: before the work, not after it.
void checkWritable(const std::string &path);

/// What images say of the frame that they are of: version, seed, number, names of mattes.
Metadata frameMetadata(const Scene &scene, double frame, const FilmLayers &layers);
/// And of its samples.
Metadata sampleMetadata(const Film &film);

/// Writes each of these files as the head's settings say, with its metadata and what follows from the film. `denoiser`: of films that keep
/// sums for denoising (denoised_image.h); null: the film is written as it is.
void writeImages(const SavedHead &head, const Film &film, const std::vector<std::string> &paths, FrameDenoiser *denoiser = nullptr);

} // namespace taut::app
