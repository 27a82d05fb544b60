#include "taut/render/denoise_pixels.h"

#include "taut/base/error.h"
#include "taut/base/parallel.h"

#include <algorithm>
#include <cmath>

namespace taut {

namespace {

/// Radius over which the halves say what stratified points save against random ones.
constexpr int kStratification = 6;
/// A pixel is one sample's doing where its variance is so many times the third largest around it, itself included.
constexpr float kSpike = 16;

void forRows(const DenoisePixels &p, const auto &row) {
    parallelFor(static_cast<std::size_t>(p.height), 4, [&](std::size_t y) { row(static_cast<int>(y)); });
}

void allocate(DenoisePixels &p) {
    const std::size_t pixels = static_cast<std::size_t>(p.width) * static_cast<std::size_t>(p.height);
    const auto each = [&](auto &planes) {
        for (Plane &plane : planes) plane.assign(pixels, 0);
    };
    each(p.mean);
    each(p.half[0]);
    each(p.half[1]);
    each(p.share);
    each(p.variance);
    each(p.normal);
    each(p.albedo);
    each(p.featureNoise);
    each(p.halfway);
    each(p.stretch);
    each(p.gloss);
    each(p.motion);
    p.alpha.assign(pixels, 0);
    p.samples.assign(pixels, 0);
    p.trust.assign(pixels, 1);
    p.depth.assign(pixels, 0);
    p.moving.assign(pixels, 0);
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
    p.alpha[i] = static_cast<float>(film.sumAt(x, y, 3).value() / n);
    for (std::size_t c = 0; c < 3; ++c) {
        const double sum = film.sumAt(x, y, c).value();
        const double half = sums.half[c].value();
        const double mean = sum / n;
        p.mean[c][i] = static_cast<float>(mean);
        if (first > 0) p.half[0][c][i] = static_cast<float>((sum - half) / first);
        if (second > 0) p.half[1][c][i] = static_cast<float>(half / second);
        if (n > 1) p.variance[c][i] = static_cast<float>(std::max(0.0, sums.squares[c].value() / n - mean * mean) / (n - 1));
        if (first > 0 && second > 0) {
            const double apart = static_cast<double>(p.half[0][c][i]) - static_cast<double>(p.half[1][c][i]);
            between[i] += static_cast<float>(apart * apart * first * second / (3 * n * n));
        }
    }
}

void readFeatures(const DenoiseSums::Pixel &sums, std::size_t i, DenoisePixels &p) {
    if (sums.told == 0 || sums.hits == 0) return;
    const double ofTold = DenoiseSums::kUnit / sums.told;
    const double ofHits = DenoiseSums::kUnit / sums.hits;
    const auto mean = [&](int feature, double unit) {
        return static_cast<double>(sums.features[static_cast<std::size_t>(feature)]) * unit;
    };
    for (int c = 0; c < 3; ++c) {
        const auto k = static_cast<std::size_t>(c);
        p.normal[k][i] = static_cast<float>(mean(kNormal + c, ofTold));
        p.albedo[k][i] = static_cast<float>(mean(kAlbedo + c, ofTold));
        p.halfway[k][i] = static_cast<float>(mean(kHalfway + c, ofHits));
        for (const auto &[feature, noise] : {std::pair(kNormal + c, 0), std::pair(kAlbedo + c, 1)}) {
            const double m = mean(feature, ofTold);
            const double square = static_cast<double>(sums.featureSquares[static_cast<std::size_t>(feature)]) * ofTold;
            p.featureNoise[noise][i] += static_cast<float>(std::max(0.0, square - m * m) / (3.0 * sums.told));
        }
    }
    p.depth[i] = static_cast<float>(mean(kDepth, ofHits));
    for (int c = 0; c < 2; ++c) p.stretch[static_cast<std::size_t>(c)][i] = static_cast<float>(mean(kLogStretch + c, ofHits));
    for (int c = 0; c < 6; ++c) p.gloss[static_cast<std::size_t>(c)][i] = static_cast<float>(mean(kGloss + c, ofHits));
    if (sums.moving == 0) return;
    const double ofMoving = DenoiseSums::kUnit / sums.moving;
    for (int c = 0; c < 2; ++c) p.motion[static_cast<std::size_t>(c)][i] = static_cast<float>(mean(kMotion + c, ofMoving));
    p.moving[i] = static_cast<float>(sums.moving) / static_cast<float>(sums.told);
}

/// The sample variance knows nothing of points that stratify each other, the difference of the halves does but is noisy: the one is
/// scaled by the other's mean around (Rousselle et al. 2012, section 6).
void scaleVariance(DenoisePixels &p, Plane between) {
    Plane sampled(between.size());
    for (std::size_t i = 0; i < sampled.size(); ++i) sampled[i] = (p.variance[0][i] + p.variance[1][i] + p.variance[2][i]) / 3;
    boxMean(between, p.width, p.height, kStratification);
    boxMean(sampled, p.width, p.height, kStratification);
    for (std::size_t i = 0; i < sampled.size(); ++i) {
        const float ratio = sampled[i] > 0 ? std::clamp(between[i] / sampled[i], 0.01F, 1.5F) : 1.0F;
        for (Plane &v : p.variance) v[i] *= ratio;
    }
}

/// Where there is one sample a pixel, its neighbours say how much it varies.
void spatialVariance(const Film &film, DenoisePixels &p) {
    for (std::size_t c = 0; c < 3; ++c) {
        Plane mean = p.mean[c];
        Plane square(mean.size());
        for (std::size_t i = 0; i < mean.size(); ++i) square[i] = mean[i] * mean[i];
        boxMean(mean, p.width, p.height, 2);
        boxMean(square, p.width, p.height, 2);
        std::size_t i = 0;
        for (int y = film.window().y0; y < film.window().y1; ++y)
            for (int x = film.window().x0; x < film.window().x1; ++x, ++i)
                if (film.samplesAt(x, y) < 2) p.variance[c][i] = std::max(0.0F, square[i] - mean[i] * mean[i]);
    }
}

/// Pixels that one bright sample made: brighter than all around, and of a variance that is beyond theirs by far.
void distrustSpikes(DenoisePixels &p) {
    const auto luminance = [&](const ColourPlanes &c, std::size_t i) { return c[0][i] + c[1][i] + c[2][i]; };
    forRows(p, [&](int y) {
        for (int x = 0; x < p.width; ++x) {
            const std::size_t own = static_cast<std::size_t>(y) * static_cast<std::size_t>(p.width) + static_cast<std::size_t>(x);
            const float variance = luminance(p.variance, own);
            const float light = luminance(p.mean, own);
            if (!(variance > 0.1F * light * light)) continue; // an error of half its value and more
            std::array<float, 3> most{};
            float brightest = 0;
            for (int v = std::max(0, y - 2); v <= std::min(p.height - 1, y + 2); ++v)
                for (int u = std::max(0, x - 2); u <= std::min(p.width - 1, x + 2); ++u) {
                    const std::size_t i = static_cast<std::size_t>(v) * static_cast<std::size_t>(p.width) + static_cast<std::size_t>(u);
                    float value = luminance(p.variance, i);
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
    Plane rows(plane.size());
    parallelFor(static_cast<std::size_t>(height), 8, [&](std::size_t y) {
        const float *in = &plane[y * w];
        for (int x = 0; x < width; ++x) {
            float sum = 0;
            const int last = std::min(width - 1, x + radius);
            for (int u = std::max(0, x - radius); u <= last; ++u) sum += in[u];
            rows[y * w + static_cast<std::size_t>(x)] = sum;
        }
    });
    parallelFor(static_cast<std::size_t>(height), 8, [&](std::size_t row) {
        const int y = static_cast<int>(row);
        const int first = std::max(0, y - radius);
        const int last = std::min(height - 1, y + radius);
        float *out = &plane[row * w];
        std::fill_n(out, w, 0.0F);
        for (int v = first; v <= last; ++v) {
            const float *in = &rows[static_cast<std::size_t>(v) * w];
            for (std::size_t x = 0; x < w; ++x) out[x] += in[x];
        }
        for (int x = 0; x < width; ++x) {
            const int across = std::min(width - 1, x + radius) - std::max(0, x - radius) + 1;
            out[x] /= static_cast<float>(across * (last - first + 1));
        }
    });
}

DenoisePixels denoisePixelsOf(const Film &film) {
    if (film.denoiseSums() == nullptr) throw InputError("denoising: found a film without the sums for it, expected one with them");
    const Window &window = film.window();
    DenoisePixels p;
    p.width = std::max(0, window.width());
    p.height = std::max(0, window.height());
    allocate(p);
    Plane between(p.alpha.size());
    forRows(p, [&](int row) {
        const int y = window.y0 + row;
        std::size_t i = static_cast<std::size_t>(row) * static_cast<std::size_t>(p.width);
        for (int x = window.x0; x < window.x1; ++x, ++i) {
            readColours(film, x, y, i, p, between);
            readFeatures(film.denoiseSums()->at(x, y), i, p);
        }
    });
    bool lone = false;
    for (std::size_t i = 0; i < p.alpha.size(); ++i) p.halves &= p.share[0][i] > 0 && p.share[1][i] > 0;
    for (int y = window.y0; y < window.y1; ++y)
        for (int x = window.x0; x < window.x1; ++x) lone |= film.samplesAt(x, y) < 2;
    if (p.halves) scaleVariance(p, std::move(between));
    if (lone) spatialVariance(film, p);
    distrustSpikes(p);
    return p;
}

} // namespace taut
