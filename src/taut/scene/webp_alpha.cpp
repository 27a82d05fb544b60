#include "taut/scene/webp_alpha.h"

#include <cstdint>

namespace taut {

namespace {

constexpr std::size_t kRiffHeader = 12;
constexpr std::size_t kChunkHeader = 8;
constexpr char kVp8xAlpha = 0x10; ///< RFC 9649, section 2.7.1, first byte
constexpr char kVp8lAlpha = 0x10; ///< bit 28 of the size and alpha after the signature (RFC 9649, section 3.4), fifth byte

std::uint32_t littleEndian(std::string_view bytes) {
    std::uint32_t word = 0;
    for (std::size_t i = 4; i-- > 0;) word = word << 8U | static_cast<unsigned char>(bytes[i]);
    return word;
}

} // namespace

std::string opaqueWebp(std::string_view webp) {
    std::string out(webp.substr(0, kRiffHeader));
    for (std::size_t at = kRiffHeader; at + kChunkHeader <= webp.size();) {
        const std::string_view type = webp.substr(at, 4);
        const std::size_t length = littleEndian(webp.substr(at + 4, 4));
        const std::string_view chunk = webp.substr(at, kChunkHeader + length + length % 2); // chunks are padded to even lengths
        at += kChunkHeader + length + length % 2;
        if (type == "ALPH") continue;
        const std::size_t data = out.size() + kChunkHeader;
        out += chunk;
        if (type == "VP8X" && length >= 1 && out.size() > data) out[data] = static_cast<char>(out[data] & ~kVp8xAlpha);
        if (type == "VP8L" && length >= 5 && out.size() > data + 4) out[data + 4] = static_cast<char>(out[data + 4] & ~kVp8lAlpha);
    }
    const auto size = static_cast<std::uint32_t>(out.size() - 8);
    for (std::size_t i = 0; i < 4 && out.size() >= 8; ++i) out[4 + i] = static_cast<char>(size >> 8U * i & 0xffU);
    return out;
}

} // namespace taut
