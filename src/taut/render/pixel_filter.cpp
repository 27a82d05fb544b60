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

std::array<float, 3> weightsOf(const Place &place, bool first, bool last) {
    constexpr float kStep = static_cast<float>(kTwoPi) / (2 * kFilterRadius); // of the window's argument over a pixel
    const float angle = kStep * place.offset;
    const float c = std::cos(angle);
    const float s = std::sin(angle) * std::sqrt(3.0F) / 2;
    const std::array<float, 3> cosines{-0.5F * c - s, c, -0.5F * c + s}; // of the distances from the three centres
    const float scale = 1 / (2 * kFilterRadius * static_cast<float>(kTerms[0]) * place.density);
    std::array<float, 3> weights{};
    for (int k = 0; k < 3; ++k) {
        const bool isThere = !(k == 0 && first) && !(k == 2 && last);
        if (!isThere || std::fabs(place.offset - static_cast<float>(k - 1)) > kFilterRadius) continue;
        const float x = cosines[static_cast<std::size_t>(k)];
        const auto term = [](std::size_t i) { return static_cast<float>(kTerms[i]); };
        weights[static_cast<std::size_t>(k)] = scale * (term(0) + term(1) * x + term(2) * (2 * x * x - 1) + term(3) * x * (4 * x * x - 3));
    }
    return weights;
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
