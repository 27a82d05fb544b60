#include "taut/render/matte_id.h"

#include <algorithm>
#include <bit>

namespace taut {

std::uint32_t murmurHash3(std::string_view bytes) {
    const auto byteAt = [&](std::size_t i) { return std::uint32_t{static_cast<unsigned char>(bytes[i])}; };
    const auto mixed = [](std::uint32_t k) { return std::rotl(k * 0xcc9e2d51U, 15) * 0x1b873593U; };
    std::uint32_t h = 0;
    std::size_t i = 0;
    for (; i + 4 <= bytes.size(); i += 4) {
        h ^= mixed(byteAt(i) | byteAt(i + 1) << 8U | byteAt(i + 2) << 16U | byteAt(i + 3) << 24U);
        h = std::rotl(h, 13) * 5 + 0xe6546b64U;
    }
    std::uint32_t tail = 0;
    for (std::size_t k = bytes.size(); k > i; --k) tail = tail << 8U | byteAt(k - 1);
    h ^= mixed(tail);
    h ^= static_cast<std::uint32_t>(bytes.size());
    h = (h ^ h >> 16U) * 0x85ebca6bU;
    h = (h ^ h >> 13U) * 0xc2b2ae35U;
    return h ^ h >> 16U;
}

std::uint32_t matteId(std::string_view name) {
    const std::uint32_t hash = murmurHash3(name);
    const std::uint32_t exponent = std::clamp(hash >> 23U & 0xffU, 1U, 254U);
    return (hash & 0x807fffffU) | exponent << 23U;
}

} // namespace taut
