#pragma once
/// The random numbers of a path, by name: sets of the sample sequence of its pixel (base/sobol.h), each in an order of its own.
///
/// Numbers of one set stratify each other. So what the picture is a product of stands together: which light and where on it, and for the
/// first event the place within the pixel too; which lobe and which direction.

#include <cstdint>

namespace taut {

enum CameraDimension : std::uint32_t { kFilterDimension, kLensDimension, kCameraDimensions };
/// The time within the shutter has a number of its own, so that events keep theirs with and without motion blur.
inline constexpr std::uint32_t kTimeDimension = 0x30000000U;

/// Sets that every event draws: of scattering (direction and lobe), of a light (point and choice), of roulette.
enum EventDimension : std::uint32_t { kScatterNumbers, kLightNumbers, kRoulette, kPerEvent };
/// And those that only some scenes draw, far above: the others keep theirs.
enum RareDimension : std::uint32_t {
    kWalkFirst = 0x10000000,
    kWalkLast = 0x20000000,
    kSurfaces = 0x40000000,
    kCandidate = 0x50000000,
    kShadowSurfaces = 0x80000000
};

constexpr std::uint32_t dimensionOf(int event, EventDimension which) {
    return kCameraDimensions + static_cast<std::uint32_t>(event) * kPerEvent + which;
}
constexpr std::uint32_t dimensionOf(int event, RareDimension which) {
    return static_cast<std::uint32_t>(event) + which;
}

} // namespace taut
