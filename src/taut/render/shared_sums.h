#pragma once
/// What the samples of each pixel give to it and to the eight around it, where pixels share their samples (pixel_filter.h). Sums are
/// floats, added in the order of a pixel's samples, which is the same for any number of threads; films that share are not merged.

#include "taut/base/vec.h"
#include "taut/render/pixel_filter.h"
#include "taut/render/window.h"

#include <array>
#include <iosfwd>
#include <span>
#include <vector>

namespace taut {

class SharedSums {
  public:
    static constexpr std::size_t kValues = 5;  ///< R, G, B, A and 1, each times the sample's weight
    static constexpr std::size_t kShares = 12; ///< three rows from the pixel up to the left; the fourth of each is 0, for vectors' sake
    using Shares = std::array<std::array<float, kShares>, kValues>;

    SharedSums() = default;
    explicit SharedSums(const Window &window);

    void add(int x, int y, const SharedSample &sample, const Vec3 &radiance, float alpha);
    [[nodiscard]] const Shares &at(int x, int y) const { return pixels_[pixelAt(x, y)]; }
    /// R, G, B, A of all pixels, row by row: means of all that is given to each, by the weights that there are. `counts`: their samples.
    [[nodiscard]] std::vector<std::array<float, 4>> resolve(std::span<const std::uint32_t> counts) const;
    /// Takes over the pixels of a part, which both have.
    void copy(const SharedSums &from, const Window &part);

    /// Little-endian; load() gives them back for a film of that window. Throws InputError where they are damaged or end early.
    void save(std::ostream &out) const;
    static SharedSums load(std::istream &in, const Window &window);

    bool operator==(const SharedSums &) const = default;

  private:
    Window window_;
    std::vector<Shares> pixels_;

    [[nodiscard]] std::size_t pixelAt(int x, int y) const {
        return static_cast<std::size_t>(y - window_.y0) * static_cast<std::size_t>(window_.width()) +
               static_cast<std::size_t>(x - window_.x0);
    }
};

} // namespace taut
