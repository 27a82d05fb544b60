#pragma once
/// What a film keeps beside its picture where it is to be denoised: the sums of one half of the samples, their squares, features. Sums are
/// exact, as the film's own, so that any order and any split of the samples gives the same bits; features do not depend on the samples.

#include "taut/base/exact_sum.h"
#include "taut/base/vec.h"
#include "taut/render/denoise_features.h"
#include "taut/render/window.h"

#include <array>
#include <iosfwd>
#include <vector>

namespace taut {

class DenoiseSums {
  public:
    /// Samples are dealt to the halves in blocks of so many, at least 1: blocks of half a frame's samples are as well spread as its points
    /// are. Neighbouring pixels begin with different halves.
    DenoiseSums(const Window &window, int block);

    [[nodiscard]] int block() const { return block_; }
    [[nodiscard]] bool inSecondHalf(int x, int y, std::uint32_t sample) const {
        return ((sample / static_cast<std::uint32_t>(block_) + static_cast<std::uint32_t>(x) + static_cast<std::uint32_t>(y)) & 1U) != 0;
    }

    /// One sample. `covered`: it saw something.
    void add(int x, int y, std::uint32_t sample, const Vec3 &radiance, bool covered);
    /// What a pixel sees; the same whoever tells it.
    void tell(int x, int y, const PixelFeatures &features) { features_[pixelAt(x, y)] = features; }
    /// Adds another's sums, whose window lies in this one's. Throws InputError where its blocks are others.
    void merge(const DenoiseSums &other);
    /// Takes over the pixels of a part, which both have.
    void copy(const DenoiseSums &from, const Window &part);

    /// A pixel's sums; the first half is what the film has beyond the second.
    struct Pixel {
        std::array<ExactSum, 3> half{}; ///< R G B over the second half
        ExactSum squares;               ///< R^2 + G^2 + B^2 over all samples
        std::uint32_t second = 0;       ///< samples in the second half
        std::uint32_t covered = 0;      ///< of them that saw something
        bool operator==(const Pixel &) const = default;
    };
    [[nodiscard]] const Pixel &at(int x, int y) const { return pixels_[pixelAt(x, y)]; }

    /// Without probes where nobody has told them.
    [[nodiscard]] const PixelFeatures &featuresAt(int x, int y) const { return features_[pixelAt(x, y)]; }

    /// Writes all sums, little-endian; load() gives them back for a film of that window. Throws InputError where they are damaged or end
    /// early.
    void save(std::ostream &out) const;
    static DenoiseSums load(std::istream &in, const Window &window);

    bool operator==(const DenoiseSums &) const = default;

  private:
    Window window_;
    int block_;
    std::vector<Pixel> pixels_;
    std::vector<PixelFeatures> features_; // [pixels]

    [[nodiscard]] std::size_t pixelAt(int x, int y) const {
        return static_cast<std::size_t>(y - window_.y0) * static_cast<std::size_t>(window_.width()) +
               static_cast<std::size_t>(x - window_.x0);
    }
};

} // namespace taut
