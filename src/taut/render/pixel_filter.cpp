#include "taut/render/pixel_filter.h"

#include <array>
#include <vector>

namespace taut {

namespace {

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
    static double window(double x) { // Harris 1978, minimum four-term window
        const double w = kTwoPi * x;
        return 0.35875 - 0.48829 * std::cos(w) + 0.14128 * std::cos(2 * w) - 0.01168 * std::cos(3 * w);
    }
    std::array<float, kSteps + 2> offset_{};
};
const BlackmanHarris kBlackmanHarris;

constexpr float kFilterRadius = 1.5F;

} // namespace

Vec2 sampleFilter(bool box, const Vec2 &u) {
    if (box) return u - Vec2(0.5F);
    return Vec2(kBlackmanHarris.sample(u.x), kBlackmanHarris.sample(u.y)) * kFilterRadius;
}

} // namespace taut
