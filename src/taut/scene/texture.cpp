#include "taut/scene/texture.h"

#include <algorithm>

namespace taut {

namespace {

/// Index of the texel at or below a continuous coordinate, wrapped or clamped.
int resolve(int index, int count, TextureWrap wrap) {
    if (wrap == TextureWrap::Clamp) return std::clamp(index, 0, count - 1);
    const int period = wrap == TextureWrap::Mirror ? 2 * count : count;
    int wrapped = index % period;
    if (wrapped < 0) wrapped += period;
    return wrapped < count ? wrapped : period - 1 - wrapped;
}

/// A texture coordinate brought to where floats are fine; far outside [0, 1] a clamped one stays outside.
float reduce(float x, TextureWrap wrap) {
    if (!std::isfinite(x)) return 0;
    if (wrap == TextureWrap::Clamp) return std::clamp(x, -1.0F, 2.0F);
    return wrap == TextureWrap::Repeat ? x - std::floor(x) : x - 2 * std::floor(0.5F * x);
}

Vec4 texelAt(const Texture &texture, int x, int y) {
    const std::size_t column = static_cast<std::size_t>(resolve(x, texture.width, texture.sampler.wrapU));
    const std::size_t row = static_cast<std::size_t>(resolve(y, texture.height, texture.sampler.wrapV));
    const float *t = &texture.texels[(row * static_cast<std::size_t>(texture.width) + column) * static_cast<std::size_t>(texture.channels)];
    if (texture.channels == 1) return {t[0], t[0], t[0], 1};
    return {t[0], t[1], t[2], texture.channels == 4 ? t[3] : 1.0F};
}

} // namespace

Vec4 lookup(const Texture &texture, const Vec2 &uv) {
    const TextureSampler &sampler = texture.sampler;
    Vec2 at(uv.x, 1 - uv.y);
    if (sampler.moved) at = {glm::dot(sampler.moveU, Vec3(at, 1)), glm::dot(sampler.moveV, Vec3(at, 1))};
    const float placeX = reduce(at.x, sampler.wrapU) * static_cast<float>(texture.width);
    const float placeY = reduce(at.y, sampler.wrapV) * static_cast<float>(texture.height);
    if (sampler.nearest) return texelAt(texture, static_cast<int>(std::floor(placeX)), static_cast<int>(std::floor(placeY)));
    const float x = placeX - 0.5F;
    const float y = placeY - 0.5F;
    const float x0 = std::floor(x);
    const float y0 = std::floor(y);
    const int column = static_cast<int>(x0);
    const int row = static_cast<int>(y0);
    const Vec4 upper = glm::mix(texelAt(texture, column, row), texelAt(texture, column + 1, row), x - x0);
    const Vec4 lower = glm::mix(texelAt(texture, column, row + 1), texelAt(texture, column + 1, row + 1), x - x0);
    return glm::mix(upper, lower, y - y0);
}

} // namespace taut
