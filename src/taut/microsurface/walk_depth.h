#pragma once
/// How deep light is on a walk over the microsurface, as a distribution instead of a number: heights are integrated out in closed form
/// (position-free, as in Bitterli & d'Eon 2022, "A Position-Free Path Integral for Homogeneous Slabs and Multiple Scattering on Smith
/// Microfacets"), whatever M is.
///
/// Depths (random_walk.h) are exponential: the first facet's is, with rate 1 + Lambda(wo), and so is the length of every flight, with
/// rate |Lambda(w)|. So a depth is a sum of independent exponentials, its phases, kept by their rates. A flight down adds a phase. A
/// flight up uses phases up from the last one: exponentials have no memory, so it stops in a phase of rate r with the chance
/// |Lambda| / (r + |Lambda|) and leaves what is left of that phase exponential with the rate r; else it goes on into the next.

#include "taut/microsurface/ggx.h"

#include <array>

namespace taut::walk {

/// A flight along w (unit, local): its rate is |Lambda(w)| = (L(w) - w.z) / (2 |w.z|), as a quotient that stays finite at grazing.
struct Flight {
    float area;   ///< L(w) - w.z = visibleArea(-w)
    float twiceZ; ///< 2 |w.z|
    bool up;

    Flight(const MicroTransform &m, const Vec3 &w) : area(ggx::visibleArea(m, -w, ggx::stretchedLength(m, w))), twiceZ(2 * std::fabs(w.z)), up(w.z > 0) {}
    [[nodiscard]] float rate() const { return area / std::fmax(twiceZ, 1e-18F); }
};

class DepthPhases {
  public:
    /// Phases that are kept; light that is deeper is lost. At alpha = 10 that is less than 1e-5 of it.
    static constexpr int kMost = 64;

    explicit DepthPhases(float firstRate) { rates_[0] = firstRate; }

    /// Chance to leave upwards along a direction of that Lambda: the mean of exp(-depth Lambda).
    [[nodiscard]] float escape(float lambda) const {
        float chance = 1;
        for (int k = 0; k < count_; ++k) chance *= passing(rates_[at(k)], lambda);
        return chance;
    }

    /// Chance that a flight ends at a facet from which light then leaves along a direction of that Lambda; over flight.area.
    [[nodiscard]] float stopThenEscape(const Flight &flight, float lambda) const {
        if (!flight.up) return escape(lambda) / (flight.area + flight.twiceZ * lambda);
        float sum = 0;
        float leaving = 1;
        for (int k = 0; k < count_; ++k) { // shallowest first; what stops there has passed all deeper ones
            const float rate = rates_[at(k)];
            const float share = 1 / (flight.area + flight.twiceZ * rate);
            leaving *= passing(rate, lambda);
            sum = sum * (flight.twiceZ * rate * share) + leaving * share;
        }
        return sum;
    }

    /// Makes the flight, on the condition that it ends inside: returns the chance of that. `u` in [0, 1) chooses the phase.
    float stop(const Flight &flight, float u) {
        if (!flight.up) {
            if (count_ == kMost) return 0;
            rates_[at(count_++)] = flight.rate();
            return 1;
        }
        float chance = 0;
        for (int k = 0; k < count_; ++k) {
            const float rate = rates_[at(k)];
            const float share = 1 / (flight.area + flight.twiceZ * rate);
            chance = chance * (flight.twiceZ * rate * share) + flight.area * share;
        }
        float rest = u * chance;
        for (; count_ > 1; --count_) {
            const float rate = rates_[at(count_ - 1)];
            const float here = flight.area / (flight.area + flight.twiceZ * rate);
            if (rest < here) break;
            rest = (rest - here) / (1 - here);
        }
        return chance;
    }

  private:
    static std::size_t at(int k) { return static_cast<std::size_t>(k); }
    static float passing(float rate, float lambda) { return rate / (rate + lambda); }

    std::array<float, kMost> rates_; ///< shallowest first
    int count_ = 1;
};

} // namespace taut::walk
