#pragma once
/// Linear blend skinning and morphs of vertex positions; float, one pass, no allocation once the output has its size.
///
/// x' = sum_i w_i(x) B_i x, so that the gradient is dx'/dx = sum_i w_i B_i + sum_i (B_i x) (x) grad w_i. The first term is
/// blendedTransform; the second, which many renderers forget, is in no vertex alone: it comes from the differences of the
/// skinned positions over the surface.
///
/// A joint matrix B is affine, worldFromJoint * inverseBind, as four columns of Vec3 (the last is the translation).
/// `fallback` moves vertices without influences. Indices are trusted: the readers have checked them.

#include "taut/mesh/mesh.h"

#include <vector>

namespace taut {

using Mat4x3 = glm::mat4x3;

/// The upper three rows of an affine matrix.
inline Mat4x3 affineOf(const DMat4 &matrix) {
    return Mat4x3(matrix);
}

/// out[v] = blendedTransform(v) * positions[v]. `out` may be `positions`.
void skinPositions(const SkinWeights &skin, const std::vector<Mat4x3> &joints, const Mat4x3 &fallback, const std::vector<Vec3> &positions,
                   std::vector<Vec3> &out);

/// sum_k w_k B_joint(k) over the influences of `vertex`.
Mat4x3 blendedTransform(const SkinWeights &skin, Index vertex, const std::vector<Mat4x3> &joints, const Mat4x3 &fallback);

/// out[v] = positions[v] + sum_m weights[m] * morphs[m].positionDeltas[v]. Morphs without a weight, and weights without a
/// morph, count as nothing. `out` may be `positions`.
void morphPositions(const std::vector<Vec3> &positions, const std::vector<MorphTarget> &morphs, const std::vector<float> &weights,
                    std::vector<Vec3> &out);

} // namespace taut
