#include "picture.h"

#include "taut/base/half.h"
#include "taut/base/parallel.h"
#include "taut/base/vec.h"
#include "taut/images/view_transform.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>

namespace taut::app {

static_assert(std::endian::native == std::endian::little, "words are written as they lie in memory");

namespace {

constexpr std::size_t kColour = 4;             // R G B A
constexpr std::string_view kMattes = "Crypto"; // what channels of mattes begin with

/// One for each id: hues far apart, none dark.
Vec3 colourOf(std::uint32_t id) {
    const float hue = static_cast<float>((id * 2654435761U) >> 8U) * 0x1p-24F;
    const auto wave = [&](float shift) { return 0.45F + 0.4F * std::cos(static_cast<float>(kTwoPi) * (hue - shift)); };
    return {wave(0), wave(1 / 3.0F), wave(2 / 3.0F)};
}

/// Channels 4 on are pairs of an id and its share: three colours instead.
std::vector<float> withMattesAsColours(const Image &image) {
    const std::size_t stride = image.channels.size();
    const std::size_t pixels = image.values.size() / stride;
    std::vector<float> values;
    values.reserve(pixels * (kColour + 3));
    for (std::size_t i = 0; i < pixels; ++i) {
        const float *pixel = image.values.data() + i * stride;
        Vec3 colour(0);
        for (std::size_t c = kColour; c + 1 < stride; c += 2)
            if (pixel[c + 1] > 0) colour += pixel[c + 1] * colourOf(std::bit_cast<std::uint32_t>(pixel[c]));
        values.insert(values.end(), pixel, pixel + kColour);
        values.insert(values.end(), {colour.x, colour.y, colour.z});
    }
    return values;
}

std::string halvesOf(const std::vector<float> &values, std::string bytes) {
    const std::size_t begin = bytes.size();
    bytes.resize(begin + 2 * values.size());
    char *out = bytes.data() + begin;
    constexpr std::size_t kBlock = 4096;
    parallelFor((values.size() + kBlock - 1) / kBlock, 16, [&](std::size_t block) {
        for (std::size_t i = block * kBlock; i < std::min(values.size(), (block + 1) * kBlock); ++i) {
            const std::uint16_t half = halfOf(values[i]);
            std::memcpy(out + 2 * i, &half, 2);
        }
    });
    return bytes;
}

} // namespace

std::string pictureBytes(const Image &image, const PictureLabel &label) {
    const Window &window = image.window;
    const bool mattes = image.channels.size() > kColour && image.channels[kColour].starts_with(kMattes);
    const auto channels = static_cast<std::uint32_t>(mattes ? kColour + 3 : image.channels.size());
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
    std::string bytes(sizeof header, '\0');
    std::memcpy(bytes.data(), header.data(), sizeof header);
    return halvesOf(mattes ? withMattesAsColours(image) : image.values, std::move(bytes));
}

std::string viewTable(const ViewSettings &settings) {
    ViewSettings plain = settings;
    plain.exposure = 0;
    const ViewTransform transform(plain);
    constexpr auto kSteps = static_cast<std::size_t>(kViewSteps);
    std::array<float, kSteps> steps{};
    for (std::size_t i = 0; i < kSteps; ++i)
        steps[i] = static_cast<float>(std::exp2(19.0 * static_cast<double>(i) / (kViewSteps - 1) - 10) - 0x1p-10);
    std::vector<float> rgb;
    rgb.reserve(3 * kSteps * kSteps * kSteps);
    for (const float b : steps)
        for (const float g : steps)
            for (const float r : steps) rgb.insert(rgb.end(), {r, g, b});
    transform.apply(rgb.data(), rgb.size() / 3);
    std::vector<float> values;
    values.reserve(rgb.size() / 3 * 4);
    for (std::size_t i = 0; i < rgb.size(); i += 3) values.insert(values.end(), {rgb[i], rgb[i + 1], rgb[i + 2], 1.0F});
    return halvesOf(values, "");
}

} // namespace taut::app
