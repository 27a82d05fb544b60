#pragma once
/// Pixel sums. Sums are exact (base/exact_sum.h), so a pixel is the same bits for any order of its samples and any split of samples or
/// pixels over threads, passes, films, processes and machines. Films can be read, saved, restored and merged at any time. Where pixels
/// share their samples (shared_sums.h) the picture depends on their order too, and films are not merged.

#include "taut/base/exact_sum.h"
#include "taut/base/vec.h"
#include "taut/render/aov.h"
#include "taut/render/denoise_sums.h"
#include "taut/render/film_layers.h"
#include "taut/render/shared_sums.h"
#include "taut/render/window.h"

#include <array>
#include <iosfwd>
#include <optional>
#include <string>
#include <vector>

namespace taut {

/// Sums over samples; channels R G B A and those of the AOVs, interleaved. AOVs are averaged over the samples that hit a surface.
/// Pixels may have different numbers of samples. Not for writing by several threads into one pixel.
class Film {
  public:
    /// `denoiseBlock`: keeps what denoise() needs as well, halves dealt in blocks of so many samples (denoise_sums.h); 0: does not.
    /// `shares`: its picture is that of shared samples, which are to be added to sharedSums() beside add(); the sums of pixels are of
    /// their own samples then.
    Film(const Window &window, const std::vector<Aov> &aovs, const FilmLayers &layers = {}, int denoiseBlock = 0, bool shares = false);

    [[nodiscard]] const Window &window() const { return window_; }
    [[nodiscard]] const std::vector<Aov> &aovs() const { return aovs_; }
    [[nodiscard]] const FilmLayers &layers() const { return layers_.asked(); }
    [[nodiscard]] int aovChannels() const { return static_cast<int>(stride_) - 4; }
    /// R G B A, AOVs, layers.
    [[nodiscard]] std::vector<std::string> channelNames() const;

    /// Adds one sample of pixel (x, y); `aovs` has aovChannels() values, or is null where the sample hit nothing.
    void add(int x, int y, const Vec3 &radiance, float alpha, const float *aovs);
    /// Of the same sample, where layers are asked for.
    void addLayers(int x, int y, const Vec3 &radiance, const LayerSample &sample) { layers_.add(pixelAt(x, y), radiance, sample); }
    /// What is kept for denoising, to be added to beside add(); null where nothing is.
    [[nodiscard]] DenoiseSums *denoiseSums() { return denoise_ ? &*denoise_ : nullptr; }
    [[nodiscard]] const DenoiseSums *denoiseSums() const { return denoise_ ? &*denoise_ : nullptr; }
    [[nodiscard]] int denoiseBlock() const { return denoise_ ? denoise_->block() : 0; }
    /// Null where pixels do not share.
    [[nodiscard]] SharedSums *sharedSums() { return shared_ ? &*shared_ : nullptr; }
    [[nodiscard]] const SharedSums *sharedSums() const { return shared_ ? &*shared_ : nullptr; }
    /// R, G, B, A of all pixels of the picture, row by row: means; 0 where there is no sample.
    [[nodiscard]] std::vector<std::array<float, 4>> colours() const;
    /// Adds the samples of another film; the window grows to hold both. Whose samples those are is the caller's to know: a sample that
    /// is in both counts twice. Throws InputError where the AOVs or layers are others, one keeps what denoising needs and the other
    /// does not, or pixels share.
    void merge(const Film &other);
    /// Takes over the pixels of a part, which both films have.
    void copy(const Film &from, const Window &part);

    [[nodiscard]] std::uint32_t samplesAt(int x, int y) const { return counts_[pixelAt(x, y)]; }
    /// Samples of the pixel that has most of them.
    [[nodiscard]] int samples() const;
    /// Samples a pixel, on average.
    [[nodiscard]] double meanSamples() const;
    /// Sum over the samples of a pixel of 0.2126 R + 0.7152 G + 0.0722 B.
    [[nodiscard]] double luminanceSum(int x, int y) const;
    /// Sum of a colour over the samples of a pixel.
    [[nodiscard]] const ExactSum &sumAt(int x, int y, std::size_t channel) const { return sums_[pixelAt(x, y) * stride_ + channel]; }
    /// Means, interleaved, in channelNames() order; 0 where there is no sample.
    [[nodiscard]] std::vector<float> resolve() const;

    /// Writes all sums and counts, little-endian, so that load() gives the same film back.
    void save(std::ostream &out) const;
    /// Reads what save() wrote. Throws InputError where it is damaged or ends early, and takes no more memory than there are bytes.
    static Film load(std::istream &in);

    bool operator==(const Film &) const = default;

  private:
    Window window_;
    std::vector<Aov> aovs_;
    std::size_t stride_ = 4;            ///< R G B A, AOVs
    std::vector<std::uint32_t> counts_; // [pixels] samples
    std::vector<std::uint32_t> hits_;   // [pixels] of them that hit a surface
    std::vector<ExactSum> sums_;        // [pixels x stride]
    LayerSums layers_;
    std::optional<DenoiseSums> denoise_;
    std::optional<SharedSums> shared_;

    [[nodiscard]] std::size_t pixelAt(int x, int y) const {
        return static_cast<std::size_t>(y - window_.y0) * static_cast<std::size_t>(window_.width()) +
               static_cast<std::size_t>(x - window_.x0);
    }
};

} // namespace taut
