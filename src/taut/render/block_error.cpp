/// What the sums of a film say of a block of pixels.

#include "taut/render/picture_noise.h"

namespace taut {

namespace {

constexpr std::size_t kShared = SharedSums::kShares * SharedSums::kValues;

/// Mean over R, G, B of the square of a difference between sums of a pixel.
double ofColours(const double *first, double s1, const double *second, double s2) {
    double sum = 0;
    for (std::size_t i = 0; i < 3; ++i) sum += sqr(s1 * first[i] - s2 * second[i]);
    return sum / 3;
}

/// Of what a pixel shares. The picture is a mean by the weights that there are: too much weight brings a pixel only what its light is off
/// the mean around, for which the mean of the pixel that gives is taken: a little too low along hard outlines.
double ofShares(const double *first, double s1, const double *second, double s2) {
    constexpr std::size_t n = SharedSums::kShares;
    constexpr std::size_t kRow = 4; // sums of its columns, as vectors add them
    const auto sumOf = [](const double *values) {
        std::array<double, kRow> sums{};
        for (std::size_t k = 0; k < n; ++k) sums[k % kRow] += values[k];
        return sums[0] + sums[1] + sums[2] + sums[3];
    };
    std::array<double, n> weights{};
    for (std::size_t k = 0; k < n; ++k) weights[k] = s1 * first[4 * n + k] - s2 * second[4 * n + k];
    const double weight = sumOf(second + 4 * n);
    std::array<double, n> squares{};
    for (std::size_t channel = 0; channel < 3; ++channel) {
        const double *a = first + channel * n;
        const double *b = second + channel * n;
        const double mean = weight > 0 ? sumOf(b) / weight : 0;
        for (std::size_t k = 0; k < n; ++k) squares[k] += sqr(s1 * a[k] - s2 * b[k] - mean * weights[k]);
    }
    return sumOf(squares.data()) / 3;
}

struct Mean {
    double value = 0;
    double spread = 0; ///< variance of that, by what pixels differ
};

/// Mean over a part's pixels of what `value` makes of their place in the window's sums.
template <class Value> Mean meanOver(const Window &part, const Window &window, std::size_t perPixel, const Value &value) {
    double sum = 0;
    double squares = 0;
    for (int y = part.y0; y < part.y1; ++y)
        for (int x = part.x0; x < part.x1; ++x) {
            const double v = value(static_cast<std::size_t>((y - window.y0) * window.width() + x - window.x0) * perPixel);
            sum += v;
            squares += v * v;
        }
    const double pixels = static_cast<double>(part.width()) * part.height();
    return {sum / pixels, pixels > 1 ? std::max(0.0, squares - sum * sum / pixels) / ((pixels - 1) * pixels) : 0};
}

/// squaredDifference() with its spread.
Mean differenceOver(const Window &part, const Window &window, std::span<const double> first, double s1, std::span<const double> second,
                    double s2, std::size_t perPixel) {
    const auto of = perPixel == kShared ? ofShares : ofColours;
    return meanOver(part, window, perPixel, [&](std::size_t at) { return of(&first[at], s1, &second[at], s2); });
}

std::size_t valuesAPixel(const Window &window, std::span<const double> sums) {
    return sums.size() / (static_cast<std::size_t>(window.width()) * static_cast<std::size_t>(window.height()));
}

} // namespace

void ColourSums::fill(const Film &film, const Window &window, std::vector<double> &sums) {
    const SharedSums *shared = film.sharedSums();
    const std::size_t perPixel = shared != nullptr ? kShared : 3;
    sums.resize(static_cast<std::size_t>(window.width()) * static_cast<std::size_t>(window.height()) * perPixel);
    double *next = sums.data();
    for (int y = window.y0; y < window.y1; ++y)
        for (int x = window.x0; x < window.x1; ++x, next += perPixel) {
            if (shared != nullptr) {
                const SharedSums::Shares &shares = shared->at(x, y);
                for (std::size_t i = 0; i < SharedSums::kValues; ++i)
                    for (std::size_t k = 0; k < SharedSums::kShares; ++k)
                        next[i * SharedSums::kShares + k] = static_cast<double>(shares[i][k]);
            } else {
                for (std::size_t channel = 0; channel < 3; ++channel) next[channel] = film.sumAt(x, y, channel).value();
            }
        }
}

double squaredDifference(const Window &part, const Window &window, std::span<const double> first, double s1, std::span<const double> second,
                         double s2) {
    return differenceOver(part, window, first, s1, second, s2, valuesAPixel(window, first)).value;
}

BlockError blockErrorOf(const Window &block, const Window &window, const ColourSums &sums, int middle, int last) {
    const double before = middle;
    const double added = last - middle;
    const double n = last;
    const std::size_t perPixel = valuesAPixel(window, sums.all);
    // half / before - (all - half) / added
    const Mean difference = differenceOver(block, window, sums.half, 1 / before + 1 / added, sums.all, 1 / added, perPixel);
    const double scale = before * added / (n * n);
    // Where pixels share, what the picture is depends on others (PictureNoise::noteSquares).
    const double square = perPixel == kShared ? 0 : meanOver(block, window, perPixel, [&](std::size_t at) {
                                                        return ofColours(&sums.all[at], 1 / n, &sums.all[at], 0);
                                                    }).value;
    return {last, scale * difference.value, sqr(scale) * difference.spread, square, 0};
}

} // namespace taut
