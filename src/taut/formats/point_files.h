#pragma once
/// Point sources from files: numbered sequences of meshes, and point caches.

#include "taut/deform/point_source.h"
#include "taut/mesh/mesh.h"

#include <string>

namespace taut {

/// The files of a pattern with #### or %0Nd whose numbers are `frames`, increasing and at least one; contiguous or not. Each is read
/// when it is first needed and must have the points and faces of `first`, else its reader throws InputError.
std::shared_ptr<const PointSource> sequencePoints(std::string pattern, std::vector<int> frames, std::shared_ptr<const Mesh> first);

/// A PC2 or MDD file (point_cache.h). Throws InputError where its header is malformed.
std::shared_ptr<const PointSource> cachePoints(const std::string &path);

} // namespace taut
