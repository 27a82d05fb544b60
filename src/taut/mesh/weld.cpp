#include "taut/mesh/weld.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <unordered_map>

namespace taut {

namespace {

std::size_t hashBytes(const void *data, std::size_t size, std::size_t seed) {
    const auto *bytes = static_cast<const unsigned char *>(data);
    for (std::size_t i = 0; i < size; ++i) seed = (seed ^ bytes[i]) * 1099511628211ULL;
    return seed;
}

/// The position without what is below 1e-9 of the mesh's size: where a circle closes, files hold sin(2 pi) = -2.4e-16 beside 0. -0 and 0
/// are one place.
Vec3 snapped(const Vec3 &p, float size) {
    const float large = size / 128; // its last digit is what is left
    const auto snap = [&](float x) { return std::fabs(x) < large ? (x + large) - large + 0.0F : x; };
    return {snap(p.x), snap(p.y), snap(p.z)};
}

/// True where two positions coincide at rest and move alike: same skin row, same morph displacements.
bool sameMotion(const Mesh &mesh, Index a, Index b, float size) {
    if (snapped(mesh.positions[a], size) != snapped(mesh.positions[b], size)) return false;
    for (const MorphTarget &morph : mesh.morphs)
        if (morph.positionDeltas[a] != morph.positionDeltas[b]) return false;
    if (mesh.skin.empty()) return true;
    const auto &[offsets, joints, weights] = mesh.skin;
    const Index count = offsets[a + 1] - offsets[a];
    if (count != offsets[b + 1] - offsets[b]) return false;
    for (Index k = 0; k < count; ++k)
        if (joints[offsets[a] + k] != joints[offsets[b] + k] || weights[offsets[a] + k] != weights[offsets[b] + k]) return false;
    return true;
}

} // namespace

std::vector<Index> weldPositions(const Mesh &mesh, bool weld) {
    std::vector<Index> canonical(mesh.positions.size());
    std::iota(canonical.begin(), canonical.end(), Index{0});
    if (!weld) return canonical;
    std::unordered_multimap<std::size_t, Index> seen;
    seen.reserve(mesh.positions.size());
    float size = 0;
    for (const Vec3 &p : mesh.positions)
        for (int c = 0; c < 3; ++c) size = std::max(size, std::fabs(p[c]));
    for (Index i = 0; i < mesh.positions.size(); ++i) {
        const Vec3 p = snapped(mesh.positions[i], size);
        const std::size_t key = hashBytes(&p, sizeof p, 14695981039346656037ULL);
        const auto [first, last] = seen.equal_range(key);
        const auto match = std::find_if(first, last, [&](const auto &entry) { return sameMotion(mesh, entry.second, i, size); });
        if (match != last)
            canonical[i] = match->second;
        else
            seen.emplace(key, i);
    }
    return canonical;
}

Mesh welded(const Mesh &mesh) {
    const std::vector<Index> canonical = weldPositions(mesh, true);
    Mesh result = mesh;
    for (Index &position : result.cornerPositions) position = canonical[position];
    for (EdgeCrease &crease : result.creases) crease = {canonical[crease.a], canonical[crease.b], crease.sharpness};
    for (SharpCorner &corner : result.corners) corner.position = canonical[corner.position];
    return result;
}

} // namespace taut
