#include "taut/scene/texture.h"

#include "taut/scene/texture_pyramid.h"

#include <algorithm>

namespace taut {

namespace {

/// Index of the texel at or below a continuous coordinate, wrapped or clamped.
int resolve(int index, int count, TextureWrap wrap) {
    if (index >= 0 && index < count) return index;
    if (wrap == TextureWrap::Clamp) return std::clamp(index, 0, count - 1);
    const int period = wrap == TextureWrap::Mirror ? 2 * count : count;
    int wrapped = index % period;
    if (wrapped < 0) wrapped += period;
    return wrapped < count ? wrapped : period - 1 - wrapped;
}

/// The whole number at or below x, which an int holds: std::floor is a call where the baseline's instructions have none.
int floorOf(float x) {
    const int towardsZero = static_cast<int>(x);
    return towardsZero - (static_cast<float>(towardsZero) > x ? 1 : 0);
}

/// A texture coordinate brought to where floats are fine; far outside [0, 1] a clamped one stays outside.
float reduce(float x, TextureWrap wrap) {
    if (!std::isfinite(x)) return 0;
    if (wrap == TextureWrap::Clamp) return std::clamp(x, -1.0F, 2.0F);
    if (wrap == TextureWrap::Repeat && std::fabs(x) < 1e6F) return x - static_cast<float>(floorOf(x));
    return wrap == TextureWrap::Repeat ? x - std::floor(x) : x - 2 * std::floor(0.5F * x);
}

/// A place on the image in units of its width and height, brought into reach.
Vec2 placeOf(const TextureSampler &sampler, const Vec2 &uv, int width, int height) {
    Vec2 at(uv.x, 1 - uv.y);
    if (sampler.moved) at = {glm::dot(sampler.moveU, Vec3(at, 1)), glm::dot(sampler.moveV, Vec3(at, 1))};
    return {reduce(at.x, sampler.wrapU) * static_cast<float>(width), reduce(at.y, sampler.wrapV) * static_cast<float>(height)};
}

/// Of a column and a row that there are.
Vec4 texelAt(const Texture &texture, int column, int row) {
    const auto at = static_cast<std::size_t>(row) * static_cast<std::size_t>(texture.width) + static_cast<std::size_t>(column);
    const float *t = &texture.texels[at * static_cast<std::size_t>(texture.channels)];
    if (texture.channels == 1) return {t[0], t[0], t[0], 1};
    return {t[0], t[1], t[2], texture.channels == 4 ? t[3] : 1.0F};
}

} // namespace

Vec4 lookup(const Texture &texture, const Vec2 &uv) {
    const TextureSampler &sampler = texture.sampler;
    if (sampler.nearest) {
        const Vec2 place = placeOf(sampler, uv, texture.width, texture.height);
        return texelAt(texture, resolve(floorOf(place.x), texture.width, sampler.wrapU),
                       resolve(floorOf(place.y), texture.height, sampler.wrapV));
    }
    const BilinearPlace at = bilinearPlace(sampler, uv, texture.width, texture.height);
    const Vec4 upper = glm::mix(texelAt(texture, at.column[0], at.row[0]), texelAt(texture, at.column[1], at.row[0]), at.u);
    const Vec4 lower = glm::mix(texelAt(texture, at.column[0], at.row[1]), texelAt(texture, at.column[1], at.row[1]), at.u);
    return glm::mix(upper, lower, at.v);
}

Vec4 lookup(const Texture &texture, const Vec2 &uv, const UvFootprint &footprint) {
    if (!texture.pyramid || !footprint.isGiven() || !(texture.pyramid->levelOf(texture.sampler, footprint) > 0)) return lookup(texture, uv);
    const TexturePyramid::Values v = texture.pyramid->mean(texture.sampler, uv, footprint);
    if (texture.channels == 1) return {v[0], v[0], v[0], 1};
    return {v[0], v[1], v[2], texture.channels == 4 ? v[3] : 1.0F};
}

BilinearPlace bilinearPlace(const TextureSampler &sampler, const Vec2 &uv, int width, int height) {
    const Vec2 place = placeOf(sampler, uv, width, height) - Vec2(0.5F);
    const int column = floorOf(place.x);
    const int row = floorOf(place.y);
    return {{resolve(column, width, sampler.wrapU), resolve(column + 1, width, sampler.wrapU)},
            {resolve(row, height, sampler.wrapV), resolve(row + 1, height, sampler.wrapV)},
            place.x - static_cast<float>(column),
            place.y - static_cast<float>(row)};
}

} // namespace taut
