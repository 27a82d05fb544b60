/// Creased limit surfaces at corners of more than a half turn: normals outward, tangents counter-clockwise, exact gradients.

#include "assets.h"
#include "mesh_fixtures.h"
#include "render_fixtures.h"

#include "taut/formats/read_mesh.h"

#include <array>
#include <map>
#include <set>

using namespace taut;
using namespace taut::test;

namespace {

using Cell = std::array<int, 3>;

/// The outside of a set of unit cubes: quads, outward.
Mesh blocks(const std::set<Cell> &cells) {
    Mesh mesh = meshOf({}, {});
    std::map<Cell, Index> corners;
    for (const Cell &cell : cells)
        for (int axis = 0; axis < 3; ++axis)
            for (const int side : {0, 1}) {
                Cell next = cell;
                next[static_cast<std::size_t>(axis)] += side == 1 ? 1 : -1;
                if (cells.count(next) != 0) continue;
                for (int k = 0; k < 4; ++k) { // around the axis, the other way round below
                    const int turn = side == 1 ? k : 3 - k;
                    Cell at = cell;
                    at[static_cast<std::size_t>(axis)] += side;
                    at[static_cast<std::size_t>((axis + 1) % 3)] += turn == 1 || turn == 2 ? 1 : 0;
                    at[static_cast<std::size_t>((axis + 2) % 3)] += turn >= 2 ? 1 : 0;
                    const auto [known, isNew] = corners.try_emplace(at, static_cast<Index>(mesh.positions.size()));
                    if (isNew) mesh.positions.emplace_back(at[0], at[1], at[2]);
                    mesh.cornerPositions.push_back(known->second);
                }
                mesh.faceOffsets.push_back(static_cast<Index>(mesh.cornerPositions.size()));
            }
    return mesh;
}

Mesh split(const Mesh &quads) {
    Mesh mesh = meshOf(quads.positions, {});
    for (std::size_t c = 0; c < quads.cornerCount(); c += 4) {
        for (const std::size_t k : {0, 1, 2, 0, 2, 3}) mesh.cornerPositions.push_back(quads.cornerPositions[c + k]);
        for (int k = 0; k < 2; ++k) mesh.faceOffsets.push_back(mesh.faceOffsets.back() + 3);
    }
    return mesh;
}

/// The least cosine between a corner's normal and that of its face there.
float leastFacing(const Mesh &mesh) {
    float least = 1;
    for (std::size_t f = 0; f < mesh.faceCount(); ++f) {
        const Index begin = mesh.faceOffsets[f];
        const Index count = mesh.faceOffsets[f + 1] - begin;
        for (Index k = 0; k < count; ++k) {
            const auto point = [&](Index i) { return mesh.positions[mesh.cornerPositions[begin + i % count]]; };
            const Vec3 up = glm::cross(point(k + 1) - point(k), point(k + count - 1) - point(k));
            least = std::min(least, glm::dot(glm::normalize(up), mesh.normals[mesh.cornerNormals[begin + k]]));
        }
    }
    return least;
}

} // namespace

TEST_CASE("Normals at reflex corners point outward: case reflex-corner", "[limit]") {
    const auto path = caseFile("reflex-corner/L_block.obj");
    if (!path) return;
    Warnings warnings;
    const Mesh cage = readMesh(*path, warnings);
    for (int level = 1; level <= 3; ++level)
        CHECK(leastFacing(subdivide(cage, {.level = level, .creaseAngle = 40 * kPi / 180}).mesh) > 0.999F);
}

TEST_CASE("A creased block is itself, whatever the angles of its corners: normals, tangents and gradient", "[limit]") {
    // A cross, a cube without one of its octants, stairs: corners of 90 and 270 degrees, and where three faces meet from within.
    std::set<Cell> octants;
    for (int i = 0; i < 7; ++i) octants.insert({i & 1, i >> 1 & 1, i >> 2});
    const std::vector<std::pair<const char *, std::set<Cell>>> shapes{
        {"cross", {{1, 1, 0}, {0, 1, 0}, {2, 1, 0}, {1, 0, 0}, {1, 2, 0}}},
        {"seven octants", octants},
        {"stairs", {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {0, 0, 1}, {1, 0, 1}, {0, 0, 2}}}};
    const glm::dmat3 linear(1.3, 0.2, -0.4, 0.1, 0.7, 0.5, -0.6, 0.3, 1.1);
    for (const auto &[name, cells] : shapes)
        for (const SubdivisionScheme scheme : {SubdivisionScheme::CatmullClark, SubdivisionScheme::Loop})
            for (int level = 1; level <= 3; ++level) {
                INFO(name << ", level " << level << (scheme == SubdivisionScheme::Loop ? ", loop" : ""));
                const Mesh cage = scheme == SubdivisionScheme::Loop ? split(blocks(cells)) : blocks(cells);
                Object object = makeObject(cage);
                object.subdivision = {.level = level, .scheme = scheme, .creaseAngle = 0.5F};
                CHECK(leastFacing(subdivide(cage, object.subdivision).mesh) > 0.999F);
                CHECK(linearError(object, linear) < 1e-3F);
            }
}

TEST_CASE("A nearly straight corner takes the plane of its faces, not that of its two edges", "[limit]") {
    // On the long edge of a beam a third crease comes in from above; the middle of the edge is dented by a thousandth.
    Mesh cage = blocks({{0, 0, 0}, {1, 0, 0}});
    const auto at = [&](const Vec3 &p) {
        return static_cast<Index>(std::find(cage.positions.begin(), cage.positions.end(), p) - cage.positions.begin());
    };
    cage.creases.push_back({at({1, 0, 1}), at({1, 1, 1}), kInfinitelySharp});
    for (const float dent : {-1e-3F, -1e-4F, 0.0F, 1e-4F, 1e-3F}) {
        INFO("dent " << dent);
        Mesh dented = cage;
        dented.positions[at({1, 0, 1})].y = dent;
        for (int level = 1; level <= 2; ++level) CHECK(leastFacing(subdivide(dented, {.level = level, .creaseAngle = 0.5F}).mesh) > 0.9F);
    }
}
