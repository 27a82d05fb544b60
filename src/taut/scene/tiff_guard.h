#pragma once
/// TIFF files that end early: OpenImageIO leaves black what is missing and says nothing. Found here first, by the places and lengths of
/// strips and tiles (TIFF 6.0, sections 2 and 15).

#include <string>
#include <string_view>

namespace taut {

/// What lies outside the file of its first image; empty: nothing.
std::string damageOfTiff(std::string_view bytes);

} // namespace taut
