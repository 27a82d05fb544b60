/// The project's own meshes (meshes/*.obj): made again with the same bytes, closed where they should be, normals and uvs right.

#include "assets.h"
#include "mesh_fixtures.h"

#include "taut/formats/read_mesh.h"

#include <cstdlib>
#include <fstream>
#include <iostream>
#include <iterator>
#include <set>

using namespace taut;
using namespace taut::test;

namespace {

struct OwnMesh {
    const char *file;
    bool closed;
    std::size_t positions;
    std::size_t faces;
    double area;   ///< m^2, of open sheets
    float maxTurn; ///< largest sine between a corner's normal and its face's
};

const OwnMesh kMeshes[] = {
    {"panel.obj", false, 97 * 97, 96 * 96, 4, 1e-6F}, {"plate.obj", false, 33 * 33, 32 * 32, 1, 1e-6F},
    {"ground.obj", false, 4, 1, 1600, 1e-6F},         {"body.obj", true, 79 * 128 + 2, 80 * 128, 0, 0.07F},
    {"ring.obj", true, 40 * 128, 40 * 128, 0, 0.25F}, {"twist_bar.obj", true, 97 * 40 + 2, 98 * 40, 0, 0.30F},
};

std::string pathOf(const char *file) {
    return std::string(TAUT_SOURCE_DIR) + "/meshes/" + file;
}

Mesh read(const char *file) {
    Warnings warnings;
    Mesh mesh = readMesh(pathOf(file), warnings);
    CHECK(warnings.lines.empty());
    return mesh;
}

std::string bytesOf(const std::string &path) {
    std::ifstream in(path, std::ios::binary);
    REQUIRE(in);
    return {std::istreambuf_iterator<char>(in), {}};
}

/// Vector area of a face: its normal times its area.
DVec3 vectorArea(const Mesh &mesh, std::size_t f) {
    DVec3 sum(0);
    const DVec3 first(mesh.positions[mesh.cornerPositions[mesh.faceOffsets[f]]]);
    for (Index c = mesh.faceOffsets[f] + 1; c + 1 < mesh.faceOffsets[f + 1]; ++c)
        sum += 0.5 * glm::cross(DVec3(mesh.positions[mesh.cornerPositions[c]]) - first,
                                DVec3(mesh.positions[mesh.cornerPositions[c + 1]]) - first);
    return sum;
}

double signedUvArea(const Mesh &mesh, std::size_t f) {
    double sum = 0;
    const DVec2 first(mesh.uvs[mesh.cornerUvs[mesh.faceOffsets[f]]]);
    for (Index c = mesh.faceOffsets[f] + 1; c + 1 < mesh.faceOffsets[f + 1]; ++c) {
        const DVec2 a = DVec2(mesh.uvs[mesh.cornerUvs[c]]) - first;
        const DVec2 b = DVec2(mesh.uvs[mesh.cornerUvs[c + 1]]) - first;
        sum += 0.5 * (a.x * b.y - a.y * b.x);
    }
    return sum;
}

/// The direction in which u grows on a face, from its first three corners (not normalised).
DVec3 alongU(const Mesh &mesh, std::size_t f) {
    const Index c = mesh.faceOffsets[f];
    const auto position = [&](Index i) { return DVec3(mesh.positions[mesh.cornerPositions[i]]); };
    const auto uv = [&](Index i) { return DVec2(mesh.uvs[mesh.cornerUvs[i]]); };
    const DVec2 d1 = uv(c + 1) - uv(c);
    const DVec2 d2 = uv(c + 2) - uv(c);
    return ((position(c + 1) - position(c)) * d2.y - (position(c + 2) - position(c)) * d1.y) / (d1.x * d2.y - d1.y * d2.x);
}

} // namespace

TEST_CASE("The meshes are what their script makes, byte for byte", "[meshes]") {
    if (std::system("python3 -c pass > /dev/null 2>&1") != 0) {
        std::cout << "SKIPPED: there is no python3 on this machine to make the meshes again" << std::endl;
        return;
    }
    const std::string folder = outputFolder("meshes");
    const std::string command = "python3 '" + pathOf("make_meshes.py") + "' '" + folder + "' > /dev/null";
    REQUIRE(std::system(command.c_str()) == 0);
    for (const OwnMesh &own : kMeshes) {
        INFO(own.file);
        CHECK((bytesOf(folder + "/" + own.file) == bytesOf(pathOf(own.file)))); // no dump of a megabyte where they differ
    }
}

TEST_CASE("The meshes are closed, outward and as large as they say", "[meshes]") {
    for (const OwnMesh &own : kMeshes) {
        INFO(own.file);
        const Mesh mesh = read(own.file);
        CHECK(mesh.positions.size() == own.positions);
        CHECK(mesh.faceCount() == own.faces);
        // Every edge is walked once each way or is a boundary: consistently oriented.
        for (const auto &[edge, uses] : directedEdges(mesh)) REQUIRE(uses == 1);
        CHECK(isWatertight(mesh) == own.closed);
        CHECK(std::set<Index>(mesh.cornerPositions.begin(), mesh.cornerPositions.end()).size() == mesh.positions.size());
        if (own.closed) {
            const long euler = static_cast<long>(mesh.positions.size() + mesh.faceCount()) - static_cast<long>(edgeCount(mesh));
            CHECK(euler == (std::string(own.file) == "ring.obj" ? 0 : 2));
        } else {
            double area = 0;
            for (std::size_t f = 0; f < mesh.faceCount(); ++f) area += vectorArea(mesh, f).z;
            CHECK(area == Approx(own.area).epsilon(1e-5));
        }
    }
}

TEST_CASE("The turned meshes enclose what their profile does", "[meshes]") {
    // A superellipse |x/a|^p + |y/b|^p = 1 has the area 4 a b Gamma(1 + 1/p)^2 / Gamma(1 + 2/p). Chords cut a little off.
    const auto area = [](double a, double b, double p) { return 4 * a * b * sqr(std::tgamma(1 + 1 / p)) / std::tgamma(1 + 2 / p); };
    CHECK(signedVolume(read("twist_bar.obj")) == Approx(2 * area(0.25, 0.25, 5)).epsilon(0.01));
    CHECK(signedVolume(read("ring.obj")) == Approx(2 * 3.141592653589793 * area(0.16, 0.09, 4)).epsilon(0.01)); // Pappus
    // The body: pi times the integral of r(z)^2, r = 0.62 (1 - |z|^2.6)^(1/2.6) (1 - 0.36 exp(-((z - 0.28)/0.34)^2)).
    double volume = 0;
    for (int k = 0; k < 20000; ++k) {
        const double z = -1 + (k + 0.5) / 10000;
        volume += 3.141592653589793 *
                  sqr(0.62 * std::pow(1 - std::pow(std::fabs(z), 2.6), 1 / 2.6) * (1 - 0.36 * std::exp(-sqr((z - 0.28) / 0.34)))) / 10000;
    }
    CHECK(signedVolume(read("body.obj")) == Approx(volume).epsilon(0.01));
}

TEST_CASE("Unit normals stand on their faces", "[meshes]") {
    for (const OwnMesh &own : kMeshes) {
        INFO(own.file);
        const Mesh mesh = read(own.file);
        REQUIRE(mesh.cornerNormals.size() == mesh.cornerCount());
        for (const Vec3 &n : mesh.normals) REQUIRE(std::fabs(glm::length(n) - 1) < 2e-6F);
        float largest = 0;
        for (std::size_t f = 0; f < mesh.faceCount(); ++f) {
            const Vec3 faceNormal(glm::normalize(vectorArea(mesh, f)));
            for (Index c = mesh.faceOffsets[f]; c < mesh.faceOffsets[f + 1]; ++c) {
                const Vec3 n = mesh.normals[mesh.cornerNormals[c]];
                REQUIRE(glm::dot(n, faceNormal) > 0.9F);
                largest = std::max(largest, glm::length(glm::cross(n, faceNormal)));
            }
        }
        CHECK(largest < own.maxTurn);
    }
}

TEST_CASE("UVs keep their handedness and u runs along the brushing", "[meshes]") {
    for (const OwnMesh &own : kMeshes) {
        INFO(own.file);
        const Mesh mesh = read(own.file);
        REQUIRE(mesh.cornerUvs.size() == mesh.cornerCount());
        for (const Vec2 &uv : mesh.uvs) REQUIRE((uv.x >= 0 && uv.x <= 1 && uv.y >= 0 && uv.y <= 1));
        const std::string name = own.file;
        for (std::size_t f = 0; f < mesh.faceCount(); ++f) {
            REQUIRE(signedUvArea(mesh, f) > 0);
            const DVec3 normal = glm::normalize(vectorArea(mesh, f));
            const DVec3 centre = DVec3(mesh.positions[mesh.cornerPositions[mesh.faceOffsets[f]]] +
                                       mesh.positions[mesh.cornerPositions[mesh.faceOffsets[f] + 1]]) /
                                 2.0;
            DVec3 brushed(1, 0, 0); // sheets, and the bar's ends
            if (name == "body.obj" || name == "ring.obj")
                brushed = glm::normalize(DVec3(-centre.y, centre.x, 0));
            else if (name == "twist_bar.obj" && std::fabs(normal.z) < 0.5)
                brushed = DVec3(0, 0, 1);
            REQUIRE(std::fabs(glm::dot(glm::normalize(alongU(mesh, f)), brushed)) > 0.99);
        }
    }
}
