#include "taut/scene/png_guard.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cstdint>

namespace taut {

namespace {

constexpr std::string_view kSignature = "\x89PNG\r\n\x1a\n";

constexpr std::array<std::uint32_t, 256> crcTable() {
    std::array<std::uint32_t, 256> table{};
    for (std::uint32_t n = 0; n < 256; ++n) {
        std::uint32_t c = n;
        for (int bit = 0; bit < 8; ++bit) c = (c & 1U) != 0 ? c >> 1U ^ 0xedb88320U : c >> 1U;
        table[n] = c;
    }
    return table;
}

std::uint32_t crc32(std::string_view bytes) {
    static constexpr std::array<std::uint32_t, 256> kTable = crcTable();
    std::uint32_t crc = 0xffffffffU;
    for (const char c : bytes) crc = crc >> 8U ^ kTable[(crc ^ static_cast<unsigned char>(c)) & 0xffU];
    return ~crc;
}

std::uint32_t bigEndian(std::string_view bytes) {
    std::uint32_t word = 0;
    for (int i = 0; i < 4; ++i) word = word << 8U | static_cast<unsigned char>(bytes[static_cast<std::size_t>(i)]);
    return word;
}

bool isChunkType(std::string_view type) {
    return std::all_of(type.begin(), type.end(), [](unsigned char c) { return c < 0x80 && std::isalpha(c) != 0; });
}

} // namespace

std::string damageOfPng(std::string_view bytes) {
    bool inData = false;
    if (bytes.substr(0, kSignature.size()) != kSignature) return "a PNG signature that is damaged";
    for (std::size_t at = kSignature.size();;) {
        const std::string place = "PNG chunk at byte " + std::to_string(at);
        if (bytes.size() < at + 8) return inData ? "" : place + ": the file ends there";
        const std::uint32_t length = bigEndian(bytes.substr(at));
        const std::string_view type = bytes.substr(at + 4, 4);
        if (inData && type != "IDAT") return {};
        if (!isChunkType(type)) return place + ": no chunk type";
        inData = type == "IDAT";
        if (bytes.size() - at - 8 < std::size_t{length} + 4) return place + ": the file ends within " + std::string(type);
        const bool isCritical = (static_cast<unsigned char>(type[0]) & 0x20U) == 0; // what is not is left out by libpng
        if (isCritical && crc32(bytes.substr(at + 4, std::size_t{length} + 4)) != bigEndian(bytes.substr(at + 8 + length)))
            return place + ": " + std::string(type) + " is damaged (CRC)";
        at += std::size_t{length} + 12;
    }
}

} // namespace taut
