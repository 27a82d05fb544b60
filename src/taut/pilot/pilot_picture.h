#pragma once
/// What a choice of the plan does to the picture, found out on a small part of it: windows spread over the frame, each pixel as it will be in
/// the picture, rendered under both choices with the same random numbers.

#include "taut/render/render_windows.h"

#include <vector>

namespace taut {

/// Side of the windows, pixels.
inline constexpr int kPilotWindow = 8;

/// Windows of a frame's own grid: about `count` of them, one at a random place in each of as many equal parts of the frame; all of the
/// frame where it is small.
std::vector<Window> pilotWindows(int width, int height, int count, std::uint32_t seed);

/// The windows with two sets of random numbers that know nothing of each other.
struct PilotPicture {
    RenderedWindows first, second;

    [[nodiscard]] double rays() const { return static_cast<double>(first.counts.rays() + second.counts.rays()); }
};

/// `settings.samples` for each of the two; the scene stands at its frame.
PilotPicture renderPilot(const RenderScene &scene, const std::vector<Window> &windows, const WindowSettings &settings);

/// An estimate with its standard error.
struct Estimate {
    double value = 0, spread = 0;
};

/// Square of the relative RMS difference that two models make to the picture. Noise cancels: with differences d1, d2 by the two sets of
/// random numbers, E d1 d2 = (E d)^2. May come out below zero where there is none.
Estimate squaredDifference(const PilotPicture &model, const PilotPicture &reference);

/// Square of the relative RMS noise of a picture of as many samples as each of the two has: E (I1 - I2)^2 / 2.
Estimate squaredNoise(const PilotPicture &picture);

} // namespace taut
