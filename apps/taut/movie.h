#pragma once
/// A movie of the frames, through ffmpeg.

#include <string>
#include <vector>

namespace taut::app {

/// .mp4, .webm or .gif, in any case.
bool isMoviePath(const std::string &path);

/// Throws InputError where there is no ffmpeg to make it.
void checkMovie(const std::string &path);

/// Where the pictures lie until the movie is made: picture `number`, from 0, in a folder beside it.
std::string pictureOfMovie(const std::string &path, std::size_t number);

/// Makes the movie of so many pictures, at `fps` a second, beside its name first, and removes them. Throws RunError with ffmpeg's reason;
/// then they stay.
void writeMovie(const std::string &path, double fps);

} // namespace taut::app
