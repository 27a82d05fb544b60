/// Components, boundary loops and complex edges of shapes of which they are known.

#include "catch.h"
#include "mesh_fixtures.h"

#include "taut/mesh/topology.h"

#include <iostream>
#include <sstream>

using namespace taut;
using namespace taut::test;

namespace {

std::array<std::size_t, 3> counts(const Mesh &mesh, bool weld = false) {
    const Topology t = topologyOf(mesh, weld);
    return {t.components, t.boundaryLoops, t.complexEdges};
}
using Counts = std::array<std::size_t, 3>;

/// Faces without a say in where their positions lie: each gets a place of its own.
Mesh abstractMesh(std::size_t positions, const Polygons &faces) {
    std::vector<Vec3> places;
    for (std::size_t i = 0; i < positions; ++i) places.emplace_back(static_cast<float>(i), static_cast<float>(i * i % 7), 1);
    return meshOf(places, faces);
}

/// The faces of both, over positions of their own.
Mesh beside(const Mesh &a, const Mesh &b) {
    Mesh both = a;
    const auto shift = static_cast<Index>(a.positions.size());
    for (const Vec3 &p : b.positions) both.positions.push_back(p + Vec3(10, 0, 0));
    for (const Index v : b.cornerPositions) both.cornerPositions.push_back(v + shift);
    for (std::size_t f = 1; f < b.faceOffsets.size(); ++f)
        both.faceOffsets.push_back(b.faceOffsets[f] + static_cast<Index>(a.cornerPositions.size()));
    return both;
}

/// A strip of `n` quads whose ends are joined, after half a turn or without one.
Mesh ringOfQuads(Index n, bool halfTurn) {
    Polygons faces;
    for (Index i = 0; i < n; ++i) {
        const bool turned = halfTurn && i + 1 == n;
        const Index next = (i + 1) % n;
        faces.push_back({2 * i, 2 * next + (turned ? 1 : 0), 2 * next + (turned ? 0 : 1), 2 * i + 1});
    }
    return abstractMesh(2 * n, faces);
}

void reverseFace(Mesh &mesh, std::size_t face) {
    std::reverse(mesh.cornerPositions.begin() + mesh.faceOffsets[face], mesh.cornerPositions.begin() + mesh.faceOffsets[face + 1]);
}

} // namespace

TEST_CASE("Topology of closed meshes, meshes with boundaries and several components", "[mesh][topology]") {
    CHECK(counts(Mesh()) == Counts{0, 0, 0});
    CHECK(counts(cube()) == Counts{1, 0, 0});
    CHECK(counts(torus(8, 5)) == Counts{1, 0, 0});
    CHECK(counts(openGrid(4, bumpy)) == Counts{1, 1, 0});
    CHECK(counts(ringOfQuads(7, false)) == Counts{1, 2, 0});
    CHECK(counts(beside(cube(), torus(6, 4))) == Counts{2, 0, 0});
    CHECK(counts(beside(cube(), openGrid(3, bumpy))) == Counts{2, 1, 0});
    Mesh unused = cube();
    unused.positions.emplace_back(9, 9, 9);
    CHECK(counts(unused) == Counts{1, 0, 0});
}

TEST_CASE("Topology of what half-edges do not take", "[mesh][topology]") {
    CHECK(counts(ringOfQuads(7, true)) == Counts{1, 1, 0}); // a Moebius strip
    for (std::size_t face = 0; face < 6; ++face) {
        Mesh flipped = cube();
        reverseFace(flipped, face);
        CHECK(counts(flipped) == Counts{1, 0, 0});
    }
    // Three pages of a book, in both orders of their corners.
    CHECK(counts(abstractMesh(8, {{0, 1, 2, 3}, {0, 1, 4, 5}, {1, 0, 6, 7}})) == Counts{1, 1, 1});
    CHECK(counts(abstractMesh(8, {{0, 1, 2, 3}, {1, 0, 4, 5}, {1, 0, 6, 7}})) == Counts{1, 1, 1});
    CHECK(counts(abstractMesh(5, {{0, 1, 2}, {0, 3, 4}})) == Counts{2, 1, 0}); // joined by a position alone
    // A fin on a cube; two cubes that share an edge; the same face twice and once more.
    Mesh fin = cube();
    fin.positions.insert(fin.positions.end(), {{5, 5, 5}, {6, 5, 5}});
    fin.cornerPositions.insert(fin.cornerPositions.end(), {fin.cornerPositions[0], fin.cornerPositions[1], 8, 9});
    fin.faceOffsets.push_back(static_cast<Index>(fin.cornerPositions.size()));
    CHECK(counts(fin) == Counts{1, 1, 1});
    Mesh pair = beside(cube(), cube());
    const Index a = pair.cornerPositions[0];
    const Index b = pair.cornerPositions[1];
    for (Index &v : pair.cornerPositions) v = v == a + 8 ? a : v == b + 8 ? b : v;
    CHECK(counts(pair) == Counts{1, 0, 1});
    CHECK(counts(abstractMesh(3, {{0, 1, 2}, {0, 1, 2}})) == Counts{1, 0, 0});
    CHECK(counts(abstractMesh(3, {{0, 1, 2}, {0, 1, 2}, {2, 1, 0}})) == Counts{1, 0, 3});
    // A face that comes back to a position; corners that repeat their neighbour; a face of two corners.
    CHECK(counts(abstractMesh(5, {{0, 1, 2, 0, 3, 4}})).front() == 1);
    CHECK(counts(abstractMesh(3, {{0, 0, 1, 2, 2}, {0, 1, 1}})) == Counts{1, 1, 0});
}

TEST_CASE("Topology of a fan of many faces", "[mesh][topology]") {
    Polygons faces;
    constexpr Index kFaces = 200000;
    for (Index i = 0; i < kFaces; ++i) faces.push_back({0, i + 1, i + 2});
    CHECK(counts(abstractMesh(kFaces + 2, faces)) == Counts{1, 1, 0});
    faces.back()[2] = 1;
    CHECK(counts(abstractMesh(kFaces + 2, faces)) == Counts{1, 1, 0}); // closed around its middle
}

TEST_CASE("Topology of positions that a file keeps apart", "[mesh][topology]") {
    const Mesh whole = cube();
    Mesh split = whole;
    split.positions.clear();
    for (Index c = 0; c < whole.cornerCount(); ++c) {
        split.positions.push_back(whole.positions[whole.cornerPositions[c]]);
        split.cornerPositions[c] = c;
    }
    CHECK(counts(split) == Counts{6, 6, 0});
    CHECK(counts(split, true) == Counts{1, 0, 0});
}

TEST_CASE("Topology prints nothing", "[mesh][topology]") {
    std::ostringstream printed;
    std::streambuf *const err = std::cerr.rdbuf(printed.rdbuf());
    topologyOf(ringOfQuads(5, true), false);
    topologyOf(abstractMesh(3, {{0, 1, 2}, {0, 1, 2}, {2, 1, 0}}), false);
    std::cerr.rdbuf(err);
    CHECK(printed.str().empty());
}
