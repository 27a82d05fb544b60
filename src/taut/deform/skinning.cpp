#include "taut/deform/skinning.h"

#include "taut/base/parallel.h"

#include <algorithm>

namespace taut {
namespace {

/// Vertices a task takes at a time: enough to hide its cost.
constexpr std::size_t kGrain = 4096;

} // namespace

Mat4x3 blendedTransform(const SkinWeights &skin, Index vertex, const std::vector<Mat4x3> &joints, const Mat4x3 &fallback) {
    if (skin.empty()) return fallback;
    const Index begin = skin.offsets[vertex];
    const Index end = skin.offsets[vertex + 1];
    if (begin == end) return fallback;
    Mat4x3 blend = skin.weights[begin] * joints[skin.joints[begin]];
    for (Index k = begin + 1; k < end; ++k) blend += skin.weights[k] * joints[skin.joints[k]];
    return blend;
}

void skinPositions(const SkinWeights &skin, const std::vector<Mat4x3> &joints, const Mat4x3 &fallback, const std::vector<Vec3> &positions,
                   std::vector<Vec3> &out) {
    if (out.size() != positions.size()) out.resize(positions.size());
    parallelFor(positions.size(), kGrain,
                [&](std::size_t v) { out[v] = blendedTransform(skin, static_cast<Index>(v), joints, fallback) * Vec4(positions[v], 1); });
}

void morphPositions(const std::vector<Vec3> &positions, const std::vector<MorphTarget> &morphs, const std::vector<float> &weights,
                    std::vector<Vec3> &out) {
    if (out.size() != positions.size()) out.resize(positions.size());
    const std::size_t count = std::min(morphs.size(), weights.size());
    parallelFor(positions.size(), kGrain, [&](std::size_t v) {
        Vec3 sum = positions[v];
        for (std::size_t m = 0; m < count; ++m)
            if (weights[m] != 0 && v < morphs[m].positionDeltas.size()) sum += weights[m] * morphs[m].positionDeltas[v];
        out[v] = sum;
    });
}

} // namespace taut
