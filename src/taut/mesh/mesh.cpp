#include "taut/mesh/mesh.h"

namespace taut {

void shrinkToFit(Mesh &mesh) {
    const auto shrink = [](auto &...arrays) { (arrays.shrink_to_fit(), ...); };
    shrink(mesh.positions, mesh.faceOffsets, mesh.cornerPositions, mesh.normals, mesh.cornerNormals, mesh.uvs, mesh.cornerUvs, mesh.uvs1,
           mesh.colors, mesh.cornerColors, mesh.tangents, mesh.cornerTangents, mesh.storedM, mesh.faceMaterials, mesh.skin.offsets,
           mesh.skin.joints, mesh.skin.weights);
    for (MorphTarget &morph : mesh.morphs) {
        morph.positionDeltas.shrink_to_fit();
        morph.normalDeltas.shrink_to_fit();
    }
}

Bounds boundsOf(const std::vector<Vec3> &points) {
    Bounds bounds;
    for (const Vec3 &p : points)
        if (isFinite(p)) bounds.add(p);
    return bounds;
}

} // namespace taut
