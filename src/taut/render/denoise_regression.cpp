#include "taut/render/denoise_regression.h"

#include "taut/base/instructions.h"
#include "taut/base/parallel.h"
#include "taut/render/denoise_loops.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <span>

namespace taut {

namespace {

using namespace regression;

/// Keeps regressors that do not vary in a window out of its matrix.
constexpr float kRidge = 1e-4F;
/// A pixel that its windows resemble less than this gets its own.
constexpr float kLeastLikeness = 0.08F;

/// Columns of a window and products of sixteen.
struct Scratch {
    Lanes columns[kColumns][kMostRows];
    Lanes products[kMostRegressors][kColumns];
    Lanes fit[kMostRegressors][kTargets];
};
/// What a window predicts.
struct Fit {
    float of[kMostRegressors][kTargets];
};

#define TAUT_REGRESSION_LOOPS(NAME, ...)                                                                                                   \
    struct NAME {                                                                                                                          \
        [[gnu::flatten __VA_ARGS__]] static void multiply(const Planes &p, const Centre &c, int half, int lane, Scratch &s) {              \
            const int rows = columnLoop(p, c, half, s.columns);                                                                            \
            productLoop(s.columns, rows, p.count(), lane, s.products);                                                                     \
        }                                                                                                                                  \
        [[gnu::flatten __VA_ARGS__]] static void solve(int regressors, const Lanes *ridge, int first, int last, Scratch &s) {              \
            solveLoop(s.products, regressors, ridge, first, last, s.fit);                                                                  \
        }                                                                                                                                  \
        [[gnu::flatten __VA_ARGS__]] static void predict(const Planes &p, const Centre &c, const Fit &fit, float *const *sums) {           \
            predictLoop(p, c, fit.of, sums);                                                                                               \
        }                                                                                                                                  \
    };
TAUT_FOR_INSTRUCTION_SETS(TAUT_REGRESSION_LOOPS)

/// Ridges of the regressors of a window: what their noise adds to their squares, at its centre.
void ridgesAt(const DenoisePixels &pixels, std::size_t own, int lane, Lanes *ridge) {
    for (int k = 0; k < kMostRegressors; ++k) ridge[k][lane] = k == 0 ? 0 : kRidge;
    for (int k = 3; k < 9; ++k) ridge[k][lane] += pixels.featureNoise[k < 6 ? 0 : 1][own];
}

/// What windows predict, sixteen at most.
template <class Loops>
void fitWindows(const DenoisePixels &pixels, const Planes &p, std::span<const Centre> centres, Scratch &scratch, Fit *fits) {
    Lanes ridge[kMostRegressors] = {};
    for (std::size_t k = 0; k < centres.size(); ++k) ridgesAt(pixels, p.at(centres[k].x, centres[k].y), static_cast<int>(k), ridge);
    const int regressors = p.count();
    const auto solveFor = [&](int half, int first, int last) {
        for (auto &row : scratch.products) std::fill(row, row + kColumns, Lanes{});
        for (std::size_t k = 0; k < centres.size(); ++k) Loops::multiply(p, centres[k], half, static_cast<int>(k), scratch);
        Loops::solve(regressors, ridge, first, last, scratch);
    };
    if (pixels.halves) {
        solveFor(-1, 0, kTargets);
    } else { // each from the pixels that it has
        solveFor(0, 0, 3);
        solveFor(1, 3, kTargets);
    }
    for (std::size_t k = 0; k < centres.size(); ++k)
        for (int i = 0; i < regressors; ++i)
            for (int t = 0; t < kTargets; ++t) fits[k].of[i][t] = scratch.fit[i][t][k];
}

/// Where there is noise: windows without any have nothing to predict, and their pixels are what they are.
class NoiseMap {
  public:
    explicit NoiseMap(const DenoisePixels &pixels) : width_(static_cast<std::size_t>(pixels.width) + 1) {
        counts_.assign(width_ * (static_cast<std::size_t>(pixels.height) + 1), 0);
        for (std::size_t y = 0, i = 0; y < static_cast<std::size_t>(pixels.height); ++y)
            for (std::size_t x = 0, row = 0; x + 1 < width_; ++x, ++i) {
                row += pixels.variance[i] > 0 ? 1 : 0;
                counts_[(y + 1) * width_ + x + 1] = counts_[y * width_ + x + 1] + row;
            }
    }
    [[nodiscard]] bool isQuiet(const Centre &c) const { return at(c.x1, c.y1) + at(c.x0, c.y0) == at(c.x0, c.y1) + at(c.x1, c.y0); }

  private:
    std::size_t width_;
    std::vector<std::size_t> counts_; // [pixels above and to the left]
    [[nodiscard]] std::size_t at(int x, int y) const { return counts_[static_cast<std::size_t>(y) * width_ + static_cast<std::size_t>(x)]; }
};

/// Windows on a grid.
struct Grid {
    Grid(const Planes &p, int stride_)
        : stride(stride_), columns((p.width + stride - 1) / stride), rows((p.height + stride - 1) / stride) {}
    int stride, columns, rows;
    [[nodiscard]] Centre centre(const Planes &p, int column, int row) const {
        return centreAt(p, std::min(stride / 2 + column * stride, p.width - 1), std::min(stride / 2 + row * stride, p.height - 1));
    }
};

Planes planesOf(const DenoisePixels &pixels, const RegressionScale &scale, const Guide *guide, const Plane &trust, const Plane &sharpness) {
    Planes p;
    p.width = pixels.width;
    p.height = pixels.height;
    p.radius = std::min(scale.radius, kMostRadius);
    p.curved = scale.curved;
    const auto inverse = [](float difference) { return difference > 0 ? 1 / (difference * difference) : 0.0F; };
    const Plane *soft[kSoft] = {&pixels.normal[0],  &pixels.normal[1],  &pixels.normal[2], &pixels.albedo[0],
                                &pixels.albedo[1],  &pixels.albedo[2],  &pixels.alpha,     &pixels.depth,
                                &pixels.stretch[0], &pixels.stretch[1], &sharpness};
    const float differences[kSoft] = {scale.normal,
                                      scale.normal,
                                      scale.normal,
                                      scale.albedo,
                                      scale.albedo,
                                      scale.albedo,
                                      scale.alpha,
                                      scale.depth,
                                      scale.stretch,
                                      scale.stretch,
                                      scale.gloss > 0 ? 1.0F : 0.0F};
    for (int k = 0; k < kSoft; ++k) {
        if (!(differences[k] > 0)) continue;
        p.soft[p.softs] = soft[k]->data();
        p.softScale[p.softs++] = inverse(differences[k]);
    }
    for (std::size_t k = 0; k < 3; ++k) p.halfway[k] = pixels.halfway[k].data();
    for (std::size_t k = 0; k < 6; ++k) p.gloss[k] = pixels.gloss[k].data();
    p.glossScale = inverse(scale.gloss);
    if (guide != nullptr) {
        for (std::size_t k = 0; k < 3; ++k) p.guide[k] = guide->colour[k].data();
        p.guideVariance = guide->variance.data();
        p.guideScale = inverse(scale.guide);
    }
    p.trust = trust.data();
    for (std::size_t k = 0; k < 3; ++k) {
        p.regressors[k] = pixels.normal[k].data();
        p.regressors[3 + k] = pixels.albedo[k].data();
    }
    p.regressors[6] = pixels.alpha.data();
    for (std::size_t t = 0; t < kTargets; ++t) p.targets[t] = pixels.half[t / 3][t % 3].data();
    for (std::size_t half = 0; half < 2; ++half) p.share[half] = pixels.share[half].data();
    return p;
}

/// Where predictions are added up: colours of both halves, weights, weights for the place alone.
struct Sums {
    float *of[kTargets + 2];
};

/// A row of windows, sixteen by sixteen; those that stand where there is no noise are left out.
template <class Loops>
void addWindows(const DenoisePixels &pixels, const Planes &p, const Grid &grid, const NoiseMap &noise, int row, Scratch &scratch,
                const Sums &sums) {
    Centre centres[kLanes];
    Fit fits[kLanes];
    std::size_t count = 0;
    for (int column = 0; column < grid.columns; ++column) {
        const Centre c = grid.centre(p, column, row);
        if (!noise.isQuiet(c)) centres[count++] = c;
        if (count == 0 || (count < kLanes && column + 1 < grid.columns)) continue;
        fitWindows<Loops>(pixels, p, {centres, count}, scratch, fits);
        for (std::size_t k = 0; k < count; ++k) Loops::predict(p, centres[k], fits[k], sums.of);
        count = 0;
    }
}

/// From sums to means; pixels that no window resembles are not known, but by windows of their own where `lonely`.
template <class Loops>
void finishRow(const DenoisePixels &pixels, const Planes &p, const NoiseMap &noise, int y, bool lonely, const float *likeness,
               const float *nearby, Scratch &scratch, Regressed &out) {
    Centre centres[kLanes];
    Fit fits[kLanes];
    std::size_t count = 0;
    const auto finish = [&] {
        fitWindows<Loops>(pixels, p, {centres, count}, scratch, fits);
        for (std::size_t k = 0; k < count; ++k)
            for (std::size_t t = 0; t < kTargets; ++t) out.half[t / 3][t % 3][p.at(centres[k].x, y)] = std::max(0.0F, fits[k].of[0][t]);
        count = 0;
    };
    for (int x = 0; x < p.width; ++x) {
        const std::size_t i = p.at(x, y);
        const float sum = likeness[i];
        const bool known = nearby[i] > 0 && sum >= kLeastLikeness * nearby[i];
        out.known[i] = known || lonely ? 1.0F : 0.0F;
        for (ColourPlanes &half : out.half)
            for (Plane &plane : half) plane[i] = sum > 0 ? plane[i] / sum : 0;
        if (known || !lonely) continue;
        const Centre c = centreAt(p, x, y);
        if (noise.isQuiet(c))
            for (std::size_t t = 0; t < kTargets; ++t) out.half[t / 3][t % 3][i] = pixels.mean[t % 3][i];
        else
            centres[count++] = c;
        if (count == kLanes) finish();
    }
    if (count > 0) finish();
}

/// Rows of windows that do not overlap are added at the same time, then those between them: each pixel's sum has one order.
template <class Loops> void run(const DenoisePixels &pixels, const RegressionScale &scale, const Planes &p, Regressed &out) {
    const Grid grid(p, std::max(1, scale.stride));
    const NoiseMap noise(pixels);
    Plane likeness(pixels.stored(), 0.0F);
    Plane nearby(pixels.stored(), 0.0F);
    Sums sums;
    for (std::size_t t = 0; t < kTargets; ++t) sums.of[t] = out.half[t / 3][t % 3].data();
    sums.of[kTargets] = likeness.data();
    sums.of[kTargets + 1] = nearby.data();
    const int apart = (2 * p.radius + grid.stride) / grid.stride; // rows of windows so far apart have no pixel in common
    for (int first = 0; first < std::min(apart, grid.rows); ++first)
        parallelFor(static_cast<std::size_t>((grid.rows - first + apart - 1) / apart), 1, [&](std::size_t k) {
            const auto scratch = std::make_unique<Scratch>();
            addWindows<Loops>(pixels, p, grid, noise, first + static_cast<int>(k) * apart, *scratch, sums);
        });
    parallelFor(static_cast<std::size_t>(p.height), 8, [&](std::size_t y) {
        const auto scratch = std::make_unique<Scratch>();
        finishRow<Loops>(pixels, p, noise, static_cast<int>(y), scale.lonely, likeness.data(), nearby.data(), *scratch, out);
    });
}

} // namespace

Regressed regress(const DenoisePixels &pixels, const RegressionScale &scale, const Guide *guide) {
    Regressed out;
    if (pixels.count() == 0) return out;
    for (ColourPlanes &half : out.half)
        for (Plane &plane : half) plane.assign(pixels.stored(), 0);
    out.known.assign(pixels.count(), 0);
    // How narrow lobes are, as a logarithm: where that differs, the highlight does.
    Plane sharpness(pixels.stored());
    for (std::size_t i = 0; i < pixels.count(); ++i)
        sharpness[i] = 0.5F * std::log(1 + pixels.gloss[0][i] + pixels.gloss[3][i] + pixels.gloss[5][i]);
    const Planes planes = planesOf(pixels, scale, guide, pixels.trust, sharpness);
    onInstructions(widest(), [&](auto loops) { run<decltype(loops)>(pixels, scale, planes, out); });
    return out;
}

} // namespace taut
