#pragma once
/// Textures seen from afar: means over footprints, from levels of half the size each (Williams 1983, "Pyramidal Parametrics"), along the
/// footprint's long axis by several of them.
///
/// Of a map of slopes the levels hold s and s s^T, five numbers: the mean slope and its covariance over any footprint follow (Olano & Baker
/// 2010, "LEAN Mapping").

#include "taut/scene/material.h"
#include "taut/scene/texture.h"

namespace taut {

class TexturePyramid {
  public:
    /// Takes level 0: rows from the top, `channels` (at most kMostChannels) floats a texel.
    TexturePyramid(int width, int height, int channels, std::vector<float> texels);

    static constexpr int kMostChannels = 5;
    using Values = std::array<float, kMostChannels>;

    /// The mean over a footprint, its axes in image places (0 to 1 across the image); `sampler` says what stands beyond the edges.
    /// `level` receives that of the lookup: 0 or less where the footprint is no wider than a texel.
    [[nodiscard]] Values mean(const TextureSampler &sampler, const Vec2 &uv, const UvFootprint &footprint) const;
    /// The level that a footprint is looked up at: 0 where it is no wider than a texel of the image.
    [[nodiscard]] float levelOf(const TextureSampler &sampler, const UvFootprint &footprint) const;

    [[nodiscard]] std::size_t levels() const { return levels_.size(); }
    /// Of the values of a level, for those who want all of them.
    [[nodiscard]] const std::vector<float> &texelsOf(std::size_t level) const { return levels_[level].texels; }

  private:
    struct Level {
        int width, height;
        std::vector<float> texels;
    };
    struct Axes {
        Vec2 major, minor; ///< half axes' doubles, in texels of level 0
        int taps;
        float level;
    };
    [[nodiscard]] Axes axesOf(const TextureSampler &sampler, const UvFootprint &footprint) const;
    void add(const Level &level, const TextureSampler &sampler, const Vec2 &uv, float weight, Values &sum) const;

    int channels_;
    std::vector<Level> levels_;
};

/// Of a texture's own channels.
std::shared_ptr<const TexturePyramid> colourPyramid(const Texture &texture);
/// Moments of a map's slopes at scale 1, before a mesh's metric: x, y, xx, xy, yy.
std::shared_ptr<const TexturePyramid> slopePyramid(const Texture &texture, SlopeMap::Kind kind);

/// The slope that a texel of a normal map says, at scale 1.
Vec2 slopeOfNormal(const Vec3 &texel);

/// The mean of the variances of slopes along both axes within footprints of a pyramid's level.
float meanVariance(const TexturePyramid &slopes, float level);

} // namespace taut
