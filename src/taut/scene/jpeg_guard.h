#pragma once
/// JPEG files that end early. The decoder fills what is missing with grey and tells nobody but its standard error, so it is found here
/// first: by the markers (ITU-T T.81, Annex B), the last of which says that the image is whole.

#include <string>
#include <string_view>

namespace taut {

/// What is missing before the end of the image; empty: nothing. What follows the end has no say.
std::string damageOfJpeg(std::string_view bytes);

} // namespace taut
