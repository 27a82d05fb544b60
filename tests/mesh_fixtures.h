#pragma once
/// Small meshes by property, for what must hold on all of them, and what is asked of a mesh: edges, closedness, volume.

#include "taut/mesh/mesh.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <string>
#include <utility>
#include <vector>

namespace taut::test {

using Polygons = std::vector<std::vector<Index>>;

inline Mesh meshOf(std::vector<Vec3> positions, const Polygons &faces) {
    Mesh mesh;
    mesh.name = "cage";
    mesh.positions = std::move(positions);
    for (const auto &face : faces) {
        mesh.cornerPositions.insert(mesh.cornerPositions.end(), face.begin(), face.end());
        mesh.faceOffsets.push_back(static_cast<Index>(mesh.cornerPositions.size()));
    }
    return mesh;
}

inline Mesh cube() {
    std::vector<Vec3> positions;
    for (int i = 0; i < 8; ++i) positions.emplace_back((i & 1) != 0 ? 1 : -1, (i & 2) != 0 ? 1 : -1, (i & 4) != 0 ? 1 : -1);
    return meshOf(positions, {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}});
}

/// Height of control point (i, j): nothing a low-order rule could reproduce by chance.
inline float bumpy(int i, int j) {
    return 0.3F * std::sin(1.7F * static_cast<float>(i) + 0.4F) * std::cos(2.3F * static_cast<float>(j * j));
}

/// n x n quads; control point (i, j) at (i, j, height); uvs are the grid's parameters.
template <class Height> Mesh openGrid(int n, const Height &height) {
    std::vector<Vec3> positions;
    Polygons faces;
    const auto at = [n](int i, int j) { return static_cast<Index>(j * (n + 1) + i); };
    for (int j = 0; j <= n; ++j)
        for (int i = 0; i <= n; ++i) positions.emplace_back(i, j, height(i, j));
    for (int j = 0; j < n; ++j)
        for (int i = 0; i < n; ++i) faces.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)});
    Mesh mesh = meshOf(positions, faces);
    for (const Vec3 &p : mesh.positions) mesh.uvs.emplace_back(p.x / static_cast<float>(n), p.y / static_cast<float>(n));
    mesh.cornerUvs = mesh.cornerPositions;
    return mesh;
}

/// A closed torus of n x m quads whose uvs have a seam each way.
inline Mesh torus(int n, int m) {
    std::vector<Vec3> positions;
    Polygons faces;
    for (int j = 0; j < m; ++j)
        for (int i = 0; i < n; ++i) {
            const float a = 2 * kPi * static_cast<float>(i) / static_cast<float>(n);
            const float b = 2 * kPi * static_cast<float>(j) / static_cast<float>(m);
            positions.emplace_back((2 + 0.7F * std::cos(b)) * std::cos(a), (2 + 0.7F * std::cos(b)) * std::sin(a), 0.7F * std::sin(b));
        }
    Mesh uvs;
    for (int j = 0; j <= m; ++j)
        for (int i = 0; i <= n; ++i)
            uvs.uvs.emplace_back(static_cast<float>(i) / static_cast<float>(n), static_cast<float>(j) / static_cast<float>(m));
    const std::array<std::pair<int, int>, 4> corners{{{0, 0}, {1, 0}, {1, 1}, {0, 1}}};
    for (int j = 0; j < m; ++j)
        for (int i = 0; i < n; ++i) {
            faces.emplace_back();
            for (const auto &[di, dj] : corners) {
                faces.back().push_back(static_cast<Index>((j + dj) % m * n + (i + di) % n));
                uvs.cornerUvs.push_back(static_cast<Index>((j + dj) * (n + 1) + i + di));
            }
        }
    Mesh mesh = meshOf(positions, faces);
    mesh.uvs = std::move(uvs.uvs);
    mesh.cornerUvs = std::move(uvs.cornerUvs);
    return mesh;
}

using DirectedEdges = std::map<std::pair<Index, Index>, int>;

inline DirectedEdges directedEdges(const Mesh &mesh) {
    DirectedEdges edges;
    for (std::size_t f = 0; f < mesh.faceCount(); ++f)
        for (Index c = mesh.faceOffsets[f], last = mesh.faceOffsets[f + 1] - 1; c <= last; ++c)
            ++edges[{mesh.cornerPositions[c], mesh.cornerPositions[c == last ? mesh.faceOffsets[f] : c + 1]}];
    return edges;
}

inline std::size_t edgeCount(const Mesh &mesh) {
    std::size_t count = 0;
    const DirectedEdges edges = directedEdges(mesh);
    for (const auto &[edge, uses] : edges) count += edge.first < edge.second || edges.count({edge.second, edge.first}) == 0 ? 1 : 0;
    return count;
}

/// Every edge is walked once each way: closed and consistently oriented.
inline bool isWatertight(const Mesh &mesh) {
    const DirectedEdges edges = directedEdges(mesh);
    return std::all_of(edges.begin(), edges.end(), [&](const auto &entry) {
        const auto opposite = edges.find({entry.first.second, entry.first.first});
        return entry.second == 1 && opposite != edges.end() && opposite->second == 1;
    });
}

/// Volume enclosed by a mesh, by the divergence theorem over fans: positive where faces are counter-clockwise from outside.
inline double signedVolume(const Mesh &mesh) {
    double volume = 0;
    for (std::size_t f = 0; f < mesh.faceCount(); ++f) {
        const DVec3 first = mesh.positions[mesh.cornerPositions[mesh.faceOffsets[f]]];
        for (Index c = mesh.faceOffsets[f] + 1; c + 1 < mesh.faceOffsets[f + 1]; ++c)
            volume += glm::dot(first, glm::cross(DVec3(mesh.positions[mesh.cornerPositions[c]]),
                                                 DVec3(mesh.positions[mesh.cornerPositions[c + 1]]))) /
                      6;
    }
    return volume;
}

/// Cages by property, for what must hold on all of them.
inline std::vector<std::pair<std::string, Mesh>> cages() {
    std::vector<std::pair<std::string, Mesh>> all;
    all.emplace_back("cube", cube());
    all.emplace_back("open grid", openGrid(4, bumpy));
    all.emplace_back("torus with uv seams", torus(7, 5));
    all.emplace_back("tetrahedron", meshOf({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}}));
    all.emplace_back("pentagon, quad and triangle", meshOf({{0, 0, 0}, {2, 0, 0}, {3, 1, 0}, {1, 2, 1}, {-1, 1, 0}, {2, 3, 0}, {4, 3, 1}},
                                                           {{0, 1, 2, 3, 4}, {3, 2, 6, 5}, {4, 3, 5}}));
    all.emplace_back("single triangle", meshOf({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}}));
    all.emplace_back("three faces at an edge",
                     meshOf({{0, 0, 0}, {0, 0, 1}, {1, 0, 0}, {1, 0, 1}, {-1, 1, 0}, {-1, 1, 1}, {-1, -1, 0}, {-1, -1, 1}},
                            {{0, 2, 3, 1}, {0, 1, 5, 4}, {0, 6, 7, 1}}));
    all.emplace_back("two fans at a vertex", meshOf({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {-1, 0, 1}, {0, -1, 1}}, {{0, 1, 2}, {0, 3, 4}}));
    all.emplace_back("faces turned against each other",
                     meshOf({{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {2, 0, 0}, {2, 1, 0}}, {{0, 1, 2, 3}, {1, 2, 5, 4}}));
    all.emplace_back("a position without faces", meshOf({{0, 0, 0}, {1, 0, 0}, {5, 5, 5}, {1, 1, 0}, {0, 1, 0}}, {{0, 1, 3, 4}}));
    all.emplace_back("the same triangle twice", meshOf({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}, {0, 1, 2}}));
    all.emplace_back("a corner twice in a face", meshOf({{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}, {{0, 1, 1, 2, 3}}));
    return all;
}

} // namespace taut::test
