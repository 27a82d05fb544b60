/// What the sums of a film say of a block of pixels.

#include "taut/render/picture_noise.h"

namespace taut {

namespace {

constexpr std::size_t kShared = SharedSums::kShares * SharedSums::kValues;

/// Sums per pixel of R, G, B.
double ofColours(std::span<const double> a, double na, std::span<const double> b, double nb) {
    double sum = 0;
    for (std::size_t i = 0; i < a.size(); ++i) sum += sqr(a[i] / na - b[i] / nb);
    return sum / 3;
}

/// Of what a pixel shares. The picture is a mean by the weights that there are: too much weight brings a pixel only what its light is off
/// the mean around, for which the mean of the pixel that gives is taken.
double ofShares(std::span<const double> a, double na, std::span<const double> b, double nb) {
    double sum = 0;
    for (std::size_t channel = 0; channel < 3; ++channel) {
        double light = 0;
        double weight = 0;
        for (std::size_t at = 0; at < kShared; at += SharedSums::kValues) {
            light += a[at + channel] + b[at + channel];
            weight += a[at + 4] + b[at + 4];
        }
        const double mean = weight > 0 ? light / weight : 0;
        for (std::size_t at = 0; at < kShared; at += SharedSums::kValues)
            sum += sqr((a[at + channel] - mean * a[at + 4]) / na - (b[at + channel] - mean * b[at + 4]) / nb);
    }
    return sum / 3;
}

/// Mean over a part's pixels of what `value` makes of their place in the window's sums.
template <class Value> double meanOver(const Window &part, const Window &window, std::size_t perPixel, const Value &value) {
    double sum = 0;
    for (int y = part.y0; y < part.y1; ++y)
        for (int x = part.x0; x < part.x1; ++x)
            sum += value(static_cast<std::size_t>((y - window.y0) * window.width() + x - window.x0) * perPixel);
    return sum / (static_cast<double>(part.width()) * part.height());
}

std::size_t valuesAPixel(const Window &window, std::span<const double> sums) {
    return sums.size() / (static_cast<std::size_t>(window.width()) * static_cast<std::size_t>(window.height()));
}

} // namespace

void ColourSums::fill(const Film &film, const Window &window, std::vector<double> &sums) {
    sums.clear();
    for (int y = window.y0; y < window.y1; ++y)
        for (int x = window.x0; x < window.x1; ++x) {
            if (const SharedSums *shared = film.sharedSums())
                for (const auto &share : shared->at(x, y)) sums.insert(sums.end(), share.begin(), share.end());
            else
                for (std::size_t channel = 0; channel < 3; ++channel) sums.push_back(film.sumAt(x, y, channel).value());
        }
}

double squaredDifference(const Window &part, const Window &window, std::span<const double> first, int firstSamples,
                         std::span<const double> second, int secondSamples) {
    const std::size_t perPixel = valuesAPixel(window, first);
    return meanOver(part, window, perPixel, [&](std::size_t at) {
        const auto of = perPixel == kShared ? ofShares : ofColours;
        return of(first.subspan(at, perPixel), firstSamples, second.subspan(at, perPixel), secondSamples);
    });
}

BlockError blockErrorOf(const Window &block, const Window &window, const ColourSums &sums, int middle, int last) {
    std::vector<double> added;
    added.reserve(sums.all.size());
    for (std::size_t i = 0; i < sums.all.size(); ++i) added.push_back(sums.all[i] - sums.half[i]);
    const double difference = squaredDifference(block, window, sums.half, middle, added, last - middle);
    const std::size_t perPixel = valuesAPixel(window, sums.all);
    const double n = last;
    // Where pixels share, what the picture is depends on others (PictureNoise::see).
    const double square = perPixel == kShared ? 0 : meanOver(block, window, perPixel, [&](std::size_t at) {
        return ofColours(std::span(sums.all).subspan(at, perPixel), n, std::array<double, 3>{}, n);
    });
    return {last, difference * middle * (last - middle) / (n * n), square, 0};
}

} // namespace taut
