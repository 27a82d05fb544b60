#include "taut/deform/skinning.h"

#include "taut/base/parallel.h"

#include <algorithm>

namespace taut {
namespace {

/// Vertices a task takes at a time: enough to hide its cost.
constexpr std::size_t kGrain = 2048;

} // namespace

void skinPositions(const SkinWeights &skin, std::span<const Affine> joints, const Affine &fallback, std::span<const Vec3> positions,
                   std::vector<Vec3> &out) {
    if (out.size() != positions.size()) out.resize(positions.size());
    parallelFor(positions.size(), kGrain,
                [&](std::size_t v) { out[v] = transformPoint(blendedTransform(skin, v, joints, fallback), positions[v]); });
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
