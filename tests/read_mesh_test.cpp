/// The mesh readers against hand-written files with known numbers, and against the counts that came with real ones.

#include "mesh_samples.h"

#include "taut/formats/read_mesh.h"
#include "taut/formats/write_mesh.h"

#include <iostream>
#include <sstream>

using namespace taut;
using namespace taut::test;

namespace {

/// `said`: what the one warning ends with; empty: there is none.
Mesh read(const std::string &name, const std::string &bytes, const std::string &said = "") {
    Warnings warnings;
    const Mesh mesh = readMesh(writeFile(name, bytes), warnings);
    REQUIRE(warnings.lines.size() == (said.empty() ? 0 : 1));
    if (!said.empty()) CHECK_THAT(warnings.lines[0], Catch::EndsWith(name + ": " + said));
    requireValid(mesh);
    return mesh;
}

const std::string kObjUnread = "not read: 1 'mtllib' (materials come from the scene), 1 vertex colours";
const std::string kPlyUnread = "not read: properties of element 'vertex': 'red'; properties of element 'face': 'flag', 'more'";

const std::vector<Vec3> kPlyPositions{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0.5F, 1.5F, 0.25F}};

void checkPlySample(const Mesh &mesh) {
    CHECK(mesh.positions == kPlyPositions);
    CHECK(mesh.faceOffsets == std::vector<Index>{0, 3, 6, 11});
    CHECK(mesh.cornerPositions == std::vector<Index>{0, 1, 2, 0, 2, 3, 0, 1, 2, 4, 3});
    CHECK(mesh.cornerNormals == mesh.cornerPositions);
    CHECK(mesh.cornerUvs == mesh.cornerPositions);
    CHECK(mesh.normals == std::vector<Vec3>{{0, 0, 1}, {0, 0, 1}, {0, 1, 0}, {0, 0, 1}, {1, 0, 0}});
    CHECK(mesh.uvs == std::vector<Vec2>{{0, 0}, {1, 0}, {1, 1}, {0, 1}, {0.5F, 0.75F}});
    CHECK(mesh.cornerTangents.empty());
    CHECK(mesh.faceMaterials.empty());
}

} // namespace

TEST_CASE("OBJ: every index form, continuation, materials and unit normals", "[mesh][read_mesh][obj]") {
    const Mesh mesh = read("sample.obj", objSample(), kObjUnread);
    CHECK(mesh.name == "sample");
    CHECK(mesh.positions == std::vector<Vec3>{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {2.5F, 0, -1.25F}, {2, 1, 0.5F}});
    CHECK(mesh.faceOffsets == std::vector<Index>{0, 4, 8, 11});
    CHECK(mesh.cornerPositions == std::vector<Index>{0, 1, 2, 3, 1, 4, 5, 2, 0, 1, 2});
    CHECK(mesh.cornerUvs == std::vector<Index>{0, 1, 2, 0, kNone, kNone, kNone, kNone, kNone, kNone, kNone});
    CHECK(mesh.cornerNormals == std::vector<Index>{0, 0, 1, 1, 0, 0, 1, 1, kNone, kNone, kNone});
    CHECK(mesh.uvs == std::vector<Vec2>{{0, 0}, {1, 0.25F}, {0.5F, 0}});
    CHECK(mesh.normals == std::vector<Vec3>{{0, 0, 1}, {0, -1, 0}});
    CHECK(mesh.materialNames == std::vector<std::string>{"brushed steel", "paint"});
    CHECK(mesh.faceMaterials == std::vector<Index>{0, 1, 1});
}

TEST_CASE("OBJ: what a file lacks is empty, what stands before usemtl has a slot of its own", "[mesh][read_mesh][obj]") {
    const Mesh bare = read("bare.obj", "v 0 0 0\r\nv 1 0 0\r\nv 0 1 0\r\nf 1 2 3");
    CHECK(bare.cornerPositions == std::vector<Index>{0, 1, 2});
    CHECK(bare.cornerUvs.empty());
    CHECK(bare.cornerNormals.empty());
    CHECK(bare.faceMaterials.empty());
    CHECK(bare.materialNames.empty());
    const Mesh late = read("late.obj", "f 1 2 3\nusemtl a\nf 3 2 1\nusemtl\nf 1 2 3\nv 0 0 0\nv 1 0 0\nv 0 1 0\n");
    CHECK(late.materialNames == std::vector<std::string>{"", "a"});
    CHECK(late.faceMaterials == std::vector<Index>{0, 1, 0});
}

TEST_CASE("OBJ: a zero normal is no normal, a degenerate face is dropped with a warning", "[mesh][read_mesh][obj]") {
    Warnings warnings;
    const std::string path = writeFile(
        "drop.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 0\nvn 0 3 4\nusemtl m\nf 1//1 2//2 2//2\nusemtl n\nf 1//1 2//2 3//2\nf 1 1 2 2\n");
    const Mesh mesh = readMesh(path, warnings);
    requireValid(mesh);
    REQUIRE(mesh.faceCount() == 1);
    CHECK(mesh.cornerNormals == std::vector<Index>{kNone, 1, 1});
    CHECK(mesh.normals[1].y == Approx(0.6));
    CHECK(mesh.faceMaterials == std::vector<Index>{1});
    REQUIRE(warnings.lines.size() == 1);
    CHECK_THAT(warnings.lines[0], Catch::Contains("dropped 2 of 3 faces"));
}

TEST_CASE("PLY: ASCII and both binary orders give the same mesh", "[mesh][read_mesh][ply]") {
    checkPlySample(read("ascii.ply", plyAsciiSample(), kPlyUnread));
    checkPlySample(read("little.ply", plyBinarySample(false), kPlyUnread));
    checkPlySample(read("big.PLY", plyBinarySample(true), kPlyUnread));
}

TEST_CASE("PLY: the three names of uvs, all index types, no attributes", "[mesh][read_mesh][ply]") {
    const std::pair<const char *, const char *> names[] = {{"s", "t"}, {"u", "v"}, {"texture_u", "texture_v"}};
    for (const auto &[u, v] : names) {
        const Mesh mesh =
            read("uv.ply", std::string("ply\nformat ascii 1.0\nelement vertex 3\nproperty float ") + u + "\nproperty float " + v +
                               "\nproperty float x\nproperty float y\nproperty float z\nelement face 1\nproperty list uchar uint "
                               "vertex_index\nend_header\n"
                               ".25 .5 0 0 0\n1 0 1 0 0\n0 1 0 1 0\n3 0 1 2\n");
        CHECK(mesh.uvs == std::vector<Vec2>{{0.25F, 0.5F}, {1, 0}, {0, 1}});
        CHECK(mesh.normals.empty());
        CHECK(mesh.cornerNormals.empty());
    }
    for (const std::string type : {"char", "uint8", "short", "uint16", "int32", "uint"}) {
        std::string bytes =
            "ply\r\nformat binary_little_endian 1.0\r\nelement vertex 3\r\nproperty float x\r\nproperty float y\r\nproperty float z\r\n"
            "element face 1\r\nproperty list ushort " +
            type + " vertex_indices\r\nend_header\r\n";
        for (int v = 0; v < 3; ++v) appendAll(bytes, {static_cast<float>(v), static_cast<float>(v * v), 1.0F});
        append(bytes, std::uint16_t{3});
        for (int v = 2; v >= 0; --v) {
            if (type == "char" || type == "uint8")
                append(bytes, static_cast<std::uint8_t>(v));
            else if (type == "short" || type == "uint16")
                append(bytes, static_cast<std::uint16_t>(v));
            else
                append(bytes, static_cast<std::uint32_t>(v));
        }
        const Mesh mesh = read("index.ply", bytes);
        CHECK(mesh.positions == std::vector<Vec3>{{0, 0, 1}, {1, 1, 1}, {2, 4, 1}});
        CHECK(mesh.cornerPositions == std::vector<Index>{2, 1, 0});
    }
}

TEST_CASE("OFF: normals, uvs, colours, comments, counts beside the keyword", "[mesh][read_mesh][off]") {
    const Mesh mesh = read("sample.off", offSample(), "not read: 0 vertex colours, 1 face colours");
    CHECK(mesh.positions == kPlyPositions);
    CHECK(mesh.cornerPositions == std::vector<Index>{0, 1, 2, 3, 3, 2, 4});
    CHECK(mesh.faceOffsets == std::vector<Index>{0, 4, 7});
    CHECK(mesh.normals[2] == Vec3(0, 0, 1));
    CHECK(mesh.uvs[4] == Vec2(0.5F, 0.75F));
    const Mesh coloured = read("colour.off", "COFF 3 1 3\n0 0 0 255 0 0 255\n1 0 0 0 1 0 1\n0 1 0 0 0 1 1\n3 0 1 2 0.5 0.5 0.5\n",
                               "not read: 3 vertex colours, 1 face colours");
    CHECK(coloured.positions == std::vector<Vec3>{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}});
    CHECK(coloured.cornerNormals.empty());
}

TEST_CASE("STL: ASCII and binary are welded to the same solid", "[mesh][read_mesh][stl]") {
    for (const Mesh &mesh : {read("ascii.stl", stlAsciiSample()), read("binary.stl", stlBinarySample())}) {
        CHECK(mesh.positions == std::vector<Vec3>{{0, 0, 0}, {0, 1, 0}, {1, 0, 0}, {0, 0, 1}});
        CHECK(mesh.cornerPositions == std::vector<Index>{0, 1, 2, 0, 2, 3, 0, 3, 1, 2, 1, 3});
    }
    // Exact: neighbours in float are not welded.
    std::string close = stlBinarySample();
    const float next = std::nextafter(1.0F, 2.0F);
    std::memcpy(close.data() + 84 + 3 * 50 + 12, &next, sizeof next);
    CHECK(read("close.stl", close).positions.size() == 5);
    // But for what rounding leaves of a zero.
    std::string tiny = stlBinarySample();
    const float residue = -1e-40F;
    std::memcpy(tiny.data() + 84 + 3 * 50 + 12 + 4, &residue, sizeof residue);
    CHECK(read("tiny.stl", tiny).positions.size() == 4);
}

TEST_CASE("STL: triangles without area by welding are dropped with a warning", "[mesh][read_mesh][stl]") {
    std::string bytes = stlBinarySample();
    std::memcpy(bytes.data() + 84 + 24, bytes.data() + 84 + 12, 12);
    Warnings warnings;
    CHECK(readMesh(writeFile("sliver.stl", bytes), warnings).faceCount() == 3);
    REQUIRE(warnings.lines.size() == 1);
    CHECK_THAT(warnings.lines[0], Catch::Contains("dropped 1 of 4 faces"));
}

TEST_CASE("writeObj: what is written comes back bit for bit", "[mesh][write_mesh]") {
    Mesh mesh = read("sample.obj", objSample(), kObjUnread);
    mesh.positions[3] = {1.0F / 3, -1e-30F, std::nextafter(1.0F, 2.0F)};
    const std::string path = outputFolder("mesh") + "/written.obj";
    writeObj(mesh, path);
    Warnings warnings;
    const Mesh back = readMesh(path, warnings);
    CHECK(back.positions == mesh.positions);
    CHECK(back.uvs == mesh.uvs);
    CHECK(back.normals == mesh.normals);
    CHECK(back.faceOffsets == mesh.faceOffsets);
    CHECK(back.cornerPositions == mesh.cornerPositions);
    CHECK(back.cornerUvs == mesh.cornerUvs);
    CHECK(back.cornerNormals == mesh.cornerNormals);
    CHECK(back.faceMaterials == mesh.faceMaterials);
    CHECK(back.materialNames == mesh.materialNames);
    // Folders are made; below a file there can be none.
    CHECK_THROWS_AS(writeObj(mesh, path + "/below_a_file.obj"), RunError);
}

TEST_CASE("Sequences: the topology of a later frame must be that of the first", "[mesh][read_mesh][sequence]") {
    const Mesh first = read("frame1.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\nf 1 3 4\n");
    const std::string positions = "v 0 0 5\nv 1 0 5\nv 0 1 5\nv 0 0 6\n";
    CHECK(readSequencePositions(writeFile("frame2.obj", positions + "f 1 2 3\nf 1 3 4\n"), first) ==
          std::vector<Vec3>{{0, 0, 5}, {1, 0, 5}, {0, 1, 5}, {0, 0, 6}});
    CHECK_THROWS_WITH(readSequencePositions(writeFile("frame3.obj", positions + "v 0 0 7\nf 1 2 3\nf 1 3 4\n"), first),
                      Catch::Contains("frame3.obj: found 5 positions, expected 4"));
    CHECK_THROWS_WITH(readSequencePositions(writeFile("frame4.obj", positions + "f 1 2 3\n"), first),
                      Catch::Contains("found 1 faces, expected 2"));
    CHECK_THROWS_WITH(readSequencePositions(writeFile("frame5.obj", positions + "f 1 2 3\nf 1 3 2\n"), first),
                      Catch::Contains("other corners in face 1"));
}

TEST_CASE("Extensions of meshes, in any case", "[mesh][read_mesh]") {
    for (const char *path : {"a.obj", "dir.x/b.PLY", "c.Off", "d.stl"}) CHECK(isMeshPath(path));
    for (const char *path : {"a.glb", "obj", "a.obj.txt", "", "dir.obj/file"}) CHECK_FALSE(isMeshPath(path));
}

TEST_CASE("Reading prints nothing", "[mesh][read_mesh]") {
    std::ostringstream printed;
    std::streambuf *const out = std::cout.rdbuf(printed.rdbuf());
    std::streambuf *const err = std::cerr.rdbuf(printed.rdbuf());
    std::streambuf *const log = std::clog.rdbuf(printed.rdbuf());
    Warnings warnings;
    readMesh(writeFile("quiet.ply", plyAsciiSample()), warnings);
    readMesh(writeFile("quiet.stl", stlAsciiSample()), warnings);
    readMesh(writeFile("quiet.off", offSample()), warnings);
    std::cout.rdbuf(out);
    std::cerr.rdbuf(err);
    std::clog.rdbuf(log);
    CHECK(printed.str().empty());
}

TEST_CASE("Real OBJ files have the counts that their list states", "[mesh][read_mesh][assets]") {
    struct Counts {
        const char *file;
        std::size_t positions, triangles, quads, larger, uvs, normals;
    };
    constexpr Counts kFiles[] = {
        {"static/spot_control_mesh.obj", 188, 4, 160, 16, 267, 0},
        {"static/spot_low_resolution.obj", 829, 1654, 0, 0, 0, 1654},
        {"static/penguin_control_mesh.obj", 201, 48, 169, 4, 0, 0},
        {"static/hand_lowres.obj", 810, 1602, 0, 0, 0, 0},
        {"static/goathead.obj", 2763, 5522, 0, 0, 0, 0},
        {"static/wingnut.obj", 3047, 6090, 0, 0, 0, 0},
        {"subd/shapes/catmark_cube.obj", 8, 0, 6, 0, 14, 24},
        {"subd/shapes/catmark_cube_creases0.obj", 8, 0, 6, 0, 14, 24},
        {"subd/shapes/catmark_torus.obj", 32, 0, 32, 0, 45, 0},
        {"subd/shapes/catmark_torus_creases0.obj", 32, 0, 32, 0, 4, 0},
        {"subd/shapes/catmark_tent_creases0.obj", 16, 0, 9, 0, 16, 36},
        {"subd/shapes/catmark_dart_edgecorner.obj", 25, 0, 16, 0, 25, 0},
        {"subd/shapes/catmark_pyramid_creases1.obj", 5, 4, 1, 0, 5, 0},
        {"subd/shapes/catmark_helmet.obj", 72, 0, 58, 0, 4, 0},
        {"subd/shapes/catmark_pawn.obj", 601, 0, 588, 0, 4, 0},
        {"subd/baseline/catmark_cube_level0.obj", 26, 0, 24, 0, 0, 0},
        {"subd/baseline/catmark_cube_level1.obj", 98, 0, 96, 0, 0, 0},
        {"subd/baseline/catmark_cube_level2.obj", 386, 0, 384, 0, 0, 0},
        {"subd/baseline/catmark_cube_creases0_level0.obj", 26, 0, 24, 0, 0, 0},
        {"subd/baseline/catmark_cube_creases0_level1.obj", 98, 0, 96, 0, 0, 0},
        {"subd/baseline/catmark_cube_creases0_level2.obj", 386, 0, 384, 0, 0, 0},
        {"subd/baseline/catmark_tent_creases0_level0.obj", 49, 0, 36, 0, 0, 0},
        {"subd/baseline/catmark_tent_creases0_level1.obj", 169, 0, 144, 0, 0, 0},
        {"subd/baseline/catmark_tent_creases0_level2.obj", 625, 0, 576, 0, 0, 0},
        {"subd/baseline/catmark_dart_edgecorner_level0.obj", 81, 0, 64, 0, 0, 0},
        {"subd/baseline/catmark_dart_edgecorner_level1.obj", 289, 0, 256, 0, 0, 0},
        {"subd/baseline/catmark_dart_edgecorner_level2.obj", 1089, 0, 1024, 0, 0, 0},
        {"subd/baseline/catmark_pyramid_creases1_level0.obj", 18, 0, 16, 0, 0, 0},
        {"subd/baseline/catmark_pyramid_creases1_level1.obj", 66, 0, 64, 0, 0, 0},
        {"subd/baseline/catmark_pyramid_creases1_level2.obj", 258, 0, 256, 0, 0, 0},
        {"seq/kick_obj/kick.0000.obj", 12811, 25472, 0, 0, 0, 0},
    };
    for (const Counts &counts : kFiles) {
        const auto path = asset(counts.file);
        if (!path) continue;
        CAPTURE(counts.file);
        Warnings warnings;
        const Mesh mesh = readMesh(*path, warnings);
        requireValid(mesh);
        for (const std::string &line : warnings.lines) CHECK_THAT(line, Catch::Contains(": not read: "));
        std::size_t sizes[3] = {};
        for (std::size_t f = 0; f < mesh.faceCount(); ++f)
            ++sizes[std::min<std::size_t>(mesh.faceOffsets[f + 1] - mesh.faceOffsets[f], 5) - 3];
        CHECK(mesh.positions.size() == counts.positions);
        CHECK(sizes[0] == counts.triangles);
        CHECK(sizes[1] == counts.quads);
        CHECK(sizes[2] == counts.larger);
        CHECK(mesh.uvs.size() == counts.uvs);
        CHECK(mesh.normals.size() == counts.normals);
    }
}

TEST_CASE("A real sequence keeps its topology and moves", "[mesh][read_mesh][assets][sequence]") {
    const auto firstPath = asset("seq/kick_obj/kick.0000.obj");
    if (!firstPath) return;
    Warnings warnings;
    const Mesh first = readMesh(*firstPath, warnings);
    for (const char *frame : {"0003", "0006", "0009", "0012"}) {
        const auto path = asset(std::string("seq/kick_obj/kick.") + frame + ".obj");
        if (!path) continue;
        const std::vector<Vec3> positions = readSequencePositions(*path, first);
        CHECK(positions.size() == 12811);
        CHECK(positions != first.positions);
    }
}
