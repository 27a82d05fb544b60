#pragma once
/// Frame sets ("1-10", "1-5,9", "1-100x5") and numbered paths ("out/####.exr", "mesh.%04d.obj"). The number stands in the file's own
/// name: folders may be called C# or 100%0done.

#include "taut/base/error.h"

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace taut {

/// Frames of a FileSeq expression, in the order written, each once; at most a million in all ranges together. Throws InputError naming
/// `where`.
std::vector<int> parseFrameSet(std::string_view text, const Location &where);

/// True where the file's own name has a run of '#' or a printf %0Nd, N from 1 to 16.
bool hasFramePattern(std::string_view path);

/// The path of one frame: the last run of '#' (else the last %0Nd) of the file's own name becomes the zero-padded frame number.
std::string pathOfFrame(std::string_view pattern, int frame);

/// The frame whose path that is; none where it is no frame's.
std::optional<int> frameOfPath(std::string_view pattern, std::string_view path);

} // namespace taut
