#pragma once
/// Frame sets ("1-10", "1-5,9", "1-100x5") and numbered paths ("out/####.exr", "mesh.%04d.obj").

#include "taut/base/error.h"

#include <string>
#include <string_view>
#include <vector>

namespace taut {

/// Frames of a FileSeq expression, in the order written, each once. Throws InputError naming `where`.
std::vector<int> parseFrameSet(std::string_view text, const Location &where);

/// True where the path has a run of '#' or a printf %d / %0Nd.
bool hasFramePattern(std::string_view path);

/// The path of one frame: the last run of '#' (or the last %0Nd) becomes the zero-padded frame number.
std::string pathOfFrame(std::string_view pattern, int frame);

} // namespace taut
