#pragma once
/// Hinges of a skin: vertices from which more than kHingeJump of the weights go over to other joints at the next vertex, as on the
/// leaves of a door. Weights have no derivative to speak of there, and the product rule would find stretch where every face moves
/// rigidly. Such a vertex keeps its stencil and ring, and asks the faces around it.

#include "taut/deform/surface.h"

namespace taut {

inline constexpr float kHingeJump = 0.4F;

inline bool isHinge(const Surface &surface, std::size_t s) {
    return !surface.hinges.empty() && surface.hinges[s] != 0;
}

/// Marks them.
void findHinges(const SkinWeights &skin, Surface &surface);

/// Drops the stencils and rings of all vertices but hinges.
void keepHinges(Surface &surface);

} // namespace taut
