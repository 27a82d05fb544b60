#include "taut/scene/slope_texture.h"

#include "taut/microsurface/mesostructure.h"

#include <algorithm>

namespace taut {

namespace {

/// The texel that stands at an index beyond the image's edge.
int across(int index, int count, TextureWrap wrap) {
    if (wrap == TextureWrap::Repeat) return (index + count) % count;
    return std::clamp(index, 0, count - 1); // of a mirror image the texel at the edge comes again
}

} // namespace

Texture slopesFromHeights(const Texture &heights, int channel, SlopeMap::Kind kind) {
    const int width = heights.width;
    const int height = heights.height;
    const auto channels = static_cast<std::size_t>(heights.channels);
    // As lookup() has it: missing channels repeat the first, alpha is 1.
    const bool isConstant = channel == 3 && channels < 4;
    const std::size_t offset = channels == 1 ? 0 : static_cast<std::size_t>(channel);
    const auto at = [&](int x, int y) {
        const std::size_t texel = static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x);
        return isConstant ? 1.0F : heights.texels[texel * channels + offset];
    };
    const float perColumn = 0.5F * static_cast<float>(width);
    const float perRow = 0.5F * static_cast<float>(kind == SlopeMap::Kind::Bump ? width : height);
    std::vector<float> slopes;
    slopes.reserve(static_cast<std::size_t>(width) * static_cast<std::size_t>(height) * 3);
    const TextureSampler &sampler = heights.sampler;
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            const float left = at(across(x - 1, width, sampler.wrapU), y);
            const float right = at(across(x + 1, width, sampler.wrapU), y);
            const float above = at(x, across(y - 1, height, sampler.wrapV));
            const float below = at(x, across(y + 1, height, sampler.wrapV));
            slopes.insert(slopes.end(), {(left - right) * perColumn, (below - above) * perRow, 0});
        }
    Texture out = heights;
    out.channels = 3;
    out.texels = std::move(slopes);
    return out;
}

std::size_t countTooSteep(const Texture &normals) {
    if (normals.channels < 3) return 0;
    const auto channels = static_cast<std::size_t>(normals.channels);
    std::size_t count = 0;
    for (std::size_t i = 0; i < normals.texels.size(); i += channels) {
        const Vec3 n = 2.0F * Vec3(normals.texels[i], normals.texels[i + 1], normals.texels[i + 2]) - Vec3(1);
        count += n.z * kSteepestSlope < glm::length(Vec2(n)) ? 1 : 0;
    }
    return count;
}

} // namespace taut
