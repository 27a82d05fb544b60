#include "taut/scene/jpeg_guard.h"

namespace taut {

namespace {

constexpr unsigned char kStartOfScan = 0xda;
constexpr unsigned char kEndOfImage = 0xd9;

/// Markers without a length: TEM, restarts, the start and the end of an image.
bool standsAlone(unsigned char marker) {
    return marker == 0x01 || (marker >= 0xd0 && marker <= kEndOfImage);
}

/// A byte behind 0xff that belongs to the compressed data: a stuffed zero, or a restart.
bool isWithinScan(unsigned char code) {
    return code == 0 || (code >= 0xd0 && code <= 0xd7);
}

} // namespace

std::string damageOfJpeg(std::string_view bytes) {
    const auto byteAt = [&](std::size_t at) { return static_cast<unsigned char>(bytes[at]); };
    std::size_t at = 2; // behind the start of the image
    while (true) {
        // To the next marker; of several 0xff in a row all but the last are fill bytes.
        while (at < bytes.size() && byteAt(at) != 0xff) ++at;
        while (at < bytes.size() && byteAt(at) == 0xff) ++at;
        if (at >= bytes.size()) return "the file ends before the end of the JPEG image";
        const unsigned char marker = byteAt(at++);
        if (marker == kEndOfImage) return {};
        if (marker == 0 || standsAlone(marker)) continue;
        if (bytes.size() - at < 2) return "the file ends within a JPEG marker";
        const std::size_t length = static_cast<std::size_t>(byteAt(at)) << 8U | byteAt(at + 1);
        if (length < 2 || length > bytes.size() - at) return "the file ends within the JPEG segment at byte " + std::to_string(at - 2);
        at += length;
        if (marker != kStartOfScan) continue;
        while (at + 1 < bytes.size() && !(byteAt(at) == 0xff && byteAt(at + 1) != 0xff && !isWithinScan(byteAt(at + 1)))) ++at;
    }
}

} // namespace taut
