#include "taut/render/denoise.h"

#include "taut/base/parallel.h"
#include "taut/render/denoise_oidn.h"
#include "taut/render/denoise_regression.h"

#include <algorithm>
#include <cmath>

namespace taut {

namespace {

/// Of the variance that halves show; no points stratify each other better than it is believed.
constexpr float kLeastShared = 0.05F;
/// Standard errors of a pixel that a filter may differ from it by.
constexpr float kMostErrors = 2.5F;
constexpr float kFewSamples = 4;
/// Radius over which errors are averaged: one pixel says little of its own.
constexpr int kErrorRadius = 4;
/// And that over which a choice passes into the next.
constexpr int kBlendRadius = 1;
/// Where it is not known how many samples there will be.
constexpr int kBlockOfUnknown = 8;

/// The filters. The first sees features alone, and is the guide of those that see colours.
constexpr RegressionScale kFirst{.radius = 4, .stride = 4, .gloss = 3};
constexpr RegressionScale kOthers[] = {{.radius = 3, .stride = 3, .gloss = 0},                    // mirrors, small things
                                       {.radius = 6, .stride = 4, .gloss = 1},                    // long along a highlight, short across
                                       {.radius = 7, .stride = 4, .curved = true, .gloss = 0.2F}, // its ridge
                                       {.radius = 8, .stride = 7, .curved = true, .lonely = false, .gloss = 3, .guide = 1.5F},
                                       {.radius = 15, .stride = 13, .curved = true, .lonely = false, .gloss = 3, .guide = 1.5F}};

/// A way to filter, and what is thought of it.
struct Candidate {
    ColourPlanes colour;
    Plane error; ///< mean squared error of a colour, relative to `brightness`
};

/// What errors are relative to: the square of the light around a pixel.
Plane brightnessOf(const DenoisePixels &p, const ColourPlanes &colour) {
    Plane light(p.count());
    double sum = 0;
    for (std::size_t i = 0; i < light.size(); ++i) {
        light[i] = (colour[0][i] + colour[1][i] + colour[2][i]) / 3;
        sum += static_cast<double>(light[i]);
    }
    boxMean(light, p.width, p.height, 1);
    const auto floor = static_cast<float>(0.01 * sum * sum / std::max(1.0, static_cast<double>(light.size() * light.size())) + 1e-30);
    for (float &l : light) l = l * l + floor;
    return light;
}

/// The mean of both halves' predictions, as each pixel has samples in them; and the variance of that.
Guide guideOf(const DenoisePixels &p, const Regressed &r) {
    Guide guide;
    const std::size_t count = p.count();
    for (Plane &plane : guide.colour) plane.assign(p.stored(), 0);
    guide.variance.assign(p.stored(), 0);
    for (std::size_t i = 0; i < count; ++i)
        for (std::size_t c = 0; c < 3; ++c) {
            const float a = r.half[0][c][i];
            const float b = r.half[1][c][i];
            guide.colour[c][i] = 0.5F * (a + b);
            guide.variance[i] += (a - b) * (a - b) / 12;
        }
    boxMean(guide.variance, p.width, p.height, 1);
    return guide;
}

/// Share of what the halves' difference shows as the variance of their mean that is really there. Points that stratify each other err in
/// opposite directions in the two, so that they differ by more than the mean errs; a prediction from one half, held against the other,
/// bounds it.
Plane sharedVariance(const DenoisePixels &p, const Regressed &r, const Plane &brightness) {
    Plane apart(p.count());
    Plane between(p.count());
    for (std::size_t i = 0; i < apart.size(); ++i) {
        if (p.trust[i] == 0 || p.share[0][i] == 0 || p.share[1][i] == 0) continue;
        for (std::size_t c = 0; c < 3; ++c) {
            for (std::size_t half = 0; half < 2; ++half) {
                const float d = r.half[half][c][i] - p.half[1 - half][c][i];
                apart[i] += p.share[1 - half][i] * d * d / brightness[i];
            }
            between[i] += p.variance[i] / brightness[i];
        }
    }
    boxMean(apart, p.width, p.height, kErrorRadius);
    boxMean(between, p.width, p.height, kErrorRadius);
    // Of halves alike: half of (V + D^2) twice, less D^2, is V.
    for (std::size_t i = 0; i < apart.size(); ++i)
        apart[i] = between[i] > 0 ? std::clamp(apart[i] / between[i] - 1, kLeastShared, 1.0F) : 1.0F;
    return apart;
}

/// A prediction from one half is held against the other half, which it knows nothing of: what it differs by beyond the noise there is its
/// error. The mean of both predictions has less: half of what they differ by.
Candidate candidateOf(const DenoisePixels &p, const Regressed &r, const Plane &brightness, const Plane &shared) {
    Candidate candidate;
    candidate.colour = guideOf(p, r).colour;
    candidate.error.assign(p.count(), 0);
    parallelFor(p.count(), 4096, [&](std::size_t i) {
        if (p.trust[i] == 0) return;
        float error = 0;
        float weight = 0;
        for (std::size_t half = 0; half < 2; ++half) {
            const float share = p.share[1 - half][i];
            if (share == 0) continue;
            weight += share;
            for (std::size_t c = 0; c < 3; ++c) {
                const float apart = r.half[half][c][i] - p.half[1 - half][c][i];
                error += share * (apart * apart - p.variance[i] * (1 / share - 1 + shared[i])) / 3;
            }
        }
        float between = 0;
        for (std::size_t c = 0; c < 3; ++c) {
            const float apart = r.half[0][c][i] - r.half[1][c][i];
            between += apart * apart / 12;
        }
        if (weight > 0) candidate.error[i] = (error / weight - between) / brightness[i];
    });
    boxMean(candidate.error, p.width, p.height, kErrorRadius);
    for (std::size_t i = 0; i < candidate.error.size(); ++i)
        if (r.known[i] == 0) candidate.error[i] = kInfinity;
    return candidate;
}

Candidate unfiltered(const DenoisePixels &p, const Plane &brightness, const Plane &shared) {
    Candidate candidate{p.mean, Plane(p.count())};
    for (std::size_t i = 0; i < candidate.error.size(); ++i)
        candidate.error[i] = p.trust[i] * shared[i] * p.variance[i] / brightness[i];
    boxMean(candidate.error, p.width, p.height, kErrorRadius);
    for (std::size_t i = 0; i < candidate.error.size(); ++i)
        if (p.trust[i] == 0) candidate.error[i] = kInfinity;
    return candidate;
}

/// What the samples of a pixel refute is not taken: a prediction stays within some of their standard errors. Those of few
/// samples, which may all have missed the same light, are no less than what they are around.
void holdToSamples(const DenoisePixels &p, Regressed &r) {
    Plane around = p.variance;
    boxMean(around, p.width, p.height, 1);
    for (std::size_t i = 0; i < p.count(); ++i) {
        if (p.trust[i] == 0) continue;
        const float missed = std::min(1.0F, kFewSamples / std::max(1.0F, p.samples[i]));
        const float reach = kMostErrors * std::sqrt(std::max(p.variance[i], missed * around[i]));
        for (ColourPlanes &half : r.half)
            for (std::size_t c = 0; c < 3; ++c) half[c][i] = std::clamp(half[c][i], p.mean[c][i] - reach, p.mean[c][i] + reach);
    }
}

/// Of each pixel the candidate of the least error, with soft seams.
Denoised best(const DenoisePixels &p, const std::vector<Candidate> &candidates, const Plane &brightness) {
    const std::size_t count = p.count();
    std::vector<std::uint8_t> chosen(count, 0);
    for (std::size_t i = 0; i < count; ++i)
        for (std::size_t k = 1; k < candidates.size(); ++k)
            if (candidates[k].error[i] < candidates[chosen[i]].error[i]) chosen[i] = static_cast<std::uint8_t>(k);
    Denoised out;
    out.rgb.assign(3 * count, 0);
    out.error.assign(count, 0);
    for (std::size_t k = 0; k < candidates.size(); ++k) {
        Plane share(count);
        for (std::size_t i = 0; i < count; ++i) share[i] = chosen[i] == k ? 1.0F : 0.0F;
        boxMean(share, p.width, p.height, kBlendRadius);
        for (std::size_t i = 0; i < count; ++i) {
            if (share[i] == 0) continue;
            // What is no choice of this pixel is none of its neighbours' either.
            const bool valid = candidates[k].error[i] < kInfinity;
            const Candidate &from = candidates[valid ? k : chosen[i]];
            for (std::size_t c = 0; c < 3; ++c) out.rgb[3 * i + c] += share[i] * from.colour[c][i];
            out.error[i] += share[i] * std::max(0.0F, from.error[i] < kInfinity ? from.error[i] : 0.0F);
        }
    }
    for (std::size_t i = 0; i < count; ++i) out.error[i] = std::sqrt(out.error[i] * brightness[i]);
    return out;
}

} // namespace

int denoiseBlockOf(int samples, bool known) {
    return known ? std::max(1, samples / 2) : kBlockOfUnknown;
}

Denoised denoise(const Film &film) {
    return denoise(denoisePixelsOf(film));
}

Denoised denoise(const DenoisePixels &pixels) {
    if (pixels.count() == 0) return {};
#ifdef TAUT_OPEN_IMAGE_DENOISE
    const bool own = false;
    Regressed first = openImageDenoise(pixels);
#else
    const bool own = true;
    Regressed first = regress(pixels, kFirst, nullptr);
#endif
    holdToSamples(pixels, first);
    const Guide guide = guideOf(pixels, first);
    const Plane brightness = brightnessOf(pixels, guide.colour);
    const Plane shared = sharedVariance(pixels, first, brightness);
    std::vector<Candidate> candidates;
    candidates.push_back(unfiltered(pixels, brightness, shared));
    candidates.push_back(candidateOf(pixels, first, brightness, shared));
    if (own)
        for (const RegressionScale &scale : kOthers) {
            Regressed other = regress(pixels, scale, &guide);
            holdToSamples(pixels, other);
            candidates.push_back(candidateOf(pixels, other, brightness, shared));
        }
    return best(pixels, candidates, brightness);
}

} // namespace taut
