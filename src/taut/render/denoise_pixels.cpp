#include "taut/render/denoise_pixels.h"

#include "taut/base/error.h"
#include "taut/base/parallel.h"

#include <algorithm>
#include <cmath>

namespace taut {

namespace {

/// Radius over which the halves say what stratified points save against random ones.
constexpr int kStratification = 6;
/// Probes know more of an outline than so many times fewer samples.
constexpr double kTrustedProbes = 2;
/// Pixels around the noisy ones that filters look at: nothing there is noisy, and errors are averaged over fewer.
constexpr int kMargin = 8;
/// Variances below that share of the square of the mean are rounding.
constexpr double kRounding = 1e-6;
constexpr const char *kNoSums = "denoising: found a film without the sums for it, expected one with them";
/// A pixel is one sample's doing where its variance is so many times the third largest around it, itself included.
constexpr float kSpike = 16;

void forRows(const DenoisePixels &p, const auto &row) {
    parallelFor(static_cast<std::size_t>(p.height), 4, [&](std::size_t y) { row(static_cast<int>(y)); });
}

void allocate(DenoisePixels &p) {
    const std::size_t pixels = p.stored();
    const auto each = [&](auto &planes) {
        for (Plane &plane : planes) plane.assign(pixels, 0);
    };
    each(p.mean);
    each(p.half[0]);
    each(p.half[1]);
    each(p.share);
    each(p.normal);
    each(p.albedo);
    each(p.featureNoise);
    each(p.halfway);
    each(p.stretch);
    each(p.gloss);
    each(p.motion);
    p.variance.assign(pixels, 0);
    p.alpha.assign(pixels, 0);
    p.cover.assign(pixels, 1);
    p.edge.assign(pixels, 0);
    p.samples.assign(pixels, 0);
    p.trust.assign(pixels, 1);
    p.depth.assign(pixels, 0);
    p.moving.assign(pixels, 0);
}

/// How much of an outline's pixel is covered is known by its probes: its light is what its samples saw where they saw something, times
/// that.
struct Cover {
    float scale[2] = {1, 1}; ///< of the halves
};
Cover coverOf(const Film &film, int x, int y, double n, double second) {
    Cover cover;
    const PixelFeatures &f = film.denoiseSums()->featuresAt(x, y);
    if (f.edge == 0 || f.covered == 0 || f.probes < kTrustedProbes * n) return cover;
    const double covered = film.sumAt(x, y, 3).value();
    const double ofSecond = std::min(covered, static_cast<double>(film.denoiseSums()->at(x, y).covered));
    const double known = static_cast<double>(f.covered) / PixelFeatures::kWhole;
    if (covered - ofSecond > 0) cover.scale[0] = static_cast<float>(known * (n - second) / (covered - ofSecond));
    if (ofSecond > 0) cover.scale[1] = static_cast<float>(known * second / ofSecond);
    return cover;
}

/// Of a pixel's samples, each that of three colours.
double varianceOf(const DenoiseSums::Pixel &sums, double n, double meanSquares) {
    const double variance = sums.squares.value() / n - meanSquares;
    return variance > kRounding * meanSquares ? variance / 3 : 0; // squares are rounded to floats
}

/// Whether both halves of a pixel's samples, and its probes, saw one thing throughout.
bool isKnown(const Film &film, int x, int y) {
    const DenoiseSums &kept = *film.denoiseSums();
    const DenoiseSums::Pixel &sums = kept.at(x, y);
    const std::uint32_t samples = film.samplesAt(x, y);
    if (kept.featuresAt(x, y).edge != 0 || sums.second == 0 || sums.second >= samples) return false;
    double meanSquares = 0;
    for (std::size_t c = 0; c < 3; ++c) {
        const double mean = film.sumAt(x, y, c).value() / samples;
        meanSquares += mean * mean;
    }
    return varianceOf(sums, samples, meanSquares) == 0;
}

/// `between`: the variance of the mean as the difference of the halves has it, the mean of three colours.
void readColours(const Film &film, int x, int y, std::size_t i, DenoisePixels &p, Plane &between) {
    const DenoiseSums::Pixel &sums = film.denoiseSums()->at(x, y);
    const auto n = static_cast<double>(film.samplesAt(x, y));
    if (n == 0) return;
    p.samples[i] = static_cast<float>(n);
    const double second = std::min(n, static_cast<double>(sums.second));
    const double first = n - second;
    p.share[0][i] = static_cast<float>(first / n);
    p.share[1][i] = static_cast<float>(second / n);
    const Cover cover = coverOf(film, x, y, n, second);
    double meanSquares = 0;
    for (std::size_t c = 0; c < 3; ++c) {
        const double sum = film.sumAt(x, y, c).value();
        const double half = sums.half[c].value();
        meanSquares += sum / n * sum / n;
        if (first > 0) p.half[0][c][i] = static_cast<float>((sum - half) / first) * cover.scale[0];
        if (second > 0) p.half[1][c][i] = static_cast<float>(half / second) * cover.scale[1];
        p.mean[c][i] = cover.scale[0] == 1 && cover.scale[1] == 1 ? static_cast<float>(sum / n)
                                                                  : p.share[0][i] * p.half[0][c][i] + p.share[1][i] * p.half[1][c][i];
        if (first > 0 && second > 0) {
            const double apart = static_cast<double>(p.half[0][c][i]) - static_cast<double>(p.half[1][c][i]);
            between[i] += static_cast<float>(apart * apart * first * second / (3 * n * n));
        }
    }
    if (n > 1) p.variance[i] = static_cast<float>(varianceOf(sums, n, meanSquares) / (n - 1));
}

void readFeatures(const PixelFeatures &f, std::size_t i, DenoisePixels &p) {
    if (f.probes == 0) return;
    p.alpha[i] = static_cast<float>(f.met) / PixelFeatures::kWhole;
    p.cover[i] = static_cast<float>(f.covered) / PixelFeatures::kWhole;
    p.edge[i] = f.edge != 0 ? 1.0F : 0.0F;
    p.moving[i] = static_cast<float>(f.moving) / PixelFeatures::kWhole;
    if (f.met == 0) return; // features are 0
    const auto read = [&](auto &planes, int first) {
        for (std::size_t k = 0; k < planes.size(); ++k) planes[k][i] = f.at(first + static_cast<int>(k));
    };
    read(p.normal, kNormal);
    read(p.albedo, kAlbedo);
    read(p.halfway, kHalfway);
    read(p.stretch, kLogStretch);
    read(p.gloss, kGloss);
    read(p.motion, kMotion);
    p.depth[i] = f.at(kDepth);
    for (int k = 0; k < 2; ++k) p.featureNoise[k][i] = f.noiseOf(k);
}

/// The sample variance knows nothing of points that stratify each other, the difference of the halves does but is noisy: the one is
/// scaled by the other's mean around (Rousselle et al. 2012, section 6).
void scaleVariance(DenoisePixels &p, Plane between) {
    Plane sampled = p.variance;
    const Around around(p, kStratification);
    around.average(between);
    around.average(sampled);
    for (std::size_t i = 0; i < p.count(); ++i) p.variance[i] *= sampled[i] > 0 ? std::clamp(between[i] / sampled[i], 0.01F, 1.5F) : 1.0F;
}

/// Where there is one sample a pixel, its neighbours say how much it varies.
void spatialVariance(DenoisePixels &p) {
    Plane variance(p.count());
    for (const Plane &plane : p.mean) {
        Plane mean = plane;
        Plane square(mean.size());
        for (std::size_t i = 0; i < p.count(); ++i) square[i] = mean[i] * mean[i];
        boxMean(mean, p.width, p.height, 2);
        boxMean(square, p.width, p.height, 2);
        for (std::size_t i = 0; i < p.count(); ++i) variance[i] += std::max(0.0F, square[i] - mean[i] * mean[i]) / 3;
    }
    for (std::size_t i = 0; i < variance.size(); ++i)
        if (p.samples[i] < 2) p.variance[i] = variance[i];
}

/// Pixels that one bright sample made: brighter than all around, and of a variance that is beyond theirs by far.
void distrustSpikes(DenoisePixels &p) {
    const auto luminance = [&](const ColourPlanes &c, std::size_t i) { return c[0][i] + c[1][i] + c[2][i]; };
    forRows(p, [&](int y) {
        for (int x = 0; x < p.width; ++x) {
            const std::size_t own = static_cast<std::size_t>(y) * static_cast<std::size_t>(p.width) + static_cast<std::size_t>(x);
            const float variance = 3 * p.variance[own];
            const float light = luminance(p.mean, own);
            if (!(variance > 0.1F * light * light)) continue; // an error of half its value and more
            std::array<float, 3> most{};
            float brightest = 0;
            for (int v = std::max(0, y - 2); v <= std::min(p.height - 1, y + 2); ++v)
                for (int u = std::max(0, x - 2); u <= std::min(p.width - 1, x + 2); ++u) {
                    const std::size_t i = static_cast<std::size_t>(v) * static_cast<std::size_t>(p.width) + static_cast<std::size_t>(u);
                    float value = 3 * p.variance[i];
                    for (float &m : most)
                        if (value > m) std::swap(value, m);
                    if (i != own) brightest = std::max(brightest, luminance(p.mean, i));
                }
            if (variance > kSpike * most[2] && light > 2 * brightest) p.trust[own] = 0;
        }
    });
}

} // namespace

void boxMean(Plane &plane, int width, int height, int radius) {
    const auto w = static_cast<std::size_t>(width);
    const auto r = static_cast<std::size_t>(radius);
    Plane rows(w * static_cast<std::size_t>(height));
    parallelFor(static_cast<std::size_t>(height), 16, [&](std::size_t y) {
        thread_local std::vector<float> padded;
        padded.assign(w + 2 * r, 0);
        std::copy_n(&plane[y * w], w, padded.begin() + radius);
        float *out = &rows[y * w];
        for (std::size_t k = 0; k <= 2 * r; ++k)
            for (std::size_t x = 0; x < w; ++x) out[x] += padded[x + k];
        for (int x = 0; x < width; ++x) out[x] /= static_cast<float>(std::min(width - 1, x + radius) - std::max(0, x - radius) + 1);
    });
    parallelFor(static_cast<std::size_t>(height), 16, [&](std::size_t row) {
        const int y = static_cast<int>(row);
        const int first = std::max(0, y - radius);
        const int last = std::min(height - 1, y + radius);
        float *out = &plane[row * w];
        std::fill_n(out, w, 0.0F);
        const float share = 1 / static_cast<float>(last - first + 1);
        for (int v = first; v <= last; ++v) {
            const float *in = &rows[static_cast<std::size_t>(v) * w];
            for (std::size_t x = 0; x < w; ++x) out[x] += in[x] * share;
        }
    });
}

Around::Around(const DenoisePixels &p, int radius) : p_(p), radius_(radius), edges_(p.edge) {
    boxMean(edges_, p.width, p.height, radius);
}

void Around::average(Plane &values) const {
    Plane atEdges(p_.count());
    parallelFor(p_.count(), 4096, [&](std::size_t i) {
        atEdges[i] = p_.edge[i] * values[i];
        values[i] -= atEdges[i];
    });
    boxMean(atEdges, p_.width, p_.height, radius_);
    boxMean(values, p_.width, p_.height, radius_);
    parallelFor(p_.count(), 4096,
                [&](std::size_t i) { values[i] = p_.edge[i] > 0 ? atEdges[i] / edges_[i] : values[i] / (1 - edges_[i]); });
}

Window noisyPart(const Film &film) {
    if (film.denoiseSums() == nullptr) throw InputError(kNoSums);
    const Window &window = film.window();
    const auto height = static_cast<std::size_t>(std::max(0, window.height()));
    std::vector<Window> rows(height); // the noisy pixels of each
    parallelFor(height, 16, [&](std::size_t row) {
        const int y = window.y0 + static_cast<int>(row);
        Window &noisy = rows[row];
        for (int x = window.x0; x < window.x1; ++x) {
            if (isKnown(film, x, y)) continue;
            if (noisy.empty()) noisy = {x, y, x + 1, y + 1};
            noisy.x1 = x + 1;
        }
    });
    Window part;
    for (const Window &noisy : rows)
        if (!noisy.empty()) part = part.empty() ? noisy : unionOf(part, noisy);
    if (part.empty()) return {};
    return {std::max(window.x0, part.x0 - kMargin), std::max(window.y0, part.y0 - kMargin), std::min(window.x1, part.x1 + kMargin),
            std::min(window.y1, part.y1 + kMargin)};
}

DenoisePixels denoisePixelsOf(const Film &film, const Window &window) {
    if (film.denoiseSums() == nullptr) throw InputError(kNoSums);
    DenoisePixels p;
    p.width = std::max(0, window.width());
    p.height = std::max(0, window.height());
    allocate(p);
    Plane between(p.count());
    forRows(p, [&](int row) {
        const int y = window.y0 + row;
        std::size_t i = static_cast<std::size_t>(row) * static_cast<std::size_t>(p.width);
        for (int x = window.x0; x < window.x1; ++x, ++i) {
            readColours(film, x, y, i, p, between);
            readFeatures(film.denoiseSums()->featuresAt(x, y), i, p);
        }
    });
    bool lone = false;
    for (std::size_t i = 0; i < p.count(); ++i) p.halves &= p.share[0][i] > 0 && p.share[1][i] > 0;
    for (std::size_t i = 0; i < p.count(); ++i) lone |= p.samples[i] < 2;
    if (p.halves) scaleVariance(p, std::move(between));
    if (lone) spatialVariance(p);
    distrustSpikes(p);
    return p;
}

} // namespace taut
