#pragma once
/// Pixel sums. Each pixel's samples are added in sample order, in double, by the one thread that has its tile: the same bits for
/// any number of threads, tile order or split into passes.

#include "taut/base/vec.h"

#include <string>
#include <string_view>
#include <vector>

namespace taut {

/// Arbitrary output variables beside the colour, by their names on the command line.
enum class Aov : std::uint8_t { Depth, Albedo, Normal, ShadingNormal, Position, RestPosition, Uv, M, Stretch, Alpha };

struct AovInfo {
    Aov aov;
    std::string_view name;             ///< on the command line
    std::vector<std::string> channels; ///< in the EXR
};
const std::vector<AovInfo> &aovInfos();

/// The pixels [x0, x1) x [y0, y1) of a frame of width x height; rows from the top.
struct Window {
    int x0 = 0, y0 = 0, x1 = 0, y1 = 0;
    [[nodiscard]] int width() const { return x1 - x0; }
    [[nodiscard]] int height() const { return y1 - y0; }
};

/// Sums over samples; channels R G B A and those of the AOVs, interleaved. AOVs are averaged over the samples that hit a surface.
/// Pixels may have different numbers of samples.
class Film {
  public:
    Film(const Window &window, const std::vector<Aov> &aovs);

    [[nodiscard]] const Window &window() const { return window_; }
    [[nodiscard]] const std::vector<Aov> &aovs() const { return aovs_; }
    [[nodiscard]] int aovChannels() const { return aovChannels_; }
    [[nodiscard]] std::vector<std::string> channelNames() const;

    /// Adds one sample of pixel (x, y); `aovs` has aovChannels() values, or is null where the sample hit nothing.
    void add(int x, int y, const Vec3 &radiance, float alpha, const float *aovs);

    /// Samples of the pixel that has most of them.
    [[nodiscard]] int samples() const;
    /// Samples a pixel, on average.
    [[nodiscard]] double meanSamples() const;
    /// Sum over the samples of a pixel of 0.2126 R + 0.7152 G + 0.0722 B.
    [[nodiscard]] double luminanceSum(int x, int y) const;
    /// Means, interleaved, in channelNames() order.
    [[nodiscard]] std::vector<float> resolve() const;

  private:
    Window window_;
    std::vector<Aov> aovs_;
    int aovChannels_ = 0;
    int stride_ = 0;                    ///< 5 + aovChannels_: R G B A, hits, AOVs
    std::vector<std::uint32_t> counts_; // [pixels] samples
    std::vector<double> sums_;

    [[nodiscard]] std::size_t pixelAt(int x, int y) const {
        return static_cast<std::size_t>(y - window_.y0) * static_cast<std::size_t>(window_.width()) +
               static_cast<std::size_t>(x - window_.x0);
    }
};

/// Offset of a sample from its pixel's centre, importance sampled from the reconstruction filter (Ernst, Stamminger & Greiner
/// 2006): box of one pixel, or Blackman-Harris of radius 1.5 pixels.
Vec2 sampleFilter(bool box, const Vec2 &u);

} // namespace taut
