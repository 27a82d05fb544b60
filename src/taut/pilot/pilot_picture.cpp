#include "taut/pilot/pilot_picture.h"

#include "taut/base/sobol.h"

#include <algorithm>
#include <cmath>

namespace taut {

namespace {

/// What the seed of the second picture is hashed with.
constexpr std::uint32_t kSecondSeed = 0x70110721;

/// Ratio of two sums over windows, with the standard error that windows which differ from it give (Cochran 1977, ratio estimator).
Estimate ratioOf(const std::vector<double> &values, const std::vector<double> &squares) {
    double sum = 0;
    double all = 0;
    for (std::size_t i = 0; i < values.size(); ++i) {
        sum += values[i];
        all += squares[i];
    }
    if (!(all > 0)) return {};
    const double ratio = sum / all;
    double residuals = 0;
    for (std::size_t i = 0; i < values.size(); ++i) residuals += sqr(values[i] - ratio * squares[i]);
    const auto count = static_cast<double>(values.size());
    return {ratio, count > 1 ? std::sqrt(residuals * count / (count - 1)) / all : 0};
}

template <class Value> std::vector<double> overWindows(const RenderedWindows &like, const Value &value) {
    std::vector<double> sums(like.means.size(), 0.0);
    for (std::size_t w = 0; w < sums.size(); ++w)
        for (std::size_t i = 0; i < like.means[w].size(); ++i) sums[w] += value(w, i);
    return sums;
}

/// Squares of the picture, free of noise.
std::vector<double> squaresOf(const PilotPicture &p) {
    return overWindows(p.first, [&](std::size_t w, std::size_t i) { return p.first.means[w][i] * p.second.means[w][i]; });
}

} // namespace

std::vector<Window> pilotWindows(int width, int height, int count, std::uint32_t seed) {
    const int columns = (width + kPilotWindow - 1) / kPilotWindow;
    const int rows = (height + kPilotWindow - 1) / kPilotWindow;
    const double cells = std::min(1.0, std::sqrt(static_cast<double>(count) / (static_cast<double>(columns) * rows)));
    const int across = std::clamp(static_cast<int>(std::lround(columns * cells)), 1, columns);
    const int down = std::clamp(static_cast<int>(std::lround(rows * cells)), 1, rows);
    std::vector<Window> windows;
    for (int j = 0; j < down; ++j)
        for (int i = 0; i < across; ++i) {
            const auto pick = [&](int from, int to, std::uint32_t salt) {
                const std::uint32_t random = hash(hash(seed, salt), static_cast<std::uint32_t>(j * across + i));
                return from + static_cast<int>(random % static_cast<std::uint32_t>(std::max(1, to - from)));
            };
            const int x = kPilotWindow * pick(i * columns / across, (i + 1) * columns / across, 1);
            const int y = kPilotWindow * pick(j * rows / down, (j + 1) * rows / down, 2);
            windows.push_back({x, y, std::min(x + kPilotWindow, width), std::min(y + kPilotWindow, height)});
        }
    return windows;
}

PilotPicture renderPilot(const RenderScene &scene, const std::vector<Window> &windows, const WindowSettings &settings) {
    WindowSettings other = settings;
    other.seed = hash(settings.seed, kSecondSeed);
    return {renderWindows(scene, windows, settings), renderWindows(scene, windows, other)};
}

Estimate squaredDifference(const PilotPicture &model, const PilotPicture &reference) {
    return ratioOf(overWindows(reference.first,
                               [&](std::size_t w, std::size_t i) {
                                   return (model.first.means[w][i] - reference.first.means[w][i]) *
                                          (model.second.means[w][i] - reference.second.means[w][i]);
                               }),
                   squaresOf(reference));
}

Estimate squaredNoise(const PilotPicture &picture) {
    return ratioOf(overWindows(picture.first,
                               [&](std::size_t w, std::size_t i) { return 0.5 * sqr(picture.first.means[w][i] - picture.second.means[w][i]); }),
                   squaresOf(picture));
}

} // namespace taut
