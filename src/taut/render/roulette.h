#pragma once
/// Russian roulette of paths.

#include "taut/base/vec.h"

namespace taut {

/// Throughput below which paths may end. What a path above it brings is too much to gamble with: ending paths at their throughput
/// (Arvo & Kirk 1990) made the variance of glass over a grey ground 3.3 times as large, to save an eighth of the time.
inline constexpr float kDimThroughput = 0.25F;

/// Chance that a path goes on, in [0, 1]; whoever goes on is worth 1 / chance. `etaScale` undoes the scaling of radiance within
/// dielectrics (BsdfSample).
inline float chanceToGoOn(const Vec3 &throughput, float etaScale) {
    const float chance = maxComponent(throughput) * etaScale * (1 / kDimThroughput);
    return chance < 1 ? chance : 1.0F;
}

} // namespace taut
