#pragma once
/// How light that meets more than one facet is treated, and the choice where a material leaves it open.

#include "taut/microsurface/energy_compensation.h"

namespace taut {

enum class Multiscatter : std::uint8_t {
    Off,          ///< lost
    Compensation, ///< conductors: a closed lobe gives back what is lost (energy_compensation.h)
    Walk,         ///< conductors and dielectrics: the random walk (random_walk.h), exact and stochastic
    Auto
};

/// Share of diffuse light lost to single scattering below which nothing is done about it.
inline constexpr float kNegligibleLoss = 0.01F;

/// The cheapest treatment that keeps the loss below kNegligibleLoss. Rests on height-correlated masking.
inline Multiscatter chooseMultiscatter(const MicroTransform &m, bool transmits) {
    // At a roughness of 0.06 no M loses as much, which saves most hits the table.
    const float smallest = singularValues(m.a, m.b, 0, m.d).y;
    if (m.upright() && (smallest * 0.06F > 1 || 1 - energy::averageAlbedo(m) < kNegligibleLoss)) return Multiscatter::Off;
    return m.upright() && !transmits ? Multiscatter::Compensation : Multiscatter::Walk;
}

} // namespace taut
