#include "taut/render/pixel_filter.h"

#include <array>
#include <vector>

namespace taut {

namespace {

/// Harris 1978, minimum four-term window.
constexpr std::array<double, 4> kTerms{0.35875, 0.48829, 0.14128, 0.01168};

/// Inverse of the Blackman-Harris window's integral over [-1, 1], by symmetry of its upper half: the offset as a function of
/// sqrt(1 - |2 u - 1|), which spends steps on the flat tail, tabulated.
class BlackmanHarris {
  public:
    BlackmanHarris() {
        constexpr int kFine = 1 << 14;
        std::vector<double> above(kFine + 1, 0.0); // integral from x = i / kFine to the end, of the half window
        for (int i = kFine - 1; i >= 0; --i)
            above[static_cast<std::size_t>(i)] = above[static_cast<std::size_t>(i) + 1] + window(0.5 + 0.5 * (i + 0.5) / kFine);
        std::size_t at = kFine - 1;
        for (int i = 0; i <= kSteps; ++i) {
            const double target = above[0] * i * i / (static_cast<double>(kSteps) * kSteps);
            while (at > 0 && above[at] < target) --at;
            const double within = (above[at] - target) / (above[at] - above[at + 1]);
            offset_[static_cast<std::size_t>(i)] = static_cast<float>((static_cast<double>(at) + within) / kFine);
        }
    }
    [[nodiscard]] float sample(float u) const {
        const float centred = 2 * u - 1;
        const float x = std::sqrt(1 - std::fabs(centred)) * kSteps;
        const auto i = static_cast<std::size_t>(x);
        return std::copysign(glm::mix(offset_[i], offset_[i + 1], x - static_cast<float>(i)), centred);
    }

  private:
    static constexpr int kSteps = 1024;
    static double window(double x) {
        const double w = kTwoPi * x;
        return kTerms[0] - kTerms[1] * std::cos(w) + kTerms[2] * std::cos(2 * w) - kTerms[3] * std::cos(3 * w);
    }
    std::array<float, kSteps + 2> offset_{};
};
const BlackmanHarris kBlackmanHarris;

constexpr float kFilterRadius = 1.5F;
/// Share of the samples of a pixel at the window's edge that fall beyond it.
constexpr float kBeyond = 0.25F;

/// Along one axis; `first` and `last`: whether the window ends before or after the pixel.
struct Place {
    float offset, density;
};
Place placeOf(float u, bool first, bool last) {
    if (first && u < kBeyond) return {u / kBeyond - 1.5F, kBeyond};
    if (last && u >= 1 - kBeyond) return {(u - 1) / kBeyond + 1.5F, kBeyond};
    const float begin = first ? kBeyond : 0;
    const float within = 1 - begin - (last ? kBeyond : 0);
    return {(u - begin) / within - 0.5F, within};
}

/// The window over its integral, tabulated over its radius.
class FilterTable {
  public:
    FilterTable() {
        for (std::size_t i = 0; i < values_.size(); ++i) {
            const double w = kPi * static_cast<double>(i) / kSteps;
            const double value = kTerms[0] + kTerms[1] * std::cos(w) + kTerms[2] * std::cos(2 * w) + kTerms[3] * std::cos(3 * w);
            values_[i] = i < kSteps ? static_cast<float>(value / (2 * static_cast<double>(kFilterRadius) * kTerms[0])) : 0.0F;
        }
    }
    [[nodiscard]] float at(float offset) const {
        const float x = std::min(std::fabs(offset) * (kSteps / kFilterRadius), static_cast<float>(kSteps));
        const auto i = static_cast<std::size_t>(x);
        return glm::mix(values_[i], values_[i + 1], x - static_cast<float>(i));
    }

  private:
    static constexpr int kSteps = 2048;
    std::array<float, kSteps + 2> values_{};
};
const FilterTable kFilterTable;

std::array<float, 3> weightsOf(const Place &place, bool first, bool last) {
    const float scale = 1 / place.density;
    return {first ? 0.0F : scale * kFilterTable.at(place.offset + 1), scale * kFilterTable.at(place.offset),
            last ? 0.0F : scale * kFilterTable.at(place.offset - 1)};
}

/// Both axes of a pixel.
struct Edges {
    bool left, right, top, bottom;
    Edges(const Window &window, int x, int y)
        : left(x == window.x0), right(x == window.x1 - 1), top(y == window.y0), bottom(y == window.y1 - 1) {}
};

} // namespace

Vec2 sharedOffset(const Window &window, int x, int y, const Vec2 &u) {
    const Edges e(window, x, y);
    return {placeOf(u.x, e.left, e.right).offset, placeOf(u.y, e.top, e.bottom).offset};
}

SharedSample sharedSample(const Window &window, int x, int y, const Vec2 &u) {
    const Edges e(window, x, y);
    const Place across = placeOf(u.x, e.left, e.right);
    const Place down = placeOf(u.y, e.top, e.bottom);
    return {{across.offset, down.offset}, weightsOf(across, e.left, e.right), weightsOf(down, e.top, e.bottom)};
}

Vec2 sampleFilter(bool box, const Vec2 &u) {
    if (box) return u - Vec2(0.5F);
    return Vec2(kBlackmanHarris.sample(u.x), kBlackmanHarris.sample(u.y)) * kFilterRadius;
}

} // namespace taut
