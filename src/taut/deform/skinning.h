#pragma once
/// Linear blend skinning and morphs of vertex positions; float, one pass, no allocation once the output has its size.
///
/// x' = sum_i w_i(x) B_i x, so that the gradient is dx'/dx = sum_i w_i B_i + sum_i (B_i x) (x) grad w_i. The first term is
/// blendedTransform; the second, which many renderers forget, is in no vertex alone: surface_motion.cpp takes it from the gradients
/// of the weights over the surface.
///
/// A joint matrix B is affine, worldFromJoint * inverseBind. `fallback` moves vertices without influences, and all of a mesh that has no
/// skin or no joints. Indices are trusted: the readers and check() have looked at them.

#include "taut/deform/affine.h"
#include "taut/mesh/mesh.h"

#include <span>
#include <vector>

namespace taut {

/// Whether a joint has a say at a vertex.
inline bool isSkinned(const SkinWeights &skin, std::size_t vertex, std::span<const Affine> joints) {
    return !joints.empty() && !skin.empty() && skin.offsets[vertex] != skin.offsets[vertex + 1];
}

/// sum_k w_k B_joint(k) over the influences of `vertex`.
inline Affine blendedTransform(const SkinWeights &skin, std::size_t vertex, std::span<const Affine> joints, const Affine &fallback) {
    if (!isSkinned(skin, vertex, joints)) return fallback;
    Affine blend{0};
    for (Index i = skin.offsets[vertex]; i < skin.offsets[vertex + 1]; ++i) blend += joints[skin.joints[i]] * skin.weights[i];
    return blend;
}

/// out[v] = blendedTransform(v) * positions[v]. `positions` may be those of `out`.
void skinPositions(const SkinWeights &skin, std::span<const Affine> joints, const Affine &fallback, std::span<const Vec3> positions,
                   std::vector<Vec3> &out);

/// out[v] = positions[v] + sum_m weights[m] * morphs[m].positionDeltas[v]. Morphs without a weight, and weights without a
/// morph, count as nothing. `out` may be `positions`.
void morphPositions(const std::vector<Vec3> &positions, const std::vector<MorphTarget> &morphs, const std::vector<float> &weights,
                    std::vector<Vec3> &out);
/// out[n] = normals[n] + sum_m weights[m] * morphs[m].normalDeltas[n], which is not of length 1.
void morphNormals(const std::vector<Vec3> &normals, const std::vector<MorphTarget> &morphs, const std::vector<float> &weights,
                  std::vector<Vec3> &out);
/// Whether a morph says what it does to normals.
bool hasMorphNormals(const Mesh &mesh);

} // namespace taut
