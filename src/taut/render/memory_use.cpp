#include "taut/render/memory_use.h"

#include <set>

namespace taut {

namespace {

template <class... Vectors> std::size_t bytesOf(const Vectors &...vectors) {
    return (std::size_t{0} + ... + (vectors.capacity() * sizeof(vectors[0])));
}

std::size_t bytesOf(const Mesh &mesh) {
    std::size_t bytes = bytesOf(mesh.positions, mesh.faceOffsets, mesh.cornerPositions, mesh.normals, mesh.cornerNormals, mesh.uvs,
                                mesh.cornerUvs, mesh.uvs1, mesh.colors, mesh.cornerColors, mesh.tangents, mesh.cornerTangents, mesh.storedM,
                                mesh.faceMaterials, mesh.skin.offsets, mesh.skin.joints, mesh.skin.weights);
    for (const MorphTarget &morph : mesh.morphs) bytes += bytesOf(morph.positionDeltas) + bytesOf(morph.normalDeltas);
    return bytes;
}

} // namespace

MemoryUse memoryUse(const RenderScene &scene) {
    MemoryUse use;
    use.embree = scene.embree().bytes();
    use.shown = scene.embree().pairBytes();
    std::set<const Mesh *> meshes;
    for (const RenderObject &object : scene.objects()) {
        const Surface &s = object.surface;
        use.triangles += s.triangles.size();
        use.vertices += s.vertexCount();
        use.shown += bytesOf(s.triangles, s.triangleSlots, s.uvs, s.uvs1, s.colors, object.storedPoisson, object.turned);
        for (const SurfaceStep &step : object.steps)
            use.shown += bytesOf(step.positions, step.normals, step.tangents, step.stretch, step.lean, step.ds, step.dt);
        use.motion += bytesOf(s.vertexSurface, s.vertexTangents, s.tangentCoefficients, s.surfacePosition, s.normals, s.stencilOffsets,
                              s.stencilPositions, s.stencilWeights, s.stencilPoints, s.slope, s.ringOffsets, s.ringFaces, s.ringTilts,
                              s.hinges, s.weightGradientOffsets, s.weightGradientJoints, s.weightGradients);
        const SurfaceGradient &g = object.gradient;
        use.motion +=
            bytesOf(g.position, g.f1, g.f2, g.normal, g.moved, g.points, g.normalImage, g.orientation.at, g.movedOrientation.at,
                    object.cageOrientation.at, object.motion.control, object.cage, object.refined, object.restTangents, object.metrics);
        use.motion += bytesOf(object.vertices.positions, object.vertices.normals, object.vertices.ds, object.vertices.dt);
        if (object.subdivision) {
            const Subdivision &d = *object.subdivision;
            use.motion += bytesOf(d.tangents.offsets, d.tangents.indices, d.tangents.weights, d.positions.offsets, d.positions.indices,
                                  d.positions.weights);
            use.source += bytesOf(d.mesh);
        }
        use.policy += object.bvh.bytes();
        if (meshes.insert(object.object->mesh.get()).second) use.source += bytesOf(*object.object->mesh);
    }
    return use;
}

} // namespace taut
