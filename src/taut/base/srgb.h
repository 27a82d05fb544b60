#pragma once
/// The transfer functions of sRGB (IEC 61966-2-1), piecewise.

#include <cmath>

namespace taut {

inline float linearFromSrgb(float s) {
    return s <= 0.04045F ? s / 12.92F : std::pow((s + 0.055F) / 1.055F, 2.4F);
}

/// Clamped to [0, 1].
inline float srgbFromLinear(float linear) {
    const float c = std::fmin(std::fmax(linear, 0.0F), 1.0F);
    return c <= 0.0031308F ? 12.92F * c : 1.055F * std::pow(c, 1 / 2.4F) - 0.055F;
}

} // namespace taut
