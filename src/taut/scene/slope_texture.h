#pragma once
/// Heights as slopes: what bump and height maps become when they are read.

#include "taut/scene/material.h"
#include "taut/scene/texture.h"

namespace taut {

/// s = -grad h of one channel, texel by texel, by central differences that wrap or stop as the texture does; x along u, y along v, upwards.
/// Bump: per width of the image, whose texels are square; Height: per unit of u and of v. Three channels, the last one 0.
Texture slopesFromHeights(const Texture &heights, int channel, SlopeMap::Kind kind);

/// Texels of a normal map that no facet can have: held at kSteepestSlope, from there on down.
std::size_t countTooSteep(const Texture &normals);

} // namespace taut
