#include "picture.h"

#include "taut/base/half.h"
#include "taut/base/parallel.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>

namespace taut::app {

static_assert(std::endian::native == std::endian::little, "words are written as they lie in memory");

std::string pictureBytes(const Film &film, const PictureLabel &label) {
    const Window &window = film.window();
    const std::vector<float> values = film.resolve();
    const auto channels = static_cast<std::uint32_t>(4 + film.aovChannels());
    const std::array<std::uint32_t, 16> header{0x54554154U, // TAUT
                                               label.number,
                                               label.version,
                                               static_cast<std::uint32_t>(label.frame),
                                               label.follows ? 1U : 0U,
                                               static_cast<std::uint32_t>(window.width()),
                                               static_cast<std::uint32_t>(window.height()),
                                               static_cast<std::uint32_t>(label.width),
                                               static_cast<std::uint32_t>(label.height),
                                               static_cast<std::uint32_t>(label.samples),
                                               static_cast<std::uint32_t>(label.wanted),
                                               label.done ? 1U : 0U,
                                               channels,
                                               std::bit_cast<std::uint32_t>(label.milliseconds),
                                               0,
                                               0};
    std::string bytes(sizeof header + 2 * values.size(), '\0');
    std::memcpy(bytes.data(), header.data(), sizeof header);
    char *out = bytes.data() + sizeof header;
    constexpr std::size_t kBlock = 4096;
    parallelFor((values.size() + kBlock - 1) / kBlock, 16, [&](std::size_t block) {
        for (std::size_t i = block * kBlock; i < std::min(values.size(), (block + 1) * kBlock); ++i) {
            const std::uint16_t half = halfOf(values[i]);
            std::memcpy(out + 2 * i, &half, 2);
        }
    });
    return bytes;
}

} // namespace taut::app
