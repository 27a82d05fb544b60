#pragma once
/// Meshes made by formula, for benchmarks, tests and charts: exact normals, UVs that follow the parameters.

#include "taut/mesh/mesh.h"

namespace taut {

/// Torus about z: `around` x `across` quads, u along the big circle, v along the small one; closed, uvs in [0, 1].
Mesh makeTorus(int around, int across, float bigRadius, float smallRadius);

/// Sphere about the origin by longitude and latitude: u around z, v from the south to the north pole. Quads but for the
/// triangles at the poles.
Mesh makeSphere(int around, int across, float radius);

/// Square [-size/2, size/2]^2 in the plane z = 0, facing +z; u along x, v along y.
Mesh makeGrid(int nx, int ny, float size);

} // namespace taut
