#pragma once
/// Damage that libpng reports on standard error before OpenImageIO can tell us of it: found here first, by the lengths and sums that
/// PNG's chunks carry (PNG specification, 5.3 and Annex D), and said once, by us.

#include <string>
#include <string_view>

namespace taut {

/// What is wrong with the chunks up to the last of the image's data; empty: nothing.
std::string damageOfPng(std::string_view bytes);

} // namespace taut
