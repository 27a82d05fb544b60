#pragma once
/// A mesh that carries its own M (Mesh::storedM): what the deformation makes of it. M' = A M / lambda, the stored M in the place
/// of a material's M0.

#include "taut/base/frame.h"
#include "taut/deform/stretch.h"
#include "taut/deform/surface_motion.h"
#include "taut/microsurface/transform.h"

namespace taut {

/// Images of the columns of M's 2x2 block in the space of ds and dt, over lambda. The left stretch tensor of the map onto them is
/// sqrt(M M^T): M itself as far as D can tell.
struct StoredColumns {
    Vec3 x{0}, y{0};
};

inline bool hasStoredGloss(const Mesh &mesh, const Surface &surface) {
    return !mesh.storedM.empty() && !surface.vertexTangents.empty();
}

/// For render vertex `v` with the gradient ds, dt and the normal n. `follow` false: carried along rigidly with the deformed tangent.
inline StoredColumns storedColumns(const Mesh &mesh, const Surface &surface, std::size_t v, const Vec3 &ds, const Vec3 &dt, const Vec3 &n,
                                   bool follow, float poisson) {
    const Index tangent = surface.vertexTangents[v];
    const Vec3 m = tangent == kNone ? Vec3(10, 0, 10) : mesh.storedM[tangent]; // a corner that lacks it: alpha 0.1
    const Vec4 &k = surface.tangentCoefficients[v];
    const float restSide = k.x * k.w - k.y * k.z < 0 ? -1.0F : 1.0F; // b0 = restSide cross(n, t0)
    Vec3 s = ds;
    Vec3 t = dt * restSide; // image of cross(n, t0)
    const float signedArea = glm::dot(glm::cross(s, t), n);
    float scale = 1;
    if (!follow) {
        const float length = glm::length(s);
        s = length > 0 ? s / length : smoothFrameFromNormal(n).s;
        t = glm::cross(n, s) * (signedArea < 0 ? -1.0F : 1.0F);
    } else if (poisson != 0) {
        scale = 1 / normalStretch(std::fmax(std::fabs(signedArea), 1e-12F), poisson);
    }
    return {s * (m.x * scale), (s * m.y + t * m.z) * scale};
}

/// M of a hit, where `root` is ss, st, tt of sqrt(M M^T) in the shading frame.
inline MicroTransform storedTransform(const Vec3 &root) {
    return microTransform(root.x, root.y, root.y, root.z);
}

} // namespace taut
