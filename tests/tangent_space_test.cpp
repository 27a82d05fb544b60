/// Tangents for maps of normals: against Blender's MikkTSpace, and where they are known.

#include "command.h"
#include "mesh_fixtures.h"

#include "taut/mesh/shapes.h"
#include "taut/mesh/tangent_space.h"
#include "taut/mesh/triangulate.h"

#include <nlohmann/json.hpp>

#include <iostream>

using namespace taut;
using namespace taut::test;

namespace {

/// A normal for every corner, the angle-free mean of the faces around its position.
std::vector<Vec3> cornerNormals(const Mesh &mesh) {
    std::vector<Vec3> sums(mesh.positions.size(), Vec3(0));
    for (std::size_t f = 0; f < mesh.faceCount(); ++f) {
        std::vector<Vec3> points;
        for (Index c = mesh.faceOffsets[f]; c < mesh.faceOffsets[f + 1]; ++c) points.push_back(mesh.positions[mesh.cornerPositions[c]]);
        for (Index c = mesh.faceOffsets[f]; c < mesh.faceOffsets[f + 1]; ++c) sums[mesh.cornerPositions[c]] += polygonNormal(points);
    }
    std::vector<Vec3> normals;
    for (const Index p : mesh.cornerPositions) normals.push_back(glm::normalize(sums[p]));
    return normals;
}

struct NamedMesh {
    std::string name;
    Mesh mesh;
};

/// Seams, mirrored maps, sheared and uneven ones, quads and triangles.
std::vector<NamedMesh> meshes() {
    std::vector<NamedMesh> all;
    all.push_back({"bumpy quads", openGrid(6, bumpy)});
    Mesh mirrored = openGrid(8, bumpy);
    for (Vec2 &uv : mirrored.uvs) uv.x = std::fabs(uv.x - 0.5F);
    all.push_back({"mirrored in the middle", mirrored});
    Mesh uneven = openGrid(6, bumpy);
    for (Vec2 &uv : uneven.uvs) uv = {uv.x * uv.x + 0.3F * uv.y, 0.7F * uv.y + 0.2F * std::sin(5 * uv.x)};
    all.push_back({"uneven", uneven});
    all.push_back({"torus with seams", makeTorus(12, 8, 0.7F, 0.25F)});
    all.push_back({"sphere", makeSphere(12, 6, 1)});
    return all;
}

} // namespace

TEST_CASE("Tangents of a flat map are its u axis, and mirrored ones are said to be", "[tangent_space]") {
    Mesh grid = makeGrid(4, 4, 2);
    const std::vector<Vec3> normals(grid.cornerCount(), Vec3(0, 0, 1));
    const TangentSpace plain = tangentSpace(grid, grid.positions, normals);
    for (const Index group : plain.corners) {
        REQUIRE(group != kNone);
        CHECK(glm::length(plain.tangents[group] - Vec4(1, 0, 0, 1)) < 1e-6F);
    }
    for (Vec2 &uv : grid.uvs) uv.x = -uv.x;
    const TangentSpace turned = tangentSpace(grid, grid.positions, normals);
    for (const Index group : turned.corners) CHECK(glm::length(turned.tangents[group] - Vec4(-1, 0, 0, -1)) < 1e-6F);
    grid.cornerUvs.clear();
    for (const Index group : tangentSpace(grid, grid.positions, normals).corners) CHECK(group == kNone);
}

TEST_CASE("Tangents are those of MikkTSpace as Blender has it", "[tangent_space][blender]") {
    if (runProgram({"blender", "--version"}, 60).exitCode != 0) {
        std::cout << "SKIPPED: there is no Blender on this machine" << std::endl;
        return;
    }
    const std::string folder = freshFolder("tangent_space");
    const auto all = meshes();
    nlohmann::json input = nlohmann::json::array();
    for (const NamedMesh &named : all) {
        const std::vector<Vec3> normals = cornerNormals(named.mesh);
        nlohmann::json mesh{
            {"positions", nlohmann::json::array()}, {"faces", nlohmann::json::array()}, {"corners", nlohmann::json::array()}};
        for (const Vec3 &p : named.mesh.positions) mesh["positions"].push_back({p.x, p.y, p.z});
        for (std::size_t f = 0; f < named.mesh.faceCount(); ++f) {
            nlohmann::json face = nlohmann::json::array();
            for (Index c = named.mesh.faceOffsets[f]; c < named.mesh.faceOffsets[f + 1]; ++c) {
                face.push_back(named.mesh.cornerPositions[c]);
                const Vec2 &uv = named.mesh.uvs[named.mesh.cornerUvs[c]];
                const Vec3 &n = normals[c];
                mesh["corners"].push_back({uv.x, uv.y, n.x, n.y, n.z});
            }
            mesh["faces"].push_back(face);
        }
        input.push_back(mesh);
    }
    std::ofstream(folder + "/meshes.json") << input;
    const auto ran = runProgram({"blender", "-b", "-noaudio", "--factory-startup", "--python-exit-code", "1", "--python",
                                 TAUT_SOURCE_DIR "/tests/blender/tangents.py", "--", folder + "/meshes.json", folder + "/tangents.json"},
                                300);
    REQUIRE(ran.exitCode == 0);
    const auto output = nlohmann::json::parse(std::ifstream(folder + "/tangents.json"));
    for (std::size_t i = 0; i < all.size(); ++i) {
        INFO(all[i].name);
        const Mesh &mesh = all[i].mesh;
        // Blender rounds custom normals: what it made of them is what it worked with.
        std::vector<Vec3> normals;
        for (const auto &corner : output[i]) normals.push_back(glm::normalize(Vec3(corner[4], corner[5], corner[6])));
        REQUIRE(normals.size() == mesh.cornerCount());
        // A vertex's corners share theirs, which welds them.
        std::map<Index, Vec3> atPosition;
        for (Index c = 0; c < mesh.cornerCount(); ++c)
            normals[c] = atPosition.try_emplace(mesh.cornerPositions[c], normals[c]).first->second;
        const TangentSpace found = tangentSpace(mesh, mesh.positions, normals);
        double greatest = 0;
        for (Index c = 0; c < mesh.cornerCount(); ++c) {
            REQUIRE(found.corners[c] != kNone);
            const Vec4 &t = found.tangents[found.corners[c]];
            const auto &corner = output[i][c];
            greatest = std::max(greatest, static_cast<double>(glm::length(Vec3(t) - Vec3(corner[0], corner[1], corner[2]))));
            CHECK(t.w == corner[3].get<float>());
        }
        std::cout << all[i].name << ": tangents differ by at most " << greatest << std::endl;
        CHECK(greatest < 2e-3);
    }
}
