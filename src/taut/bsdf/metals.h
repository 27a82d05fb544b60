#pragma once
/// Complex indices of refraction of metals, measured, at three wavelengths.

#include "taut/base/vec.h"

#include <span>
#include <string_view>

namespace taut {

/// Index n + i k at 650, 550 and 450 nm (red, green, blue).
struct Metal {
    std::string_view name; ///< chemical symbol
    Vec3 eta;              ///< n
    Vec3 k;
};

/// Au Ag Cu Fe Ti Cr: Johnson & Christy, Phys. Rev. B 6, 4370 (1972) and 9, 5056 (1974). Al: Rakic, Appl. Opt. 34, 4755 (1995).
/// Linear in wavelength between the measured points.
std::span<const Metal> metals();

} // namespace taut
