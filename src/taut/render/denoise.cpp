#include "taut/render/denoise.h"

#include "taut/base/parallel.h"
#include "taut/render/denoise_oidn.h"
#include "taut/render/denoise_regression.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace taut {

namespace {

/// Of the variance that halves show; no points stratify each other better than it is believed.
constexpr float kLeastShared = 0.05F;
/// Standard errors of a pixel that a filter may differ from it by.
constexpr float kMostErrors = 3.5F;
constexpr float kFewSamples = 4;
/// Radius over which errors are averaged: one pixel says little of its own.
constexpr int kErrorRadius = 4;
/// No filter is believed to leave less than that share of a pixel's noise.
constexpr float kLeastLeft = 0.02F;
/// Where it is not known how many samples there will be.
constexpr int kBlockOfUnknown = 8;

/// The filters. The first sees features alone, and is the guide of those that see colours.
constexpr RegressionScale kFirst{.radius = 4, .stride = 4, .gloss = 3};
constexpr RegressionScale kOthers[] = {{.radius = 3, .stride = 3, .gloss = 0},                    // mirrors, small things
                                       {.radius = 6, .stride = 4, .gloss = 1},                    // long along a highlight, short across
                                       {.radius = 7, .stride = 4, .curved = true, .gloss = 0.2F}, // its ridge
                                       {.radius = 8, .stride = 7, .curved = true, .lonely = false, .gloss = 3, .guide = 1.5F},
                                       {.radius = 15, .stride = 13, .curved = true, .lonely = false, .gloss = 3, .guide = 1.5F}};

void forPixels(const DenoisePixels &p, const auto &use) {
    parallelFor(p.count(), 4096, use);
}

/// A hundredth of the square of a picture's mean light: darker places count no more.
float darkestOf(const Film &film) {
    const Window &window = film.window();
    std::vector<double> rows(static_cast<std::size_t>(window.height()));
    parallelFor(rows.size(), 16, [&](std::size_t row) {
        const int y = window.y0 + static_cast<int>(row);
        for (int x = window.x0; x < window.x1; ++x)
            for (std::size_t c = 0; c < 3; ++c) rows[row] += film.sumAt(x, y, c).value() / std::max(1U, film.samplesAt(x, y));
    });
    const double light = std::accumulate(rows.begin(), rows.end(), 0.0) / (3.0 * window.width() * window.height());
    return static_cast<float>(0.01 * light * light + 1e-30);
}

/// What errors are relative to: the square of the light around a pixel.
Plane brightnessOf(const DenoisePixels &p, const ColourPlanes &colour, float darkest) {
    Plane light(p.count());
    forPixels(p, [&](std::size_t i) { light[i] = (colour[0][i] + colour[1][i] + colour[2][i]) / 3; });
    boxMean(light, p.width, p.height, 1);
    forPixels(p, [&](std::size_t i) { light[i] = light[i] * light[i] + darkest; });
    return light;
}

/// The mean of both halves' predictions, as each pixel has samples in them; and the variance of that.
Guide guideOf(const DenoisePixels &p, const Regressed &r) {
    Guide guide;
    for (Plane &plane : guide.colour) plane.assign(p.stored(), 0);
    guide.variance.assign(p.stored(), 0);
    forPixels(p, [&](std::size_t i) {
        for (std::size_t c = 0; c < 3; ++c) {
            const float a = r.half[0][c][i];
            const float b = r.half[1][c][i];
            guide.colour[c][i] = 0.5F * (a + b);
            guide.variance[i] += (a - b) * (a - b) / 12;
        }
    });
    boxMean(guide.variance, p.width, p.height, 1);
    return guide;
}

/// Share of what the halves' difference shows as the variance of their mean that is really there. Points that stratify each other err in
/// opposite directions in the two, so that they differ by more than the mean errs; a prediction from one half, held against the other,
/// bounds it.
Plane sharedVariance(const DenoisePixels &p, const Regressed &r, const Plane &brightness) {
    Plane apart(p.count());
    Plane between(p.count());
    forPixels(p, [&](std::size_t i) {
        if (p.trust[i] == 0 || p.share[0][i] == 0 || p.share[1][i] == 0) return;
        for (std::size_t c = 0; c < 3; ++c) {
            for (std::size_t half = 0; half < 2; ++half) {
                const float d = r.half[half][c][i] - p.half[1 - half][c][i];
                apart[i] += p.share[1 - half][i] * d * d / brightness[i];
            }
            between[i] += p.variance[i] / brightness[i];
        }
    });
    const Around around(p, kErrorRadius);
    around.average(apart);
    around.average(between);
    // Of halves alike: half of (V + D^2) twice, less D^2, is V.
    for (std::size_t i = 0; i < apart.size(); ++i)
        apart[i] = between[i] > 0 ? std::clamp(apart[i] / between[i] - 1, kLeastShared, 1.0F) : 1.0F;
    return apart;
}

/// A prediction from one half is held against the other half, which it knows nothing of: what it differs by beyond the noise there is its
/// error. The mean of both predictions has less: half of what they differ by. Relative to the brightness.
Plane errorOf(const DenoisePixels &p, const Regressed &r, const Plane &brightness, const Plane &shared) {
    Plane error(p.count());
    forPixels(p, [&](std::size_t i) {
        if (p.trust[i] == 0) return;
        float sum = 0;
        float weight = 0;
        for (std::size_t half = 0; half < 2; ++half) {
            const float share = p.share[1 - half][i];
            if (share == 0) continue;
            weight += share;
            for (std::size_t c = 0; c < 3; ++c) {
                const float apart = r.half[half][c][i] - p.half[1 - half][c][i];
                sum += share * (apart * apart - p.variance[i] * (1 / share - 1 + shared[i])) / 3;
            }
        }
        float between = 0;
        for (std::size_t c = 0; c < 3; ++c) {
            const float apart = r.half[0][c][i] - r.half[1][c][i];
            between += apart * apart / 12;
        }
        if (weight > 0) error[i] = (sum / weight - between) / brightness[i];
    });
    return error;
}

Plane errorOfUnfiltered(const DenoisePixels &p, const Plane &brightness, const Plane &shared) {
    Plane error(p.count());
    forPixels(p, [&](std::size_t i) { error[i] = p.trust[i] * shared[i] * p.variance[i] / brightness[i]; });
    return error;
}

/// The brightest that what covers a pixel may be, by the pixels around; of outlines before nothing.
float brightestCover(const DenoisePixels &p, std::size_t i, std::size_t c) {
    const int x = static_cast<int>(i % static_cast<std::size_t>(p.width));
    const int y = static_cast<int>(i / static_cast<std::size_t>(p.width));
    float most = 0;
    for (int v = std::max(0, y - 1); v <= std::min(p.height - 1, y + 1); ++v)
        for (int u = std::max(0, x - 1); u <= std::min(p.width - 1, x + 1); ++u) {
            const std::size_t j = static_cast<std::size_t>(v) * static_cast<std::size_t>(p.width) + static_cast<std::size_t>(u);
            if (p.cover[j] > 0) most = std::max(most, p.mean[c][j] / p.cover[j]);
        }
    return most;
}

/// What the samples of a pixel refute is not taken: a prediction stays within some of their standard errors. Those of few
/// samples, which may all have missed the same light, are no less than what they are around.
void holdToSamples(const DenoisePixels &p, Regressed &r) {
    Plane around = p.variance;
    boxMean(around, p.width, p.height, 1);
    forPixels(p, [&](std::size_t i) {
        if (p.trust[i] == 0) return;
        const float missed = std::min(1.0F, kFewSamples / std::max(1.0F, p.samples[i]));
        const float reach = kMostErrors * std::sqrt(std::max(p.variance[i], missed * around[i]));
        const bool ends = p.edge[i] > 0 && p.cover[i] < 1;
        for (std::size_t c = 0; c < 3; ++c) {
            const float most = ends ? std::max(p.mean[c][i], p.cover[i] * brightestCover(p, i, c)) : p.mean[c][i] + reach;
            for (ColourPlanes &half : r.half)
                half[c][i] = std::clamp(half[c][i], p.mean[c][i] - reach, std::min(p.mean[c][i] + reach, most));
        }
    });
}

/// The mean of all ways to filter, by the inverse squares of their errors: the best of them all but alone, those alike together.
class Blend {
  public:
    Blend(const DenoisePixels &p, const Plane &brightness, const Plane &shared)
        : p_(p), brightness_(brightness), shared_(shared), around_(p, kErrorRadius), left_(errorOfUnfiltered(p, brightness, shared)),
          weights_(p.count()) {
        out_.rgb.assign(3 * p.count(), 0);
        out_.error.assign(p.count(), kInfinity);
        around_.average(left_);
        Plane all = left_;
        add(all, p.trust, [&](std::size_t i, std::size_t c) { return p.mean[c][i]; });
        forPixels(p, [&](std::size_t i) { left_[i] = kLeastLeft * left_[i] + 1e-12F; });
    }

    void add(const Regressed &r) {
        Plane error = errorOf(p_, r, brightness_, shared_);
        around_.average(error);
        add(error, r.known, [&](std::size_t i, std::size_t c) { return 0.5F * (r.half[0][c][i] + r.half[1][c][i]); });
    }

    Denoised finish() && {
        forPixels(p_, [&](std::size_t i) {
            out_.error[i] = out_.error[i] < kInfinity ? std::sqrt(out_.error[i] * brightness_[i]) : 0;
            if (!(weights_[i] > 0)) return;
            for (std::size_t c = 0; c < 3; ++c) out_.rgb[3 * i + c] /= weights_[i];
        });
        return std::move(out_);
    }

  private:
    const DenoisePixels &p_;
    const Plane &brightness_;
    const Plane &shared_;
    Around around_;
    Plane left_; // the least error that is believed
    Plane weights_;
    Denoised out_;

    void add(const Plane &error, const Plane &valid, const auto &colour) {
        forPixels(p_, [&](std::size_t i) {
            if (valid[i] == 0) return;
            const float held = std::max(error[i], left_[i]) + 1e-12F;
            const float weight = 1 / (held * held);
            weights_[i] += weight;
            for (std::size_t c = 0; c < 3; ++c) out_.rgb[3 * i + c] += weight * colour(i, c);
            out_.error[i] = std::min(out_.error[i], held);
        });
    }
};

} // namespace

int denoiseBlockOf(int samples, bool known) {
    return known ? std::max(1, samples / 2) : kBlockOfUnknown;
}

namespace {

Denoised filtered(const DenoisePixels &pixels, float darkest) {
#ifdef TAUT_OPEN_IMAGE_DENOISE
    const bool own = false;
    Regressed first = openImageDenoise(pixels);
#else
    const bool own = true;
    Regressed first = regress(pixels, kFirst, nullptr);
#endif
    holdToSamples(pixels, first);
    const Guide guide = guideOf(pixels, first);
    const Plane brightness = brightnessOf(pixels, guide.colour, darkest);
    const Plane shared = sharedVariance(pixels, first, brightness);
    Blend blend(pixels, brightness, shared);
    blend.add(first);
    if (own)
        for (const RegressionScale &scale : kOthers) {
            Regressed other = regress(pixels, scale, &guide);
            holdToSamples(pixels, other);
            blend.add(other);
        }
    return std::move(blend).finish();
}

} // namespace

/// A figure before nothing is a part of the picture: the rest is known, and takes no time.
Denoised denoise(const Film &film) {
    const Window &window = film.window();
    const Window part = noisyPart(film);
    Denoised whole;
    if (window.empty()) return whole;
    if (part == window) return filtered(denoisePixelsOf(film, window), darkestOf(film));
    const auto width = static_cast<std::size_t>(window.width());
    const std::size_t count = width * static_cast<std::size_t>(window.height());
    whole.rgb.resize(3 * count);
    whole.error.resize(count);
    parallelFor(static_cast<std::size_t>(window.height()), 16, [&](std::size_t row) {
        const int y = window.y0 + static_cast<int>(row);
        for (std::size_t across = 0; across < width; ++across) {
            const int x = window.x0 + static_cast<int>(across);
            const double inverse = 1.0 / film.samplesAt(x, y); // as Film::colours() has it, to the bit
            for (std::size_t c = 0; c < 3; ++c)
                whole.rgb[3 * (row * width + across) + c] = static_cast<float>(film.sumAt(x, y, c).value() * inverse);
        }
    });
    if (part.empty()) return whole;
    const Denoised own = filtered(denoisePixelsOf(film, part), darkestOf(film));
    const auto across = static_cast<std::size_t>(part.width());
    for (int y = part.y0; y < part.y1; ++y) {
        const std::size_t from = static_cast<std::size_t>(y - part.y0) * across;
        const std::size_t to = static_cast<std::size_t>(y - window.y0) * width + static_cast<std::size_t>(part.x0 - window.x0);
        std::copy_n(&own.rgb[3 * from], 3 * across, &whole.rgb[3 * to]);
        std::copy_n(&own.error[from], across, &whole.error[to]);
    }
    return whole;
}

} // namespace taut
