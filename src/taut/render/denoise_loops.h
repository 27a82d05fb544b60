#pragma once
/// The loops of denoise_regression.cpp, compiled for several sets of instructions (base/instructions.h): how much the pixels of a window
/// count, what is regressed on, products of columns, sixteen solutions at once, predictions. Internal.
///
/// Sixteen floats are a Lanes: rows of windows are read in them, from the window's left edge on, and what lies beyond the window counts
/// nothing. Sums over lanes are taken in one order, so that all instruction sets give the same bits.

#include "taut/render/denoise_pixels.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>

namespace taut::regression {

inline constexpr int kLanes = 16;
static_assert(kLanes <= kPlaneSlack);
typedef float Lanes __attribute__((vector_size(kLanes * sizeof(float))));
typedef int IntLanes __attribute__((vector_size(kLanes * sizeof(int))));

inline constexpr int kLinear = 10;         ///< 1, place, normal, albedo, coverage
inline constexpr int kMostRegressors = 13; ///< and squares of the place
inline constexpr int kTargets = 6;         ///< colours of both halves
inline constexpr int kColumns = kMostRegressors + kTargets;
inline constexpr int kMostRadius = 15;
inline constexpr int kMostVectors = (2 * kMostRadius + 1 + kLanes - 1) / kLanes; ///< of a row of a window
inline constexpr int kMostRows = kMostVectors * (2 * kMostRadius + 1);           ///< of a window, in lanes
inline constexpr int kSoft = 11;                                                 ///< planes whose differences make a pixel count less

/// All that the loops read.
struct Planes {
    int width = 0, height = 0;
    int softs = 0; ///< planes that are asked for
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
    const float *share[2] = {nullptr, nullptr}; ///< where halves have pixels of their own: how much of a pixel each has
    int radius = 0;
    bool curved = false;
    [[nodiscard]] int count() const { return curved ? kMostRegressors : kLinear; }
    [[nodiscard]] int vectors() const { return (2 * radius + 1 + kLanes - 1) / kLanes; }
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

#define TAUT_INLINE [[gnu::always_inline]] inline

TAUT_INLINE void load(Lanes &v, const float *from) {
    std::memcpy(&v, from, sizeof v);
}
TAUT_INLINE void store(float *to, const Lanes &v) {
    std::memcpy(to, &v, sizeof v);
}
/// Sums of pairs of lanes: the first half of each of `a`'s groups with the second, then those of `b`'s. Groups are of `kSize` lanes.
template <int kSize> TAUT_INLINE void fold(Lanes &a, const Lanes &b) {
    Lanes first;
    Lanes second;
    if constexpr (kSize == 16) {
        first = __builtin_shufflevector(a, b, 0, 1, 2, 3, 4, 5, 6, 7, 16, 17, 18, 19, 20, 21, 22, 23);
        second = __builtin_shufflevector(a, b, 8, 9, 10, 11, 12, 13, 14, 15, 24, 25, 26, 27, 28, 29, 30, 31);
    } else if constexpr (kSize == 8) {
        first = __builtin_shufflevector(a, b, 0, 1, 2, 3, 8, 9, 10, 11, 16, 17, 18, 19, 24, 25, 26, 27);
        second = __builtin_shufflevector(a, b, 4, 5, 6, 7, 12, 13, 14, 15, 20, 21, 22, 23, 28, 29, 30, 31);
    } else if constexpr (kSize == 4) {
        first = __builtin_shufflevector(a, b, 0, 1, 4, 5, 8, 9, 12, 13, 16, 17, 20, 21, 24, 25, 28, 29);
        second = __builtin_shufflevector(a, b, 2, 3, 6, 7, 10, 11, 14, 15, 18, 19, 22, 23, 26, 27, 30, 31);
    } else {
        first = __builtin_shufflevector(a, b, 0, 2, 4, 6, 8, 10, 12, 14, 16, 18, 20, 22, 24, 26, 28, 30);
        second = __builtin_shufflevector(a, b, 1, 3, 5, 7, 9, 11, 13, 15, 17, 19, 21, 23, 25, 27, 29, 31);
    }
    a = first + second;
}
/// Lane k of v[0] becomes the sum of v[k]'s lanes.
TAUT_INLINE void totalsOf(Lanes *v) {
    for (int k = 0; k < 8; ++k) {
        v[k] = v[2 * k];
        fold<16>(v[k], v[2 * k + 1]);
    }
    for (int k = 0; k < 4; ++k) {
        v[k] = v[2 * k];
        fold<8>(v[k], v[2 * k + 1]);
    }
    for (int k = 0; k < 2; ++k) {
        v[k] = v[2 * k];
        fold<4>(v[k], v[2 * k + 1]);
    }
    fold<2>(v[0], v[1]);
}
TAUT_INLINE void rootsOf(Lanes &v) {
    float s[kLanes];
    store(s, v);
    for (int l = 0; l < kLanes; ++l) s[l] = std::sqrt(s[l]);
    load(v, s);
}

/// Whether all are +0.
TAUT_INLINE bool isNothing(const Lanes &v) {
    std::uint64_t bits[sizeof v / 8];
    std::memcpy(bits, &v, sizeof v);
    std::uint64_t any = 0;
    for (const std::uint64_t b : bits) any |= b;
    return any == 0;
}

/// How much sixteen pixels of a row of a window count, the first of them at (x, y); `near`: for their place alone.
TAUT_INLINE void weightLoop(const Planes &p, const Centre &c, int x, int y, Lanes &weight, Lanes &near) {
    const std::size_t own = p.at(c.x, c.y);
    const std::size_t row = p.at(x, y);
    const Lanes zero = {};
    Lanes d = zero;
#pragma GCC unroll 1
    for (int k = 0; k < p.softs; ++k) {
        Lanes f;
        load(f, p.soft[k] + row);
        f -= p.soft[k][own];
        d += f * f * p.softScale[k];
    }
    if (p.glossScale > 0) {
        Lanes hX;
        Lanes hY;
        Lanes hZ;
        load(hX, p.halfway[0] + row);
        load(hY, p.halfway[1] + row);
        load(hZ, p.halfway[2] + row);
        hX -= p.halfway[0][own];
        hY -= p.halfway[1][own];
        hZ -= p.halfway[2][own];
        float g[6];
        for (int k = 0; k < 6; ++k) g[k] = p.gloss[k][own] * p.glossScale;
        d += g[0] * hX * hX + g[3] * hY * hY + g[5] * hZ * hZ + 2 * (g[1] * hX * hY + g[2] * hX * hZ + g[4] * hY * hZ);
    }
    if (p.guideScale > 0) {
        Lanes apart = zero;
        float light = 0;
        for (int k = 0; k < 3; ++k) {
            Lanes f;
            load(f, p.guide[k] + row);
            f -= p.guide[k][own];
            apart += f * f;
            light += p.guide[k][own] / 3;
        }
        Lanes v;
        load(v, p.guideVariance + row);
        const float v0 = p.guideVariance[own];
        const float floor = 1e-4F * light * light + 1e-12F;
        const Lanes least = v < v0 ? v : zero + v0;
        const Lanes beyond = apart / 3.0F - v0 - least;
        d += (beyond > zero ? beyond : zero) * p.guideScale / (v0 + v + floor);
    }
    constexpr IntLanes kPlace = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15};
    const IntLanes place = kPlace + x;
    const auto reach = static_cast<float>((p.radius + 1) * (p.radius + 1));
    const auto across = static_cast<float>((y - c.y) * (y - c.y));
    const Lanes along = __builtin_convertvector(place - c.x, Lanes);
    Lanes inside = 1 - 0.5F * (along * along + across) / reach;
    inside = inside > zero ? inside : zero;
    near = place < c.x1 ? inside * inside : zero;
    Lanes fall = 1 - 0.25F * d; // exp(-d), and nothing beyond 4
    fall = fall > zero ? fall : zero;
    fall *= fall;
    Lanes trust;
    load(trust, p.trust + row);
    weight = near * fall * fall * trust;
}

/// Regressors of sixteen pixels that come from planes, relative to the centre.
TAUT_INLINE void planeLoop(const Planes &p, std::size_t own, int k, std::size_t at, Lanes &out) {
    load(out, p.regressors[k] + at);
    out -= p.regressors[k][own];
}
/// Place across a window of sixteen pixels from x on, in units of its radius.
TAUT_INLINE void placeLoop(const Planes &p, const Centre &c, int x, Lanes &out) {
    constexpr IntLanes kPlace = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15};
    out = __builtin_convertvector(kPlace + (x - c.x), Lanes) * (1 / static_cast<float>(p.radius));
}

/// A window's columns, regressors and then targets, times the roots of the weights: [columns][kMostRows]. Returns the rows, in lanes; those
/// that count nothing are left out.
TAUT_INLINE int columnLoop(const Planes &p, const Centre &c, int half, Lanes (*columns)[kMostRows]) {
    const int regressors = p.count();
    const std::size_t own = p.at(c.x, c.y);
    int row = 0;
    for (int y = c.y0; y < c.y1; ++y)
        for (int x = c.x0; x < c.x1; x += kLanes) {
            const std::size_t at = p.at(x, y);
            Lanes root;
            Lanes near;
            weightLoop(p, c, x, y, root, near);
            if (half >= 0) {
                Lanes share;
                load(share, p.share[half] + at);
                root *= share;
            }
            if (isNothing(root)) continue;
            rootsOf(root);
            Lanes u;
            placeLoop(p, c, x, u);
            const float v = static_cast<float>(y - c.y) * (1 / static_cast<float>(p.radius));
            columns[0][row] = root;
            columns[1][row] = u * root;
            columns[2][row] = v * root;
            for (int k = 0; k < kLinear - 3; ++k) {
                Lanes f;
                planeLoop(p, own, k, at, f);
                columns[3 + k][row] = f * root;
            }
            if (p.curved) {
                columns[kLinear][row] = u * u * root;
                columns[kLinear + 1][row] = u * v * root;
                columns[kLinear + 2][row] = v * v * root;
            }
            for (int t = 0; t < kTargets; ++t) {
                Lanes f;
                load(f, p.targets[t] + at);
                columns[regressors + t][row] = f * root;
            }
            ++row;
        }
    return row;
}

/// Products of columns, for regressors i and columns j >= i: products[i][j][lane].
TAUT_INLINE void productLoop(Lanes (*columns)[kMostRows], int rows, int regressors, int lane, Lanes (*products)[kColumns]) {
    const int all = regressors + kTargets;
    Lanes sums[kLanes];
    float *to[kLanes];
    int count = 0;
    float none = 0;
    for (int i = 0; i < regressors; i += 2)
        for (int j = i; j < all; j += 4) {
            const Lanes *a0 = columns[i];
            const Lanes *a1 = columns[std::min(i + 1, all - 1)];
            const Lanes *b0 = columns[j];
            const Lanes *b1 = columns[std::min(j + 1, all - 1)];
            const Lanes *b2 = columns[std::min(j + 2, all - 1)];
            const Lanes *b3 = columns[std::min(j + 3, all - 1)];
            Lanes s00 = {}, s01 = {}, s02 = {}, s03 = {}, s10 = {}, s11 = {}, s12 = {}, s13 = {};
            for (int r = 0; r < rows; ++r) {
                const Lanes x0 = a0[r];
                const Lanes x1 = a1[r];
                const Lanes y0 = b0[r];
                const Lanes y1 = b1[r];
                const Lanes y2 = b2[r];
                const Lanes y3 = b3[r];
                s00 += x0 * y0;
                s01 += x0 * y1;
                s02 += x0 * y2;
                s03 += x0 * y3;
                s10 += x1 * y0;
                s11 += x1 * y1;
                s12 += x1 * y2;
                s13 += x1 * y3;
            }
            const Lanes eight[2][4] = {{s00, s01, s02, s03}, {s10, s11, s12, s13}};
            for (int k = 0; k < 2; ++k)
                for (int l = 0; l < 4; ++l, ++count) {
                    sums[count] = eight[k][l];
                    const bool wanted = i + k < regressors && j + l < all;
                    to[count] = wanted ? reinterpret_cast<float *>(&products[i + k][j + l]) + lane : &none;
                }
            if (count < kLanes && (i + 2 < regressors || j + 4 < all)) continue;
            totalsOf(sums);
            float totals[kLanes];
            store(totals, sums[0]);
            for (int k = 0; k < count; ++k) *to[k] = totals[k];
            count = 0;
        }
}

/// Solves the normal equations of sixteen windows by Cholesky's decomposition, for targets [first, last): fit[regressors][kTargets].
/// Zeros where a window has nothing.
TAUT_INLINE void solveLoop(const Lanes (*products)[kColumns], int regressors, const Lanes *ridge, int first, int last,
                           Lanes (*fit)[kTargets]) {
    Lanes l[kMostRegressors][kMostRegressors];
    Lanes inverse[kMostRegressors];
    const Lanes all = products[0][0];
    const Lanes floor = all * 1e-6F + 1e-30F;
    for (int j = 0; j < regressors; ++j) {
        Lanes sum = products[j][j] + all * ridge[j];
        for (int k = 0; k < j; ++k) sum -= l[j][k] * l[j][k];
        sum = sum > floor ? sum : floor;
        rootsOf(sum);
        inverse[j] = 1 / sum;
        for (int i = j + 1; i < regressors; ++i) {
            Lanes other = products[j][i];
            for (int k = 0; k < j; ++k) other -= l[i][k] * l[j][k];
            l[i][j] = other * inverse[j];
        }
    }
    for (int t = first; t < last; ++t) {
        Lanes y[kMostRegressors];
        for (int i = 0; i < regressors; ++i) {
            Lanes sum = products[i][regressors + t];
            for (int k = 0; k < i; ++k) sum -= l[i][k] * y[k];
            y[i] = sum * inverse[i];
        }
        for (int i = regressors - 1; i >= 0; --i) {
            Lanes sum = y[i];
            for (int k = i + 1; k < regressors; ++k) sum -= l[k][i] * y[k];
            y[i] = sum * inverse[i];
            fit[i][t] = y[i];
        }
    }
}

/// Adds a window's predictions: sums[t] of targets, then of weights, then of weights for the place alone.
TAUT_INLINE void predictLoop(const Planes &p, const Centre &c, const float (*fit)[kTargets], float *const *sums) {
    const std::size_t own = p.at(c.x, c.y);
    const Lanes zero = {};
    for (int y = c.y0; y < c.y1; ++y)
        for (int x = c.x0; x < c.x1; x += kLanes) {
            Lanes weight;
            Lanes near;
            weightLoop(p, c, x, y, weight, near);
            const std::size_t at = p.at(x, y);
            const int inside = std::min(kLanes, p.width - x);
            const auto addTo = [&](float *to, const Lanes &added) {
                if (inside == kLanes) {
                    Lanes sum;
                    load(sum, to);
                    store(to, sum + added);
                } else { // what lies beyond is the next row's
                    float values[kLanes];
                    store(values, added);
                    for (int l = 0; l < inside; ++l) to[l] += values[l];
                }
            };
            addTo(sums[kTargets + 1] + at, near);
            if (isNothing(weight)) continue;
            addTo(sums[kTargets] + at, weight);
            Lanes u;
            placeLoop(p, c, x, u);
            const float v = static_cast<float>(y - c.y) * (1 / static_cast<float>(p.radius));
            float base[kTargets];
            float slope[kTargets];
            for (int t = 0; t < kTargets; ++t) {
                base[t] = fit[0][t] + v * fit[2][t] + (p.curved ? v * v * fit[kLinear + 2][t] : 0);
                slope[t] = fit[1][t] + (p.curved ? v * fit[kLinear + 1][t] : 0);
            }
            Lanes v0 = base[0] + slope[0] * u;
            Lanes v1 = base[1] + slope[1] * u;
            Lanes v2 = base[2] + slope[2] * u;
            Lanes v3 = base[3] + slope[3] * u;
            Lanes v4 = base[4] + slope[4] * u;
            Lanes v5 = base[5] + slope[5] * u;
            const auto add = [&](const float *by, const Lanes &f) {
                v0 += by[0] * f;
                v1 += by[1] * f;
                v2 += by[2] * f;
                v3 += by[3] * f;
                v4 += by[4] * f;
                v5 += by[5] * f;
            };
            for (int k = 0; k < kLinear - 3; ++k) {
                Lanes f;
                planeLoop(p, own, k, at, f);
                add(fit[3 + k], f);
            }
            if (p.curved) add(fit[kLinear], u * u);
            const Lanes added[kTargets] = {v0, v1, v2, v3, v4, v5};
            for (int t = 0; t < kTargets; ++t) addTo(sums[t] + at, weight * (added[t] > zero ? added[t] : zero));
        }
}

#undef TAUT_INLINE

} // namespace taut::regression
