#pragma once
/// Hinges of a skin: vertices from which more than kHingeJump of the weights go over to other joints at the next vertex, as on the
/// leaves of a door. Weights have no derivative to speak of there, and the product rule would find stretch where every face moves
/// rigidly: such a vertex has no row of weight gradients, but keeps its stencil and ring, and takes its gradient from skinned positions.

#include "taut/deform/surface.h"

namespace taut {

inline constexpr float kHingeJump = 0.4F;

inline bool isHinge(const Surface &surface, std::size_t s) {
    return !surface.weightGradientOffsets.empty() && surface.weightGradientOffsets[s] == surface.weightGradientOffsets[s + 1] &&
           !surface.stencilOffsets.empty() && surface.stencilOffsets[s] != surface.stencilOffsets[s + 1];
}

/// The greatest share of its weights that a surface vertex loses to other joints at a neighbour; 0 on a limit surface, where stencils are
/// those of a cage.
float weightJump(const Surface &surface, const SkinWeights &skin, std::size_t s);

/// Drops the stencils and rings of all vertices but hinges.
void keepHinges(Surface &surface);

} // namespace taut
