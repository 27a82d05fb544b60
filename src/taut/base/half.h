#pragma once
/// Half floats, IEEE 754 binary16.

#include <bit>
#include <cstdint>

namespace taut {

/// The bits of the nearest half float, ties to even; from 65520 on: infinite.
inline std::uint16_t halfOf(float x) {
    const auto bits = std::bit_cast<std::uint32_t>(x);
    const std::uint32_t sign = (bits >> 16U) & 0x8000U;
    const std::uint32_t size = bits & 0x7fffffffU;
    if (size > 0x7f800000U) return static_cast<std::uint16_t>(sign | 0x7e00U);  // not a number
    if (size >= 0x477ff000U) return static_cast<std::uint16_t>(sign | 0x7c00U); // rounds to 65536 or more
    if (size < 0x38800000U) {                                                   // below 2^-14: a multiple of 2^-24
        const float scaled = std::bit_cast<float>(size) * 0x1p24F + 0x1p23F;    // the addition rounds
        return static_cast<std::uint16_t>(sign | (std::bit_cast<std::uint32_t>(scaled) - std::bit_cast<std::uint32_t>(0x1p23F)));
    }
    const std::uint32_t rounded = size + 0xfffU + ((size >> 13U) & 1U);
    return static_cast<std::uint16_t>(sign | ((rounded - 0x38000000U) >> 13U));
}

} // namespace taut
