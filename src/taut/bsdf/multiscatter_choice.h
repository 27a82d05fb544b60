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

/// The cheapest treatment that keeps the loss below `negligibleLoss`. Rests on height-correlated masking.
inline Multiscatter chooseMultiscatter(const MicroTransform &m, bool transmits, float negligibleLoss = kNegligibleLoss) {
    // At a roughness of 0.06 no M loses a hundredth, and less in proportion, which saves most hits the table.
    const float smallest = singularValues(m).y;
    if (m.upright() && (smallest * 0.06F * std::fmin(1.0F, negligibleLoss / 0.01F) > 1 || 1 - energy::averageAlbedo(m) < negligibleLoss))
        return Multiscatter::Off;
    return m.upright() && !transmits ? Multiscatter::Compensation : Multiscatter::Walk;
}

} // namespace taut
