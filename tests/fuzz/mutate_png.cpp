#include "mutate.h"

#include <array>

namespace taut::fuzz {

namespace {

constexpr std::size_t kSignature = 8;

std::uint32_t bigEndian(std::string_view bytes, std::size_t at) {
    std::uint32_t word = 0;
    for (std::size_t i = 0; i < 4; ++i) word = word << 8U | static_cast<unsigned char>(bytes[at + i]);
    return word;
}
void appendBigEndian(std::string &out, std::size_t word) {
    for (int shift = 24; shift >= 0; shift -= 8) out += static_cast<char>(word >> shift & 0xffU);
}

/// Of a chunk's type and data: PNG specification, annex D.
std::uint32_t crc(std::string_view bytes) {
    std::uint32_t c = 0xffffffffU;
    for (const char byte : bytes) {
        c ^= static_cast<unsigned char>(byte);
        for (int bit = 0; bit < 8; ++bit) c = (c & 1U) != 0 ? 0xedb88320U ^ c >> 1U : c >> 1U;
    }
    return ~c;
}

} // namespace

std::string mutatedPng(std::string_view bytes, Dice &dice, const ChangeBytes &change) {
    std::vector<std::string> chunks; // types and data
    for (std::size_t at = kSignature; at + 12 <= bytes.size();) {
        const std::size_t length = bigEndian(bytes, at);
        if (length > bytes.size() - at - 12) break;
        chunks.emplace_back(bytes.substr(at + 4, 4 + length));
        at += 12 + length;
    }
    if (chunks.empty()) return {};
    static constexpr std::array<std::string_view, 8> kTypes{"tRNS", "PLTE", "gAMA", "bKGD", "tEXt", "sRGB", "IDAT", "IEND"};
    std::string &chunk = chunks[dice.below(chunks.size())];
    switch (dice.below(4)) {
    case 0: chunks.insert(chunks.begin() + static_cast<std::ptrdiff_t>(dice.below(chunks.size())), std::string(kTypes[dice.below(kTypes.size())]) + change(chunk.substr(4))); break;
    case 1: std::swap(chunk, chunks[dice.below(chunks.size())]); break;
    default: chunk = chunk.substr(0, 4) + change(chunk.substr(4));
    }
    std::string out(bytes.substr(0, kSignature));
    for (const std::string &one : chunks) {
        appendBigEndian(out, one.size() - 4);
        out += one;
        appendBigEndian(out, crc(one));
    }
    return out;
}

} // namespace taut::fuzz
