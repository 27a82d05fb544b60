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

constexpr int kBand = 32; ///< rows of the picture that one task adds up
/// Keeps regressors that do not vary in a window out of its matrix.
constexpr double kRidge = 1e-4;
/// A pixel that its windows resemble less than this gets its own.
constexpr float kLeastLikeness = 0.08F;

#define TAUT_REGRESSION_LOOPS(NAME, ...)                                                                                                   \
    struct NAME {                                                                                                                          \
        [[gnu::flatten __VA_ARGS__]] static void weigh(const Planes &p, const Centre &c, int y, float *w, float *near) {                   \
            weightLoop(p, c, y, w, near);                                                                                                  \
        }                                                                                                                                  \
        [[gnu::flatten __VA_ARGS__]] static void fill(const Planes &p, const Centre &c, int y, float *out, std::size_t stride) {           \
            regressorLoop(p, c, y, out, stride);                                                                                           \
        }                                                                                                                                  \
        [[gnu::flatten __VA_ARGS__]] static void multiply(const float *columns, std::size_t n, const float *w, int r, int all,             \
                                                          float *out) {                                                                    \
            productLoop(columns, n, w, r, all, out);                                                                                       \
        }                                                                                                                                  \
        [[gnu::flatten __VA_ARGS__]] static void predict(const float *columns, std::size_t stride, int n, const float *w, int r,           \
                                                         const float *fit, float *const *sums) {                                           \
            predictLoop(columns, stride, n, w, r, fit, sums);                                                                              \
        }                                                                                                                                  \
    };
TAUT_FOR_INSTRUCTION_SETS(TAUT_REGRESSION_LOOPS)

/// A window's columns and weights, contiguous.
struct alignas(64) Columns {
    float columns[static_cast<std::size_t>(kColumns) * kMostPixels];
    float weight[kMostPixels];
    float masked[kMostPixels];
};

/// Solves the normal equations by Cholesky's decomposition for some targets. Zeros where the window has nothing.
void solve(const float *products, int regressors, const double *ridge, int firstTarget, int lastTarget, float *fit) {
    double l[kMostRegressors][kMostRegressors];
    const double all = static_cast<double>(products[0]);
    for (int i = 0; i < regressors; ++i)
        for (int t = firstTarget; t < lastTarget; ++t) fit[i * kTargets + t] = 0;
    if (!(all > 0)) return;
    for (int i = 0; i < regressors; ++i)
        for (int j = 0; j <= i; ++j) {
            double sum = static_cast<double>(products[j * kColumns + i]);
            if (i == j) sum += all * ridge[i];
            for (int k = 0; k < j; ++k) sum -= l[i][k] * l[j][k];
            l[i][j] = i == j ? std::sqrt(std::max(sum, 1e-12 * all)) : sum / l[j][j];
        }
    for (int t = firstTarget; t < lastTarget; ++t) {
        double y[kMostRegressors];
        for (int i = 0; i < regressors; ++i) {
            double sum = static_cast<double>(products[i * kColumns + regressors + t]);
            for (int k = 0; k < i; ++k) sum -= l[i][k] * y[k];
            y[i] = sum / l[i][i];
        }
        for (int i = regressors - 1; i >= 0; --i) {
            double sum = y[i];
            for (int k = i + 1; k < regressors; ++k) sum -= l[k][i] * y[k];
            y[i] = sum / l[i][i];
            fit[i * kTargets + t] = static_cast<float>(y[i]);
        }
    }
}

/// Ridges of the regressors of a window: what their noise adds to their squares, at its centre.
void ridgesAt(const DenoisePixels &pixels, std::size_t own, double *ridge) {
    std::fill_n(ridge, kMostRegressors, kRidge);
    ridge[0] = 0;
    for (int k = 3; k < 9; ++k) ridge[k] += static_cast<double>(pixels.featureNoise[k < 6 ? 0 : 1][own]);
}

/// What a window predicts: fit[regressors][kTargets].
template <class Loops> void fitWindow(const DenoisePixels &pixels, const Planes &p, const Centre &c, Columns &window, float *fit) {
    const int width = c.x1 - c.x0;
    const int count = width * (c.y1 - c.y0);
    const auto padded = static_cast<std::size_t>((count + kLanes - 1) / kLanes * kLanes);
    const int regressors = p.count();
    const int all = regressors + kTargets;
    float near[kMostWidth];
    for (int y = c.y0; y < c.y1; ++y) {
        const auto first = static_cast<std::size_t>((y - c.y0) * width);
        Loops::weigh(p, c, y, window.weight + first, near);
        Loops::fill(p, c, y, window.columns + first, padded);
        for (int t = 0; t < kTargets; ++t)
            std::copy_n(p.targets[t] + p.at(c.x0, y), width, window.columns + static_cast<std::size_t>(regressors + t) * padded + first);
    }
    for (std::size_t i = static_cast<std::size_t>(count); i < padded; ++i) {
        window.weight[i] = 0;
        for (int k = 0; k < all; ++k) window.columns[static_cast<std::size_t>(k) * padded + i] = 0;
    }
    double ridge[kMostRegressors];
    ridgesAt(pixels, p.at(c.x, c.y), ridge);
    float products[kMostRegressors * kColumns];
    if (pixels.halves) {
        Loops::multiply(window.columns, padded, window.weight, regressors, all, products);
        solve(products, regressors, ridge, 0, kTargets, fit);
        return;
    }
    for (int half = 0; half < 2; ++half) { // each from the pixels that it has
        std::copy_n(window.weight, padded, window.masked);
        for (int y = c.y0; y < c.y1; ++y)
            for (int x = c.x0; x < c.x1; ++x) window.masked[(y - c.y0) * width + x - c.x0] *= pixels.share[half][p.at(x, y)];
        Loops::multiply(window.columns, padded, window.masked, regressors, all, products);
        solve(products, regressors, ridge, 3 * half, 3 * half + 3, fit);
    }
}

/// Where there is noise: windows without any have nothing to predict, and their pixels are what they are.
class NoiseMap {
  public:
    explicit NoiseMap(const DenoisePixels &pixels) : width_(static_cast<std::size_t>(pixels.width) + 1) {
        counts_.assign(width_ * (static_cast<std::size_t>(pixels.height) + 1), 0);
        for (std::size_t y = 0, i = 0; y < static_cast<std::size_t>(pixels.height); ++y)
            for (std::size_t x = 0, row = 0; x + 1 < width_; ++x, ++i) {
                row += pixels.variance[0][i] + pixels.variance[1][i] + pixels.variance[2][i] > 0 ? 1 : 0;
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

/// Adds what the windows predict for a band of rows, in the order of the windows.
template <class Loops>
void addBand(const Planes &p, const Grid &grid, const NoiseMap &noise, const std::vector<float> &fits, int first, int last, Regressed &out,
             Plane &likeness) {
    const int regressors = p.count();
    const auto fitSize = static_cast<std::size_t>(regressors * kTargets);
    float columns[kMostRegressors * kMostWidth];
    float weight[kMostWidth];
    float near[kMostWidth];
    Plane nearby(static_cast<std::size_t>((last - first) * p.width), 0.0F);
    for (int row = 0; row < grid.rows; ++row)
        for (int column = 0; column < grid.columns; ++column) {
            const Centre c = grid.centre(p, column, row);
            if (c.y1 <= first || c.y0 >= last || noise.isQuiet(c)) continue;
            const float *fit =
                &fits[(static_cast<std::size_t>(row) * static_cast<std::size_t>(grid.columns) + static_cast<std::size_t>(column)) *
                      fitSize];
            const int n = c.x1 - c.x0;
            for (int y = std::max(first, c.y0); y < std::min(last, c.y1); ++y) {
                Loops::weigh(p, c, y, weight, near);
                Loops::fill(p, c, y, columns, kMostWidth);
                const std::size_t at = p.at(c.x0, y);
                float *sums[kTargets];
                for (std::size_t t = 0; t < kTargets; ++t) sums[t] = &out.half[t / 3][t % 3][at];
                Loops::predict(columns, kMostWidth, n, weight, regressors, fit, sums);
                float *like = &likeness[at];
                float *close = &nearby[static_cast<std::size_t>((y - first) * p.width + c.x0)];
                for (int i = 0; i < n; ++i) {
                    like[i] += weight[i];
                    close[i] += near[i];
                }
            }
        }
    for (int y = first; y < last; ++y)
        for (int x = 0; x < p.width; ++x) {
            const std::size_t i = p.at(x, y);
            const float sum = likeness[i];
            for (ColourPlanes &half : out.half)
                for (Plane &plane : half) plane[i] = sum > 0 ? plane[i] / sum : 0;
            const float close = nearby[static_cast<std::size_t>((y - first) * p.width + x)];
            likeness[i] = close > 0 ? sum / close : 0;
            out.known[i] = likeness[i] >= kLeastLikeness ? 1.0F : 0.0F;
        }
}

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
        p.soft[k] = soft[k]->data();
        p.softScale[k] = inverse(differences[k]);
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
    return p;
}

template <class Loops> void run(const DenoisePixels &pixels, const RegressionScale &scale, const Planes &p, Regressed &out) {
    const Grid grid(p, std::max(1, scale.stride));
    const NoiseMap noise(pixels);
    const auto fitSize = static_cast<std::size_t>(p.count() * kTargets);
    std::vector<float> fits(static_cast<std::size_t>(grid.columns) * static_cast<std::size_t>(grid.rows) * fitSize);
    parallelFor(static_cast<std::size_t>(grid.rows), 1, [&](std::size_t row) {
        const auto window = std::make_unique<Columns>();
        for (int column = 0; column < grid.columns; ++column) {
            const Centre c = grid.centre(p, column, static_cast<int>(row));
            if (noise.isQuiet(c)) continue;
            fitWindow<Loops>(pixels, p, c, *window,
                             &fits[(row * static_cast<std::size_t>(grid.columns) + static_cast<std::size_t>(column)) * fitSize]);
        }
    });
    Plane likeness(out.known.size(), 0.0F);
    parallelFor(static_cast<std::size_t>((p.height + kBand - 1) / kBand), 1, [&](std::size_t band) {
        const int first = static_cast<int>(band) * kBand;
        addBand<Loops>(p, grid, noise, fits, first, std::min(first + kBand, p.height), out, likeness);
    });
    if (!scale.lonely) return;
    parallelFor(static_cast<std::size_t>(p.height), 1, [&](std::size_t row) {
        std::unique_ptr<Columns> window;
        float fit[kMostRegressors * kTargets];
        for (int x = 0; x < p.width; ++x) {
            const std::size_t i = p.at(x, static_cast<int>(row));
            if (out.known[i] != 0) continue;
            out.known[i] = 1;
            const Centre c = centreAt(p, x, static_cast<int>(row));
            if (noise.isQuiet(c)) {
                for (std::size_t t = 0; t < kTargets; ++t) out.half[t / 3][t % 3][i] = pixels.mean[t % 3][i];
                continue;
            }
            if (!window) window = std::make_unique<Columns>();
            fitWindow<Loops>(pixels, p, c, *window, fit);
            for (std::size_t t = 0; t < kTargets; ++t) out.half[t / 3][t % 3][i] = std::max(0.0F, fit[t]);
        }
    });
}

} // namespace

Regressed regress(const DenoisePixels &pixels, const RegressionScale &scale, const Guide *guide) {
    Regressed out;
    const std::size_t count = pixels.alpha.size();
    for (ColourPlanes &half : out.half)
        for (Plane &plane : half) plane.assign(count, 0);
    out.known.assign(count, 0);
    if (count == 0) return out;
    // How narrow lobes are, as a logarithm: where that differs, the highlight does.
    Plane sharpness(count);
    for (std::size_t i = 0; i < count; ++i)
        sharpness[i] = 0.5F * std::log(1 + pixels.gloss[0][i] + pixels.gloss[3][i] + pixels.gloss[5][i]);
    const Planes planes = planesOf(pixels, scale, guide, pixels.trust, sharpness);
    onInstructions(widest(), [&](auto loops) { run<decltype(loops)>(pixels, scale, planes, out); });
    return out;
}

} // namespace taut
