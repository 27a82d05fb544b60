/// What the sums of a film say of a block of pixels.

#include "taut/render/picture_noise.h"

namespace taut {

namespace {

/// Mean over a block's values of what `value` makes of their place in the window's sums.
template <class Value> double meanOver(const Window &block, const Window &window, const Value &value) {
    double sum = 0;
    for (int y = block.y0; y < block.y1; ++y)
        for (int x = block.x0; x < block.x1; ++x)
            for (int channel = 0; channel < 3; ++channel)
                sum += value(static_cast<std::size_t>(((y - window.y0) * window.width() + x - window.x0) * 3 + channel));
    return sum / (3.0 * block.width() * block.height());
}

} // namespace

void ColourSums::fill(const Film &film, const Window &window, std::vector<double> &sums) {
    sums.clear();
    for (int y = window.y0; y < window.y1; ++y)
        for (int x = window.x0; x < window.x1; ++x)
            for (std::size_t channel = 0; channel < 3; ++channel) sums.push_back(film.sumAt(x, y, channel).value());
}

BlockError blockErrorOf(const Window &block, const Window &window, const ColourSums &sums, int middle, int last) {
    const double before = middle;
    const double added = last - middle;
    const double difference = meanOver(block, window, [&](std::size_t i) {
        const double d = sums.half[i] / before - (sums.all[i] - sums.half[i]) / added;
        return d * d;
    });
    const double square = meanOver(block, window, [&](std::size_t i) { return sums.all[i] * sums.all[i]; });
    const double n = last;
    return {last, difference * before * added / (n * n), square / (n * n), 0};
}

} // namespace taut
