#pragma once
/// Counts and exact sums as few bytes, and back: what films are saved as. Internal to films.

#include "taut/base/error.h"
#include "taut/base/exact_sum.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <istream>
#include <span>
#include <vector>

namespace taut {

inline constexpr const char *kFilmEndsEarly = "film: found its end early, expected as many sums as its head says";

/// 7 bits a byte, the least first.
inline void packNumber(std::uint64_t value, std::vector<unsigned char> &out) {
    for (; value >= 0x80U; value >>= 7U) out.push_back(static_cast<unsigned char>(value | 0x80U));
    out.push_back(static_cast<unsigned char>(value));
}

/// Runs of equal counts: how many, which.
inline void packCounts(std::span<const std::uint32_t> counts, std::vector<unsigned char> &out) {
    for (std::size_t first = 0, next = 0; first < counts.size(); first = next) {
        while (next < counts.size() && counts[next] == counts[first]) ++next;
        packNumber(next - first, out);
        packNumber(counts[first], out);
    }
}

/// A sum of many zero bytes at both ends (those above repeat its sign) by those between: the number of zero bytes at its low end and,
/// less one, of bytes that follow, four bits each. Zero is a byte that no other sum begins with.
inline constexpr unsigned char kZeroSum = 0xff;

inline void packSum(const ExactSum &sum, std::vector<unsigned char> &out) {
    const std::array<std::uint64_t, 2> words{sum.low(), static_cast<std::uint64_t>(sum.high())};
    std::array<unsigned char, 16> bytes{};
    std::memcpy(bytes.data(), words.data(), bytes.size());
    if ((words[0] | words[1]) == 0) return out.push_back(kZeroSum);
    const int low = words[0] != 0 ? std::countr_zero(words[0]) / 8 : 8 + std::countr_zero(words[1]) / 8;
    const unsigned char sign = sum.high() < 0 ? 0xff : 0;
    int high = 15;
    while (high > low && bytes[high] == sign && ((bytes[high - 1] ^ sign) & 0x80) == 0) --high;
    out.push_back(static_cast<unsigned char>(low << 4 | (high - low)));
    out.insert(out.end(), bytes.begin() + low, bytes.begin() + high + 1);
}

/// Takes apart what these have put together; what ends early or is none throws.
class Unpacker {
  public:
    explicit Unpacker(std::istream &in) : buffer_(*in.rdbuf()) {}

    void counts(std::span<std::uint32_t> out) {
        for (std::size_t done = 0; done < out.size();) {
            const std::uint64_t run = number();
            const std::uint64_t value = number();
            if (run == 0 || run > out.size() - done || value > 0xffffffffU) throw InputError("film: found counts that are none");
            std::fill_n(out.begin() + static_cast<std::ptrdiff_t>(done), run, static_cast<std::uint32_t>(value));
            done += run;
        }
    }

    ExactSum sum() {
        const unsigned head = byte();
        if (head == kZeroSum) return {};
        const unsigned low = head >> 4U;
        const unsigned size = (head & 15U) + 1;
        if (low + size > 16) throw InputError("film: found a sum that is none");
        std::array<unsigned char, 16> bytes{};
        for (unsigned i = 0; i < size; ++i) bytes[low + i] = static_cast<unsigned char>(byte());
        if ((bytes[low + size - 1] & 0x80U) != 0) std::fill(bytes.begin() + low + size, bytes.end(), static_cast<unsigned char>(0xff));
        std::array<std::uint64_t, 2> words{};
        std::memcpy(words.data(), bytes.data(), bytes.size());
        return {words[0], static_cast<std::int64_t>(words[1])};
    }

    std::uint64_t number() {
        std::uint64_t value = 0;
        for (unsigned shift = 0; shift < 35; shift += 7) {
            const unsigned c = byte();
            value |= static_cast<std::uint64_t>(c & 0x7fU) << shift;
            if (c < 0x80U) return value;
        }
        throw InputError("film: found counts that are none");
    }

  private:
    unsigned byte() {
        const auto c = buffer_.sbumpc();
        if (c == std::istream::traits_type::eof()) throw InputError(kFilmEndsEarly);
        return static_cast<unsigned char>(c);
    }

    std::streambuf &buffer_;
};

} // namespace taut
