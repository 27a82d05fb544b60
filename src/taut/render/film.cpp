#include "taut/render/film.h"

#include "taut/base/vec.h"

#include <algorithm>
#include <array>

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

const std::vector<AovInfo> &aovInfos() {
    static const std::vector<AovInfo> infos{
        {Aov::Depth, "depth", {"Z"}},
        {Aov::Albedo, "albedo", {"Albedo.R", "Albedo.G", "Albedo.B"}},
        {Aov::Normal, "normal", {"N.X", "N.Y", "N.Z"}},
        {Aov::ShadingNormal, "shading_normal", {"Ns.X", "Ns.Y", "Ns.Z"}},
        {Aov::Position, "position", {"P.X", "P.Y", "P.Z"}},
        {Aov::RestPosition, "rest_position", {"Pref.X", "Pref.Y", "Pref.Z"}},
        {Aov::Uv, "uv", {"u", "v"}},
        {Aov::M, "m", {"M.a", "M.b", "M.d"}},
        {Aov::Stretch, "stretch", {"Stretch.max", "Stretch.min"}},
        {Aov::Alpha, "alpha", {"AlphaMax", "AlphaMin", "AlphaPhi"}},
    };
    return infos;
}

Film::Film(const Window &window, const std::vector<Aov> &aovs) : window_(window), aovs_(aovs) {
    for (const Aov aov : aovs_) aovChannels_ += static_cast<int>(aovInfos()[static_cast<std::size_t>(aov)].channels.size());
    stride_ = 5 + aovChannels_;
    counts_.assign(static_cast<std::size_t>(window.width()) * static_cast<std::size_t>(window.height()), 0);
    sums_.assign(counts_.size() * static_cast<std::size_t>(stride_), 0.0);
}

std::vector<std::string> Film::channelNames() const {
    std::vector<std::string> names{"R", "G", "B", "A"};
    for (const Aov aov : aovs_) {
        const auto &channels = aovInfos()[static_cast<std::size_t>(aov)].channels;
        names.insert(names.end(), channels.begin(), channels.end());
    }
    return names;
}

void Film::add(int x, int y, const Vec3 &radiance, float alpha, const float *aovs) {
    const std::size_t pixel = pixelAt(x, y);
    ++counts_[pixel];
    double *sum = &sums_[pixel * static_cast<std::size_t>(stride_)];
    for (int c = 0; c < 3; ++c) sum[c] += static_cast<double>(radiance[c]);
    sum[3] += static_cast<double>(alpha);
    if (aovs == nullptr) return;
    sum[4] += 1;
    for (int c = 0; c < aovChannels_; ++c) sum[5 + c] += static_cast<double>(aovs[c]);
}

int Film::samples() const {
    return counts_.empty() ? 0 : static_cast<int>(*std::max_element(counts_.begin(), counts_.end()));
}

double Film::meanSamples() const {
    double sum = 0;
    for (const std::uint32_t count : counts_) sum += count;
    return counts_.empty() ? 0 : sum / static_cast<double>(counts_.size());
}

double Film::luminanceSum(int x, int y) const {
    const double *sum = &sums_[pixelAt(x, y) * static_cast<std::size_t>(stride_)];
    return 0.2126 * sum[0] + 0.7152 * sum[1] + 0.0722 * sum[2];
}

std::vector<float> Film::resolve() const {
    const std::size_t pixels = counts_.size();
    const int channels = 4 + aovChannels_;
    std::vector<float> values;
    values.reserve(pixels * static_cast<std::size_t>(channels));
    for (std::size_t p = 0; p < pixels; ++p) {
        const double inverse = counts_[p] > 0 ? 1.0 / counts_[p] : 0.0;
        const double *sum = &sums_[p * static_cast<std::size_t>(stride_)];
        for (int c = 0; c < 4; ++c) values.push_back(static_cast<float>(sum[c] * inverse));
        for (int c = 0; c < aovChannels_; ++c) values.push_back(sum[4] > 0 ? static_cast<float>(sum[5 + c] / sum[4]) : 0.0F);
    }
    return values;
}

Vec2 sampleFilter(bool box, const Vec2 &u) {
    if (box) return u - Vec2(0.5F);
    return Vec2(kBlackmanHarris.sample(u.x), kBlackmanHarris.sample(u.y)) * kFilterRadius;
}

} // namespace taut
