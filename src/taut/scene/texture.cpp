#include "taut/scene/texture.h"

#include "taut/scene/texture_pyramid.h"

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

/// A place on the image in units of its width and height, brought into reach.
Vec2 placeOf(const TextureSampler &sampler, const Vec2 &uv, int width, int height) {
    Vec2 at(uv.x, 1 - uv.y);
    if (sampler.moved) at = {glm::dot(sampler.moveU, Vec3(at, 1)), glm::dot(sampler.moveV, Vec3(at, 1))};
    return {reduce(at.x, sampler.wrapU) * static_cast<float>(width), reduce(at.y, sampler.wrapV) * static_cast<float>(height)};
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
    const Vec2 place = placeOf(sampler, uv, texture.width, texture.height);
    if (sampler.nearest) return texelAt(texture, static_cast<int>(std::floor(place.x)), static_cast<int>(std::floor(place.y)));
    const float x = place.x - 0.5F;
    const float y = place.y - 0.5F;
    const float x0 = std::floor(x);
    const float y0 = std::floor(y);
    const int column = static_cast<int>(x0);
    const int row = static_cast<int>(y0);
    const Vec4 upper = glm::mix(texelAt(texture, column, row), texelAt(texture, column + 1, row), x - x0);
    const Vec4 lower = glm::mix(texelAt(texture, column, row + 1), texelAt(texture, column + 1, row + 1), x - x0);
    return glm::mix(upper, lower, y - y0);
}

Vec4 lookup(const Texture &texture, const Vec2 &uv, const UvFootprint &footprint) {
    if (!texture.pyramid || !footprint.isGiven() || !(texture.pyramid->levelOf(texture.sampler, footprint) > 0)) return lookup(texture, uv);
    const TexturePyramid::Values v = texture.pyramid->mean(texture.sampler, uv, footprint);
    if (texture.channels == 1) return {v[0], v[0], v[0], 1};
    return {v[0], v[1], v[2], texture.channels == 4 ? v[3] : 1.0F};
}

BilinearPlace bilinearPlace(const TextureSampler &sampler, const Vec2 &uv, int width, int height) {
    const Vec2 place = placeOf(sampler, uv, width, height) - Vec2(0.5F);
    const Vec2 first = glm::floor(place);
    const int column = static_cast<int>(first.x);
    const int row = static_cast<int>(first.y);
    return {{resolve(column, width, sampler.wrapU), resolve(column + 1, width, sampler.wrapU)},
            {resolve(row, height, sampler.wrapV), resolve(row + 1, height, sampler.wrapV)},
            place.x - first.x,
            place.y - first.y};
}

} // namespace taut
