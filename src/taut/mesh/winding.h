#pragma once
/// Normals of a file against the order of its faces' corners. Which side of a face is outside is said twice, and files disagree with
/// themselves: shapes that were mirrored by hand, scans, normals kept while faces were turned.

#include "taut/mesh/mesh.h"

#include <vector>

namespace taut {

/// Policy NormalsFollowWinding: [corners] 1 where the corner's own normal points to the inner side of its face, which the winding names,
/// and has to be turned; empty where none does. A smooth normal may lean past a face that folds away sharply: a corner counts where the
/// mean of the faces around its position agrees, or where all normals of its face point inward.
std::vector<unsigned char> cornersAgainstWinding(const Mesh &mesh);

/// How many of the mesh's normals are so at some corner.
std::size_t normalsAgainstWinding(const Mesh &mesh);

} // namespace taut
