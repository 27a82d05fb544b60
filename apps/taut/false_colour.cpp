#include "false_colour.h"

#include "taut/base/error.h"
#include "taut/base/srgb.h"

#include <algorithm>
#include <array>

namespace taut::app {

namespace {

/// sRGB anchors of a map whose lightness rises evenly from dark blue over green to yellow.
constexpr std::array<std::array<float, 3>, 6> kAnchors{{{0.05F, 0.05F, 0.35F},
                                                        {0.20F, 0.20F, 0.58F},
                                                        {0.13F, 0.45F, 0.60F},
                                                        {0.12F, 0.63F, 0.50F},
                                                        {0.52F, 0.80F, 0.28F},
                                                        {0.98F, 0.92F, 0.20F}}};

Vec3 colourOf(float x) {
    const float at = glm::clamp(x, 0.0F, 1.0F) * static_cast<float>(kAnchors.size() - 1);
    const auto i = std::min(static_cast<std::size_t>(at), kAnchors.size() - 2);
    Vec3 colour;
    for (std::size_t c = 0; c < 3; ++c)
        colour[static_cast<int>(c)] = linearFromSrgb(glm::mix(kAnchors[i][c], kAnchors[i + 1][c], at - static_cast<float>(i)));
    return colour;
}

std::size_t indexOf(const Image &image, const std::string &channel) {
    return static_cast<std::size_t>(std::find(image.channels.begin(), image.channels.end(), channel) - image.channels.begin());
}

} // namespace

Aov aovOfChannel(const std::string &channel) {
    std::vector<std::string_view> names;
    for (const AovInfo &info : aovTable())
        for (const std::string_view name : info.channels) {
            if (name == channel) return *findAov(info.name);
            names.push_back(name);
        }
    failUnknownName({"--false-colour"}, channel, names);
}

Vec2 channelRange(const std::vector<Image> &images, const std::string &channel) {
    Vec2 range(kInfinity, -kInfinity);
    for (const Image &image : images) {
        const std::size_t at = indexOf(image, channel);
        const std::size_t alpha = indexOf(image, "A");
        for (std::size_t i = 0; i < image.values.size(); i += image.channels.size()) {
            if (!(image.values[i + alpha] > 0.5F)) continue; // a pixel at the rim mixes with nothing
            range.x = std::fmin(range.x, image.values[i + at]);
            range.y = std::fmax(range.y, image.values[i + at]);
        }
    }
    return range.x <= range.y ? range : Vec2(0, 1);
}

Image falseColours(const Image &image, const std::string &channel, const Vec2 &range) {
    Image out{image.window, image.width, image.height, {"R", "G", "B", "A"}, {}};
    const std::size_t at = indexOf(image, channel);
    const std::size_t alpha = indexOf(image, "A");
    // A spread that is rounding alone is one colour.
    const float spread = range.y - range.x > 1e-5F * std::fabs(range.y) ? range.y - range.x : 0.0F;
    for (std::size_t i = 0; i < image.values.size(); i += image.channels.size()) {
        const float a = image.values[i + alpha];
        const Vec3 colour = a > 0 ? colourOf(spread > 0 ? (image.values[i + at] - range.x) / spread : 0.5F) : Vec3(0);
        out.values.insert(out.values.end(), {colour.r, colour.g, colour.b, a});
    }
    return out;
}

} // namespace taut::app
