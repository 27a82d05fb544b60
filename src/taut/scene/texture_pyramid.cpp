#include "taut/scene/texture_pyramid.h"

#include "taut/microsurface/mesostructure.h"

#include <algorithm>

namespace taut {

namespace {

/// Lookups along a footprint's long axis, at most.
constexpr int kMostTaps = 8;

/// Halves one dimension by means weighted by area: sizes need not be even. `stride` between neighbours, `lines` of them.
std::vector<float> halved(const std::vector<float> &texels, int width, int height, int channels, bool alongX) {
    const int count = alongX ? width : height;
    const int half = std::max(1, count / 2);
    const int outWidth = alongX ? half : width;
    const int outHeight = alongX ? height : half;
    std::vector<float> out(static_cast<std::size_t>(outWidth) * static_cast<std::size_t>(outHeight) * static_cast<std::size_t>(channels));
    const double step = static_cast<double>(count) / half;
    const auto at = [&](int x, int y) {
        return (static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x)) *
               static_cast<std::size_t>(channels);
    };
    std::size_t o = 0;
    for (int y = 0; y < outHeight; ++y)
        for (int x = 0; x < outWidth; ++x, o += static_cast<std::size_t>(channels)) {
            const double begin = (alongX ? x : y) * step;
            const double end = begin + step;
            for (int i = static_cast<int>(begin); i < count && i < end; ++i) {
                const auto share = static_cast<float>((std::min(end, i + 1.0) - std::max(begin, static_cast<double>(i))) / step);
                const std::size_t from = alongX ? at(i, y) : at(x, i);
                for (std::size_t c = 0; c < static_cast<std::size_t>(channels); ++c) out[o + c] += share * texels[from + c];
            }
        }
    return out;
}

} // namespace

TexturePyramid::TexturePyramid(int width, int height, int channels, std::vector<float> texels) : channels_(channels) {
    levels_.push_back({width, height, std::move(texels)});
    while (width > 1 || height > 1) {
        std::vector<float> next = levels_.back().texels;
        if (width > 1) {
            next = halved(next, width, height, channels, true);
            width = std::max(1, width / 2);
        }
        if (height > 1) {
            next = halved(next, width, height, channels, false);
            height = std::max(1, height / 2);
        }
        levels_.push_back({width, height, std::move(next)});
    }
}

TexturePyramid::Axes TexturePyramid::axesOf(const TextureSampler &sampler, const UvFootprint &footprint) const {
    const Vec2 size(static_cast<float>(levels_[0].width), static_cast<float>(levels_[0].height));
    const auto texels = [&](const Vec2 &axis) {
        const Vec2 down(axis.x, -axis.y);
        const Vec2 moved = sampler.moved ? Vec2(glm::dot(Vec2(sampler.moveU), down), glm::dot(Vec2(sampler.moveV), down)) : down;
        return moved * size;
    };
    Axes axes{footprint.major, footprint.minor, 1, 0};
    float longer = glm::length(texels(axes.major));
    float shorter = glm::length(texels(axes.minor));
    if (longer < shorter) {
        std::swap(axes.major, axes.minor);
        std::swap(longer, shorter);
    }
    const float width = std::max(shorter, longer / kMostTaps);
    if (!(width > 0) || !(longer < kInfinity)) return axes;
    axes.taps = std::clamp(static_cast<int>(std::ceil(longer / std::max(width, 1.0F))), 1, kMostTaps);
    axes.level = glm::clamp(std::log2(width), 0.0F, static_cast<float>(levels_.size() - 1));
    return axes;
}

float TexturePyramid::levelOf(const TextureSampler &sampler, const UvFootprint &footprint) const {
    const Axes axes = axesOf(sampler, footprint);
    return axes.taps > 1 ? std::fmax(axes.level, 1e-3F) : axes.level;
}

void TexturePyramid::add(const Level &level, const TextureSampler &sampler, const Vec2 &uv, float weight, Values &sum) const {
    const BilinearPlace p = bilinearPlace(sampler, uv, level.width, level.height);
    for (int j = 0; j < 2; ++j)
        for (int i = 0; i < 2; ++i) {
            const float share = weight * (i == 1 ? p.u : 1 - p.u) * (j == 1 ? p.v : 1 - p.v);
            const float *texel = &level.texels[(static_cast<std::size_t>(p.row[j]) * static_cast<std::size_t>(level.width) +
                                                static_cast<std::size_t>(p.column[i])) *
                                               static_cast<std::size_t>(channels_)];
            for (int c = 0; c < channels_; ++c) sum[static_cast<std::size_t>(c)] += share * texel[c];
        }
}

TexturePyramid::Values TexturePyramid::mean(const TextureSampler &sampler, const Vec2 &uv, const UvFootprint &footprint) const {
    const Axes axes = axesOf(sampler, footprint);
    const auto lower = static_cast<std::size_t>(axes.level);
    const std::size_t upper = std::min(lower + 1, levels_.size() - 1);
    const float between = axes.level - static_cast<float>(lower);
    Values sum{};
    for (int i = 0; i < axes.taps; ++i) {
        const Vec2 at = uv + axes.major * ((static_cast<float>(i) + 0.5F) / static_cast<float>(axes.taps) - 0.5F);
        const float weight = 1 / static_cast<float>(axes.taps);
        add(levels_[lower], sampler, at, weight * (1 - between), sum);
        if (between > 0) add(levels_[upper], sampler, at, weight * between, sum);
    }
    return sum;
}

std::shared_ptr<const TexturePyramid> colourPyramid(const Texture &texture) {
    return std::make_shared<TexturePyramid>(texture.width, texture.height, texture.channels,
                                            std::vector<float>(texture.texels.begin(), texture.texels.end()));
}

std::shared_ptr<const TexturePyramid> slopePyramid(const Texture &texture, SlopeMap::Kind kind) {
    const auto channels = static_cast<std::size_t>(texture.channels);
    std::vector<float> moments;
    moments.reserve(texture.texels.size() / channels * 5);
    for (std::size_t i = 0; i < texture.texels.size(); i += channels) {
        const float *t = &texture.texels[i];
        const Vec3 texel = channels == 1 ? Vec3(t[0]) : Vec3(t[0], t[1], t[2]);
        const Vec2 s = kind == SlopeMap::Kind::Normal ? slopeOfNormal(texel) : Vec2(texel);
        moments.insert(moments.end(), {s.x, s.y, s.x * s.x, s.x * s.y, s.y * s.y});
    }
    return std::make_shared<TexturePyramid>(texture.width, texture.height, 5, std::move(moments));
}

Vec2 slopeOfNormal(const Vec3 &texel) {
    const Vec3 n = 2.0F * texel - Vec3(1);
    const Vec2 side(n.x, n.y);
    const float least = glm::length(side) / kSteepestSlope;
    return side / std::fmax(std::fmax(n.z, least), 1e-6F);
}

float meanVariance(const TexturePyramid &slopes, float level) {
    const std::size_t nearest = std::min(static_cast<std::size_t>(std::lround(std::fmax(level, 0.0F))), slopes.levels() - 1);
    const std::vector<float> &texels = slopes.texelsOf(nearest);
    double sum = 0;
    for (std::size_t i = 0; i < texels.size(); i += 5)
        sum += std::max(0.0, 0.5 * (static_cast<double>(texels[i + 2]) - sqr(static_cast<double>(texels[i])) +
                                    static_cast<double>(texels[i + 4]) - sqr(static_cast<double>(texels[i + 1]))));
    return static_cast<float>(sum / (static_cast<double>(texels.size()) / 5));
}

} // namespace taut
