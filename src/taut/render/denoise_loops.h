#pragma once
/// The loops of denoise_regression.cpp, compiled for several sets of instructions (base/instructions.h): how much the pixels of a window
/// count, what is regressed on, products of columns, predictions. Internal.

#include "taut/render/denoise_pixels.h"

#include <algorithm>

namespace taut::regression {

inline constexpr int kLinear = 10;         ///< 1, place, normal, albedo, coverage
inline constexpr int kMostRegressors = 13; ///< and squares of the place
inline constexpr int kTargets = 6;         ///< colours of both halves
inline constexpr int kColumns = kMostRegressors + kTargets;
inline constexpr int kMostRadius = 16;
inline constexpr int kMostWidth = 2 * kMostRadius + 1;
inline constexpr int kMostPixels = (kMostWidth * kMostWidth + 15) / 16 * 16;
inline constexpr int kLanes = 16; ///< of every sum: the same for all instruction sets, so that they give the same bits
inline constexpr int kSoft = 11;  ///< planes whose differences make a pixel count less

/// All that the loops read.
struct Planes {
    int width = 0, height = 0;
    const float *soft[kSoft];
    float softScale[kSoft]; ///< inverse squares of the differences
    const float *halfway[3];
    const float *gloss[6];
    float glossScale = 0;
    const float *guide[3] = {nullptr, nullptr, nullptr};
    const float *guideVariance = nullptr;
    float guideScale = 0;
    const float *trust;
    const float *regressors[kLinear - 3]; ///< normal, albedo, coverage
    const float *targets[kTargets];
    int radius = 0;
    bool curved = false;
    [[nodiscard]] int count() const { return curved ? kMostRegressors : kLinear; }
    [[nodiscard]] std::size_t at(int x, int y) const {
        return static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x);
    }
};

/// A window's centre, and the part of its window that lies in the picture.
struct Centre {
    int x = 0, y = 0;
    int x0 = 0, x1 = 0, y0 = 0, y1 = 0;
};
inline Centre centreAt(const Planes &p, int x, int y) {
    return {x,
            y,
            std::max(0, x - p.radius),
            std::min(p.width, x + p.radius + 1),
            std::max(0, y - p.radius),
            std::min(p.height, y + p.radius + 1)};
}

/// How much each pixel of a row of a window counts; `near`: for its place alone.
[[gnu::always_inline]] inline void weightLoop(const Planes &p, const Centre &c, int y, float *weight, float *near) {
    const std::size_t own = p.at(c.x, c.y);
    const std::size_t row = p.at(c.x0, y);
    const int n = c.x1 - c.x0;
    float d[kMostWidth];
    for (int i = 0; i < n; ++i) d[i] = 0;
    for (int k = 0; k < kSoft; ++k) {
        const float scale = p.softScale[k];
        if (scale == 0) continue;
        const float *f = p.soft[k] + row;
        const float at = p.soft[k][own];
        for (int i = 0; i < n; ++i) d[i] += (f[i] - at) * (f[i] - at) * scale;
    }
    if (p.glossScale > 0) {
        const float *hx = p.halfway[0] + row;
        const float *hy = p.halfway[1] + row;
        const float *hz = p.halfway[2] + row;
        const float x0 = p.halfway[0][own];
        const float y0 = p.halfway[1][own];
        const float z0 = p.halfway[2][own];
        float g[6];
        for (int k = 0; k < 6; ++k) g[k] = p.gloss[k][own] * p.glossScale;
        for (int i = 0; i < n; ++i) {
            const float hX = hx[i] - x0;
            const float hY = hy[i] - y0;
            const float hZ = hz[i] - z0;
            d[i] += g[0] * hX * hX + g[3] * hY * hY + g[5] * hZ * hZ + 2 * (g[1] * hX * hY + g[2] * hX * hZ + g[4] * hY * hZ);
        }
    }
    if (p.guideScale > 0) {
        const float *r = p.guide[0] + row;
        const float *g = p.guide[1] + row;
        const float *b = p.guide[2] + row;
        const float *v = p.guideVariance + row;
        const float r0 = p.guide[0][own];
        const float g0 = p.guide[1][own];
        const float b0 = p.guide[2][own];
        const float v0 = p.guideVariance[own];
        const float light = (r0 + g0 + b0) / 3;
        const float floor = 1e-4F * light * light + 1e-12F;
        for (int i = 0; i < n; ++i) {
            const float apart = ((r[i] - r0) * (r[i] - r0) + (g[i] - g0) * (g[i] - g0) + (b[i] - b0) * (b[i] - b0)) / 3;
            const float beyond = apart - v0 - std::min(v0, v[i]);
            d[i] += std::max(0.0F, beyond) * p.guideScale / (v0 + v[i] + floor);
        }
    }
    const float *trust = p.trust + row;
    const auto reach = static_cast<float>((p.radius + 1) * (p.radius + 1));
    const auto across = static_cast<float>((y - c.y) * (y - c.y));
    for (int i = 0; i < n; ++i) {
        const auto along = static_cast<float>(c.x0 + i - c.x);
        const float inside = std::max(0.0F, 1 - 0.5F * (along * along + across) / reach);
        near[i] = inside * inside;
        const float fall = std::max(0.0F, 1 - 0.25F * d[i]); // exp(-d), and nothing beyond 4
        weight[i] = near[i] * fall * fall * fall * fall * trust[i];
    }
}

/// A row of a window as columns of regressors, relative to the centre; `stride` between columns.
[[gnu::always_inline]] inline void regressorLoop(const Planes &p, const Centre &c, int y, float *out, std::size_t stride) {
    const std::size_t own = p.at(c.x, c.y);
    const std::size_t row = p.at(c.x0, y);
    const int n = c.x1 - c.x0;
    const float unit = 1 / static_cast<float>(p.radius);
    const float v = static_cast<float>(y - c.y) * unit;
    for (int i = 0; i < n; ++i) {
        out[i] = 1;
        out[stride + static_cast<std::size_t>(i)] = static_cast<float>(c.x0 + i - c.x) * unit;
        out[2 * stride + static_cast<std::size_t>(i)] = v;
    }
    for (int k = 0; k < kLinear - 3; ++k) {
        const float *f = p.regressors[k] + row;
        const float at = p.regressors[k][own];
        float *to = out + static_cast<std::size_t>(3 + k) * stride;
        for (int i = 0; i < n; ++i) to[i] = f[i] - at;
    }
    if (!p.curved) return;
    float *to = out + static_cast<std::size_t>(kLinear) * stride;
    const float *u = out + stride;
    for (int i = 0; i < n; ++i) {
        to[i] = u[i] * u[i];
        to[stride + static_cast<std::size_t>(i)] = u[i] * v;
        to[2 * stride + static_cast<std::size_t>(i)] = v * v;
    }
}

/// Weighted products of columns: out[i][j] for regressors i and columns j >= i. `n`: a multiple of kLanes.
[[gnu::always_inline]] inline void productLoop(const float *columns, std::size_t n, const float *weight, int regressors, int all,
                                               float *out) {
    alignas(64) float weighted[kMostPixels];
    for (int i = 0; i < regressors; ++i) {
        const float *a = columns + static_cast<std::size_t>(i) * n;
        for (std::size_t k = 0; k < n; ++k) weighted[k] = weight[k] * a[k];
        for (int j = i; j < all; ++j) {
            const float *b = columns + static_cast<std::size_t>(j) * n;
            alignas(64) float sums[kLanes] = {};
            for (std::size_t k = 0; k < n; k += kLanes)
                for (int l = 0; l < kLanes; ++l) sums[l] += weighted[k + static_cast<std::size_t>(l)] * b[k + static_cast<std::size_t>(l)];
            float sum = 0;
            for (const float s : sums) sum += s;
            out[i * kColumns + j] = sum;
        }
    }
}

/// Adds a row of a window's predictions.
[[gnu::always_inline]] inline void predictLoop(const float *columns, std::size_t stride, int n, const float *weight, int regressors,
                                               const float *fit, float *const *sums) {
    for (int t = 0; t < kTargets; ++t) {
        float value[kMostWidth];
        for (int i = 0; i < n; ++i) value[i] = 0;
        for (int k = 0; k < regressors; ++k) {
            const float slope = fit[k * kTargets + t];
            const float *x = columns + static_cast<std::size_t>(k) * stride;
            for (int i = 0; i < n; ++i) value[i] += slope * x[i];
        }
        for (int i = 0; i < n; ++i) sums[t][i] += weight[i] * std::max(0.0F, value[i]);
    }
}

} // namespace taut::regression
