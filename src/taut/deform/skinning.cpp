#include "taut/deform/skinning.h"

#include "taut/base/parallel.h"

#include <algorithm>

namespace taut {
namespace {

/// Vertices a task takes at a time: enough to hide its cost.
/// values + sum of weights times deltas, those of the morphs by `deltas`.
void addMorphs(const std::vector<Vec3> &values, const std::vector<MorphTarget> &morphs, const std::vector<float> &weights,
               std::vector<Vec3> MorphTarget::*deltas, std::vector<Vec3> &out) {
    if (out.size() != values.size()) out.resize(values.size());
    const std::size_t count = std::min(morphs.size(), weights.size());
    parallelFor(values.size(), kVertexGrain, [&](std::size_t v) {
        Vec3 sum = values[v];
        for (std::size_t m = 0; m < count; ++m)
            if (weights[m] != 0 && v < (morphs[m].*deltas).size()) sum += weights[m] * (morphs[m].*deltas)[v];
        out[v] = sum;
    });
}

} // namespace

void skinPositions(const SkinWeights &skin, std::span<const Affine> joints, const Affine &fallback, std::span<const Vec3> positions,
                   std::vector<Vec3> &out) {
    if (out.size() != positions.size()) out.resize(positions.size());
    parallelFor(positions.size(), kVertexGrain,
                [&](std::size_t v) { out[v] = transformPoint(blendedTransform(skin, v, joints, fallback), positions[v]); });
}

void morphPositions(const std::vector<Vec3> &positions, const std::vector<MorphTarget> &morphs, const std::vector<float> &weights,
                    std::vector<Vec3> &out) {
    addMorphs(positions, morphs, weights, &MorphTarget::positionDeltas, out);
}

void morphNormals(const std::vector<Vec3> &normals, const std::vector<MorphTarget> &morphs, const std::vector<float> &weights,
                  std::vector<Vec3> &out) {
    addMorphs(normals, morphs, weights, &MorphTarget::normalDeltas, out);
}

bool hasMorphNormals(const Mesh &mesh) {
    return std::any_of(mesh.morphs.begin(), mesh.morphs.end(), [](const MorphTarget &morph) { return !morph.normalDeltas.empty(); });
}

} // namespace taut
