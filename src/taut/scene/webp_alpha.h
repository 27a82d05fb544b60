#pragma once
/// OpenImageIO multiplies the colours of a WebP image by their alpha, in eight bits: what is transparent loses its colour. Textures hold
/// colours as stored, so these are read from a copy that claims to be opaque.

#include <string>
#include <string_view>

namespace taut {

/// `webp` (RIFF container of RFC 9649) with every pixel opaque: without its ALPH chunk and with the alpha bits of VP8X and VP8L cleared.
std::string opaqueWebp(std::string_view webp);

} // namespace taut
