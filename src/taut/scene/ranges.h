#pragma once
/// What the numbers of a scene may be: one set, for what reads scene files and for check().

#include "taut/deform/lattice.h"
#include "taut/mesh/subdivide.h"

#include <cstdint>
#include <string>

namespace taut {

/// Numbers allowed. The bounds at both ends count as inside unless `openLower`.
struct Range {
    double lower = -1e30; ///< the widest range still fits a float
    double upper = 1e30;
    bool openLower = false;
    [[nodiscard]] bool contains(double value) const { return (openLower ? value > lower : value >= lower) && value <= upper; }
};
inline constexpr Range kAnyNumber{};
inline constexpr Range kPositive{0, 1e30, true};
inline constexpr Range kNotNegative{0, 1e30};
inline constexpr Range kUnitInterval{0, 1};
inline constexpr Range kDegrees{-1e6, 1e6};

/// "a number in [0, 1]", "a number above 0".
std::string describe(const Range &range);

struct IntegerRange {
    std::int64_t lower, upper;
    [[nodiscard]] constexpr bool contains(std::int64_t value) const { return value >= lower && value <= upper; }
};
/// "an integer in [2, 16]".
std::string describe(const IntegerRange &range);

// --- materials -------------------------------------------------------------------------------------------------------
/// Of a rest alpha, whatever a texture says.
inline constexpr Range kAlpha{1e-4, 10};
inline constexpr auto kLeastAlpha = static_cast<float>(kAlpha.lower);
inline constexpr auto kMostAlpha = static_cast<float>(kAlpha.upper);
inline constexpr Range kIor{0.2, 10};
inline constexpr Range kFilmIor{1, 10};
inline constexpr Range kPoisson{-1, 0.5};

// --- how it is seen --------------------------------------------------------------------------------------------------
inline constexpr IntegerRange kImageSide{1, 32768};
inline constexpr IntegerRange kSpp{1, 1 << 24};
inline constexpr IntegerRange kMaxEvents{0, 4096};
inline constexpr IntegerRange kFrameNumber{-1'000'000'000, 1'000'000'000};
inline constexpr Range kFps{0, 1e6, true};
inline constexpr IntegerRange kSeed{0, 0xffffffff};
inline constexpr Range kShutter{0, 1000};
inline constexpr IntegerRange kMotionSteps{2, 128};
inline constexpr Range kStops{-50, 50};
inline constexpr Range kFieldOfView{0.01, 179}; ///< degrees
inline constexpr Range kConeAngle{0, 90};       ///< degrees

// --- meshes ----------------------------------------------------------------------------------------------------------
inline constexpr IntegerRange kSubdivisionLevel{0, kMaxSubdivisionLevel};
inline constexpr Range kCreaseAngle{0, 180}; ///< degrees
inline constexpr IntegerRange kLatticePoints{2, kMaxLatticePoints};
inline constexpr Range kTaper{-1, 1e30, true};

} // namespace taut
