#pragma once
/// Limit positions, tangents and normals of a refined cage: the part of subdivide() that talks to OpenSubdiv's limit masks.

#include "taut/mesh/subdivide.h"

#include <opensubdiv/far/topologyRefiner.h>

namespace taut {

/// Fills positions, tangents, and the refined mesh's positions, normals and cornerNormals; out.mesh has its faces already.
void makeLimitRows(const OpenSubdiv::Far::TopologyRefiner &refiner, SubdivisionScheme scheme, const std::vector<Vec3> &cage,
                   Subdivision &out);

} // namespace taut
