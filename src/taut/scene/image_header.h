#pragma once
/// How large an image says it is, found in its first bytes before a decoder allocates by them.

#include <cstdint>
#include <string_view>

namespace taut {

/// All zero where a header can't be made out: then its decoder says what is wrong. Sizes are as the file has them, up to 32 bits each.
struct AnnouncedSize {
    std::int64_t width = 0, height = 0, channels = 0;
    double decoder = 0; ///< bytes that its decoder takes beside the picture: what it holds whole, tiles, tables
};

AnnouncedSize sizeOfPng(std::string_view bytes);
AnnouncedSize sizeOfJpeg(std::string_view bytes);
AnnouncedSize sizeOfHdr(std::string_view bytes);
AnnouncedSize sizeOfTiff(std::string_view bytes);
AnnouncedSize sizeOfWebp(std::string_view bytes);
AnnouncedSize sizeOfBmp(std::string_view bytes);
AnnouncedSize sizeOfTga(std::string_view bytes);

} // namespace taut
