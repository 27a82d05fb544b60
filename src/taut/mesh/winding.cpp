#include "taut/mesh/winding.h"

#include "taut/mesh/triangulate.h"

#include <algorithm>

namespace taut {

namespace {

Vec3 unitOrZero(const Vec3 &v) {
    const float length = glm::length(v);
    return length > 0 && std::isfinite(length) ? v / length : Vec3(0);
}

/// Unit normal of each face by its winding; 0 where it has no area.
std::vector<Vec3> windingNormals(const Mesh &mesh) {
    std::vector<Vec3> normals(mesh.faceCount());
    std::vector<Vec3> points;
    for (std::size_t face = 0; face < mesh.faceCount(); ++face) {
        points.clear();
        for (Index c = mesh.faceOffsets[face]; c < mesh.faceOffsets[face + 1]; ++c)
            points.push_back(mesh.positions[mesh.cornerPositions[c]]);
        normals[face] = unitOrZero(polygonNormal(points));
    }
    return normals;
}

} // namespace

std::vector<unsigned char> cornersAgainstWinding(const Mesh &mesh) {
    if (mesh.cornerNormals.empty()) return {};
    const std::vector<Vec3> faces = windingNormals(mesh);
    const auto along = [&](Index corner, const Vec3 &direction) {
        const Index given = mesh.cornerNormals[corner];
        return given == kNone ? 0.0F : glm::dot(unitOrZero(mesh.normals[given]), direction);
    };
    const auto forEachCorner = [&](const auto &use) {
        for (std::size_t face = 0; face < faces.size(); ++face)
            for (Index c = mesh.faceOffsets[face]; c < mesh.faceOffsets[face + 1]; ++c) use(face, c);
    };
    bool any = false;
    std::vector<unsigned char> allInward(faces.size(), 1);
    forEachCorner([&](std::size_t face, Index c) {
        const bool inward = along(c, faces[face]) < 0;
        any = any || inward;
        if (!inward) allInward[face] = 0;
    });
    if (!any) return {};
    std::vector<Vec3> around(mesh.positions.size(), Vec3(0));
    forEachCorner([&](std::size_t face, Index c) { around[mesh.cornerPositions[c]] += faces[face]; });
    std::vector<unsigned char> turned(mesh.cornerCount(), 0);
    any = false;
    forEachCorner([&](std::size_t face, Index c) {
        if (!(along(c, faces[face]) < 0)) return;
        if (allInward[face] == 0 && !(along(c, around[mesh.cornerPositions[c]]) < 0)) return;
        turned[c] = 1;
        any = true;
    });
    return any ? turned : std::vector<unsigned char>();
}

std::size_t normalsAgainstWinding(const Mesh &mesh) {
    const std::vector<unsigned char> turned = cornersAgainstWinding(mesh);
    if (turned.empty()) return 0;
    std::vector<unsigned char> counted(mesh.normals.size(), 0);
    for (std::size_t c = 0; c < turned.size(); ++c)
        if (turned[c] != 0) counted[mesh.cornerNormals[c]] = 1;
    return static_cast<std::size_t>(std::count(counted.begin(), counted.end(), 1));
}

} // namespace taut
