#pragma once
/// Several lights are weighed against each other at a hit by what each would bring unoccluded, and one is asked for by a shadow ray:
/// resampled importance sampling (Talbot, Cline and Egbert 2005). The candidates come from equal parts of the choice, as from the
/// clusters of a tree that is split. Each is weighed against scattered rays as a lone sample is, by the density of one, which every hit
/// can tell: so both ends of multiple importance sampling agree, and the mean is that of one candidate.

#include "taut/render/lights.h"

namespace taut {

/// Where a tree chooses, whose bounds know little of a light; few lights are weighed one by one as it is.
inline int candidateCount(const LightTable &table) {
    return table.few ? 1 : 2;
}

/// What candidate `k` of `count` is drawn with, each uniform: xy where on the light, z which. `u` in [0, 1)^3.
inline Vec3 candidateNumbers(const Vec3 &u, int k, int count) {
    if (count == 1) return u;
    // A rank-1 lattice of two dimensions (Roberts 2018), shifted.
    const auto shifted = [k](float x, float step) {
        const float at = x + step * static_cast<float>(k);
        return std::min(at - std::floor(at), kOneMinusEpsilon);
    };
    return {shifted(u.x, 0.7548777F), shifted(u.y, 0.5698403F),
            std::min((static_cast<float>(k) + u.z) / static_cast<float>(count), kOneMinusEpsilon)};
}

/// Keeps one of the candidates that it is shown, with a probability in proportion to its weight.
struct CandidateChoice {
    float number = 0; ///< uniform in [0, 1), what is left of it uniform again
    float sum = 0;
    float kept = 0; ///< weight of the one that is kept

    /// Whether a candidate takes the place of the one before.
    bool takes(float weight) {
        sum += weight;
        const float chance = weight / sum;
        if (!(chance > 0)) return false;
        if (number < chance) {
            number /= chance;
            kept = weight;
            return true;
        }
        number = (number - chance) / (1 - chance);
        return false;
    }
    /// What the contribution of the one that is kept is multiplied by, for the mean of all `count`.
    [[nodiscard]] float scale(int count) const { return sum / (kept * static_cast<float>(count)); }
};

} // namespace taut
