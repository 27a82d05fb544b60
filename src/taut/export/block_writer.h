#pragma once
/// Long tables written in blocks: made in parallel, written in order, never held as a whole.

#include "taut/base/file_bytes.h"
#include "taut/base/parallel.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cstdint>
#include <string>

namespace taut {

/// Rows a block: of numbers as bytes, of numbers as text.
inline constexpr std::size_t kBinaryRows = 16384;
inline constexpr std::size_t kTextRows = 2048;
/// Formats that count their bytes in 32 bits hold no more.
inline constexpr std::uint64_t kMostBytes32 = 0xffffffffU;

/// Calls fill(begin, end, text) for blocks of [0, count); each appends its bytes to `text`. `sink` takes them in order.
template <class Fill, class Sink> void writeBlocks(std::size_t count, std::size_t rowsPerBlock, const Fill &fill, const Sink &sink) {
    constexpr std::size_t kBlocksAtOnce = 16;
    std::array<std::string, kBlocksAtOnce> blocks;
    for (std::size_t first = 0; first < count; first += kBlocksAtOnce * rowsPerBlock) {
        const std::size_t inFlight = std::min(kBlocksAtOnce, (count - first + rowsPerBlock - 1) / rowsPerBlock);
        parallelFor(inFlight, 1, [&](std::size_t b) {
            blocks[b].clear();
            const std::size_t begin = first + b * rowsPerBlock;
            fill(begin, std::min(count, begin + rowsPerBlock), blocks[b]);
        });
        for (std::size_t b = 0; b < inFlight; ++b) sink(blocks[b]);
    }
}

/// The shortest decimal that reads back as the same float; "inf" and "nan" where it is one.
inline void appendShortest(std::string &out, float value) {
    char text[24];
    out.append(text, std::to_chars(text, text + sizeof text, value).ptr);
}
inline void appendNumber(std::string &out, std::uint32_t value) {
    char text[12];
    out.append(text, std::to_chars(text, text + sizeof text, value).ptr);
}

/// Little-endian bytes of a binary header.
inline void append16(std::string &out, unsigned value) {
    out += static_cast<char>(value & 0xffU);
    out += static_cast<char>(value >> 8 & 0xffU);
}
inline void append32(std::string &out, std::uint64_t value) {
    append16(out, static_cast<unsigned>(value & 0xffffU));
    append16(out, static_cast<unsigned>(value >> 16 & 0xffffU));
}

} // namespace taut
