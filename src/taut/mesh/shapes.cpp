#include "taut/mesh/shapes.h"

#include <array>

namespace taut {

namespace {

struct Sample {
    Vec3 position, normal;
};

/// A parametric patch of nu x nv quads with vertices (i, j); `closedU` / `closedV` join the ends in positions, not in uvs.
template <class F> Mesh makePatch(int nu, int nv, bool closedU, bool closedV, const F &f) {
    Mesh mesh;
    const int pu = closedU ? nu : nu + 1;
    const int pv = closedV ? nv : nv + 1;
    for (int j = 0; j < pv; ++j)
        for (int i = 0; i < pu; ++i) {
            const Sample s = f(static_cast<double>(i) / nu, static_cast<double>(j) / nv);
            mesh.positions.push_back(s.position);
            mesh.normals.push_back(s.normal);
        }
    for (int j = 0; j <= nv; ++j)
        for (int i = 0; i <= nu; ++i)
            mesh.uvs.emplace_back(static_cast<float>(i) / static_cast<float>(nu), static_cast<float>(j) / static_cast<float>(nv));
    for (int j = 0; j < nv; ++j)
        for (int i = 0; i < nu; ++i) {
            for (const auto &[di, dj] : {std::array{0, 0}, std::array{1, 0}, std::array{1, 1}, std::array{0, 1}}) {
                mesh.cornerPositions.push_back(static_cast<Index>((j + dj) % pv * pu + (i + di) % pu));
                mesh.cornerUvs.push_back(static_cast<Index>((j + dj) * (nu + 1) + i + di));
            }
            mesh.faceOffsets.push_back(static_cast<Index>(mesh.cornerPositions.size()));
        }
    mesh.cornerNormals = mesh.cornerPositions;
    shrinkToFit(mesh);
    return mesh;
}

} // namespace

Mesh makeTorus(int around, int across, float bigRadius, float smallRadius) {
    Mesh mesh = makePatch(around, across, true, true, [&](double u, double v) {
        const DVec3 n(std::cos(kTwoPi * v) * std::cos(kTwoPi * u), std::cos(kTwoPi * v) * std::sin(kTwoPi * u), std::sin(kTwoPi * v));
        const DVec3 ring(std::cos(kTwoPi * u), std::sin(kTwoPi * u), 0);
        return Sample{Vec3(ring * static_cast<double>(bigRadius) + n * static_cast<double>(smallRadius)), Vec3(n)};
    });
    mesh.name = "torus";
    return mesh;
}

Mesh makeSphere(int around, int across, float radius) {
    Mesh mesh = makePatch(around, across, true, false, [&](double u, double v) {
        const double latitude = (v - 0.5) * kTwoPi / 2;
        const bool pole = v == 0 || v == 1;
        const double r = pole ? 0.0 : std::cos(latitude);
        const DVec3 n(r * std::cos(kTwoPi * u), r * std::sin(kTwoPi * u), pole ? 2 * v - 1 : std::sin(latitude));
        return Sample{Vec3(n * static_cast<double>(radius)), Vec3(n)};
    });
    mesh.name = "sphere";
    // The quads at the poles have an edge of length zero: make them triangles.
    Mesh clean = mesh;
    clean.faceOffsets.assign(1, 0);
    clean.cornerPositions.clear();
    clean.cornerUvs.clear();
    for (std::size_t face = 0; face < mesh.faceCount(); ++face) {
        for (Index c = mesh.faceOffsets[face]; c < mesh.faceOffsets[face + 1]; ++c) {
            const bool south = face < static_cast<std::size_t>(around) && c == mesh.faceOffsets[face] + 1;
            const bool north =
                face >= static_cast<std::size_t>(around) * static_cast<std::size_t>(across - 1) && c == mesh.faceOffsets[face] + 3;
            if (south || north) continue;
            clean.cornerPositions.push_back(mesh.cornerPositions[c]);
            clean.cornerUvs.push_back(mesh.cornerUvs[c]);
        }
        clean.faceOffsets.push_back(static_cast<Index>(clean.cornerPositions.size()));
    }
    clean.cornerNormals = clean.cornerPositions;
    return clean;
}

Mesh makeGrid(int nx, int ny, float size) {
    Mesh mesh = makePatch(nx, ny, false, false, [&](double u, double v) {
        const double s = static_cast<double>(size);
        return Sample{Vec3((u - 0.5) * s, (v - 0.5) * s, 0), Vec3(0, 0, 1)};
    });
    mesh.name = "grid";
    return mesh;
}

} // namespace taut
