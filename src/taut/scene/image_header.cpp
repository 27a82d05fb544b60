#include "taut/scene/image_header.h"

#include <algorithm>
#include <charconv>
#include <cstdlib>

namespace taut {

namespace {

/// An unsigned number of `size` bytes; zeros behind the end.
std::int64_t numberAt(std::string_view bytes, std::size_t at, std::size_t size, bool bigEndian) {
    std::int64_t value = 0;
    for (std::size_t i = 0; i < size; ++i) {
        const std::size_t place = at + (bigEndian ? i : size - 1 - i);
        value = value << 8 | (place < bytes.size() ? static_cast<unsigned char>(bytes[place]) : 0);
    }
    return value;
}

double area(const AnnouncedSize &size) {
    return static_cast<double>(size.width) * static_cast<double>(size.height);
}

} // namespace

/// PNG specification, 11.2.2: IHDR comes first.
AnnouncedSize sizeOfPng(std::string_view bytes) {
    AnnouncedSize size{numberAt(bytes, 16, 4, true), numberAt(bytes, 20, 4, true), 4, 0};
    const std::int64_t depth = numberAt(bytes, 24, 1, true);
    const bool interlaced = numberAt(bytes, 28, 1, true) != 0;
    const std::int64_t type = numberAt(bytes, 25, 1, true); // grey, colour, palette, with alpha 4 more
    size.channels = type == 0 ? 1 : type == 4 ? 2 : type == 2 || type == 3 ? 3 : 4;
    if (interlaced) size.decoder = area(size) * static_cast<double>(size.channels) * (depth > 8 ? 2 : 1);
    return size;
}

/// ITU-T T.81, B.2.2: the first frame header. Progressive ones have all coefficients in memory, 16 bits each.
AnnouncedSize sizeOfJpeg(std::string_view bytes) {
    for (std::size_t at = 2; at + 9 < bytes.size();) {
        if (static_cast<unsigned char>(bytes[at]) != 0xff) {
            ++at;
            continue;
        }
        const auto marker = static_cast<unsigned char>(bytes[at + 1]);
        if (marker == 0xff || marker == 0 || marker == 0x01 || (marker >= 0xd0 && marker <= 0xd9)) {
            at += marker == 0xff ? 1 : 2;
            continue;
        }
        const bool isFrame = marker >= 0xc0 && marker <= 0xcf && marker != 0xc4 && marker != 0xc8 && marker != 0xcc;
        if (isFrame) {
            AnnouncedSize size{numberAt(bytes, at + 7, 2, true), numberAt(bytes, at + 5, 2, true), numberAt(bytes, at + 9, 1, true), 0};
            if (marker != 0xc0 && marker != 0xc1) size.decoder = 2 * area(size) * static_cast<double>(size.channels);
            return size;
        }
        at += 2 + static_cast<std::size_t>(numberAt(bytes, at + 2, 2, true));
    }
    return {};
}

/// The first line that gives a resolution: "-Y 512 +X 1024", in any of eight orders.
AnnouncedSize sizeOfHdr(std::string_view bytes) {
    const std::size_t blank = bytes.find("\n\n");
    if (blank == std::string_view::npos) return {};
    std::string_view line = bytes.substr(blank + 2);
    line = line.substr(0, line.find('\n'));
    AnnouncedSize size{0, 0, 3, 0};
    for (int k = 0; k < 2; ++k) {
        const std::size_t letter = line.find_first_of("XY");
        if (letter == std::string_view::npos) return {};
        const bool isX = line[letter] == 'X';
        line.remove_prefix(letter + 1);
        line.remove_prefix(std::min(line.find_first_not_of(" \t"), line.size()));
        std::int64_t value = 0;
        const auto [end, error] = std::from_chars(line.data(), line.data() + line.size(), value);
        if (error != std::errc()) return {};
        line.remove_prefix(static_cast<std::size_t>(end - line.data()));
        (isX ? size.width : size.height) = value;
    }
    return size;
}

/// TIFF 6.0, section 2: the first directory.
AnnouncedSize sizeOfTiff(std::string_view bytes) {
    const bool bigEndian = !bytes.empty() && bytes[0] == 'M';
    const auto directory = static_cast<std::size_t>(numberAt(bytes, 4, 4, bigEndian));
    if (directory >= bytes.size()) return {};
    const std::int64_t entries = numberAt(bytes, directory, 2, bigEndian);
    AnnouncedSize size{0, 0, 1, 0};
    std::int64_t tileWidth = 0;
    std::int64_t tileHeight = 0;
    std::int64_t stripRows = 0;
    std::int64_t bits = 8;
    for (std::int64_t i = 0; i < entries; ++i) {
        const std::size_t entry = directory + 2 + 12 * static_cast<std::size_t>(i);
        if (entry + 12 > bytes.size()) break;
        const bool isShort = numberAt(bytes, entry + 2, 2, bigEndian) == 3;
        const std::int64_t value = numberAt(bytes, entry + 8, isShort ? 2 : 4, bigEndian);
        switch (numberAt(bytes, entry, 2, bigEndian)) {
        case 256: size.width = value; break;
        case 257: size.height = value; break;
        case 258: bits = numberAt(bytes, entry + 4, 4, bigEndian) == 1 ? value : 64; break; // else one for each channel
        case 277: size.channels = value; break;
        case 278: stripRows = std::min<std::int64_t>(value, 0x7fffffff); break;
        case 322: tileWidth = value; break;
        case 323: tileHeight = value; break;
        default: break;
        }
    }
    const double texel = static_cast<double>(size.channels) * static_cast<double>(bits) / 8;
    const double strip = static_cast<double>(size.width) * static_cast<double>(std::min(stripRows, size.height)) * texel;
    const double tile = static_cast<double>(tileWidth) * static_cast<double>(tileHeight) * texel;
    size.decoder = 3 * std::max(strip, tile) + (tileWidth > 0 ? tile / static_cast<double>(tileWidth) * static_cast<double>(size.width) : 0);
    return size;
}

/// RFC 9649: the canvas of VP8X, the frame of VP8 or VP8L. The whole picture is decoded to 8 bits when it is opened.
AnnouncedSize sizeOfWebp(std::string_view bytes) {
    if (bytes.size() < 30) return {};
    const std::string_view chunk = bytes.substr(12, 4);
    AnnouncedSize size{0, 0, 4, 0};
    if (chunk == "VP8X") {
        size.width = numberAt(bytes, 24, 3, false) + 1;
        size.height = numberAt(bytes, 27, 3, false) + 1;
    } else if (chunk == "VP8 ") {
        size.width = numberAt(bytes, 26, 2, false) & 0x3fff;
        size.height = numberAt(bytes, 28, 2, false) & 0x3fff;
    } else if (chunk == "VP8L") {
        const std::int64_t word = numberAt(bytes, 21, 4, false);
        size.width = (word & 0x3fff) + 1;
        size.height = (word >> 14 & 0x3fff) + 1;
    }
    size.decoder = 8 * area(size);
    return size;
}

AnnouncedSize sizeOfBmp(std::string_view bytes) {
    const bool isCore = numberAt(bytes, 14, 4, false) == 12; // its sides have 16 bits
    const auto side = [&](std::size_t at) { return std::abs(static_cast<std::int64_t>(static_cast<std::int32_t>(numberAt(bytes, at, 4, false)))); };
    AnnouncedSize size{isCore ? numberAt(bytes, 18, 2, false) : side(18), isCore ? numberAt(bytes, 20, 2, false) : side(22), 4, 0};
    size.decoder = 4 * area(size);
    return size;
}

AnnouncedSize sizeOfTga(std::string_view bytes) {
    AnnouncedSize size{numberAt(bytes, 12, 2, false), numberAt(bytes, 14, 2, false), numberAt(bytes, 16, 1, false) <= 8 ? 1 : 4, 0};
    size.decoder = 4 * area(size);
    return size;
}

} // namespace taut
