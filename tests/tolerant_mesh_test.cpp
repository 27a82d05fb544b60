/// Mesh files as programs write them, and as their formats do not: byte order marks, ends of lines, keywords and properties of others,
/// numbers that are none. The picture is the same, or one line says what is missing.

#include "mesh_samples.h"

#include <bit>

using namespace taut;
using namespace taut::test;

namespace {

struct Loaded {
    Mesh mesh;
    std::vector<std::string> said;
};

Loaded loadPath(const std::string &path) {
    Warnings warnings;
    Loaded loaded{readMesh(path, warnings), {}};
    loaded.said = warnings.lines;
    requireValid(loaded.mesh);
    return loaded;
}

Loaded load(const std::string &name, const std::string &bytes) {
    return loadPath(writeFile(name, bytes));
}

std::string withLineEnds(const std::string &text, const std::string &end) {
    std::string out;
    for (const char c : text) out += c == '\n' ? end : std::string(1, c);
    return out;
}

void checkSame(const Mesh &a, const Mesh &b) {
    CHECK(a.positions == b.positions);
    CHECK(a.normals == b.normals);
    CHECK(a.uvs == b.uvs);
    CHECK(a.faceOffsets == b.faceOffsets);
    CHECK(a.cornerPositions == b.cornerPositions);
    CHECK(a.cornerNormals == b.cornerNormals);
    CHECK(a.cornerUvs == b.cornerUvs);
    CHECK(a.faceMaterials == b.faceMaterials);
}

const std::string kMark = "\xef\xbb\xbf";
const std::string kQuad = "v -1 0 -1\nv 1 0 -1\nv 1 0 1\nv -1 0 1\n";

std::string plyOf(const std::string &elements, const std::string &body) {
    return "ply\nformat ascii 1.0\n" + elements + "end_header\n" + body;
}
const std::string kPlyQuad = "element vertex 4\nproperty float x\nproperty float y\nproperty float z\n";
const std::string kPlyFace = "element face 1\nproperty list uchar int vertex_indices\n";
const std::string kPlyCorners = "0 0 0\n1 0 0\n1 1 0\n0 1 0\n";

} // namespace

TEST_CASE("A byte order mark and any ends of lines make the same mesh", "[mesh][tolerant]") {
    const std::pair<const char *, std::string> samples[] = {
        {"ends.obj", objSample()}, {"ends.off", offSample()}, {"ends.stl", stlAsciiSample()}, {"ends.ply", plyAsciiSample()}};
    for (const auto &[name, text] : samples) {
        CAPTURE(name);
        const Loaded plain = load(name, text);
        for (const std::string end : {"\r", "\r\n", "\n\n", "\r\r\n"}) {
            if (end.size() > 1 && std::string(name) == "ends.obj" && end != "\r\n") continue; // it joins lines
            CAPTURE(quoted(end));
            const Loaded other = load(name, kMark + withLineEnds(text, end));
            checkSame(other.mesh, plain.mesh);
            CHECK(other.said == plain.said);
        }
    }
    // Of a binary PLY with a header of CR alone, a body that begins with a LF is whole.
    std::string header = plyOf(kPlyQuad + kPlyFace, "");
    header.replace(header.find("ascii"), 5, "binary_little_endian");
    std::string body;
    const std::uint32_t first = 0x3f80000aU; // its first byte is a LF
    append(body, first);
    for (int i = 1; i < 12; ++i) append(body, static_cast<float>(i * i));
    body += std::string("\4\0\0\0\0\1\0\0\0\2\0\0\0\3\0\0\0", 17);
    const Loaded lf = load("cr.ply", header + body);
    for (const std::string end : {"\r", "\r\n"}) checkSame(load("cr.ply", withLineEnds(header, end) + body).mesh, lf.mesh);
    CHECK(lf.mesh.positions[0].x == std::bit_cast<float>(first));
    // Lines are counted alike, and places within the first are behind the mark.
    CHECK_THAT(errorOf("ends.obj", kMark + "v 0 0 x\r"), Catch::Contains("ends.obj:1:7: found 'x'"));
    CHECK_THAT(errorOf("ends.obj", "v 0 0 0\rv 1 0 0\r\nv 0 y 0\n"), Catch::Contains("ends.obj:3:5: found 'y'"));
    CHECK_THAT(errorOf("ends.obj", "\xff\xfev\0 \0"), Catch::Contains("UTF-16"));
    CHECK(errorOf("mark.gltf", kMark + gltfSample().gltf()).empty());
}

TEST_CASE("The case of a byte order mark", "[mesh][tolerant][cases]") {
    if (const auto path = caseFile("bom/a.obj")) CHECK(loadPath(*path).mesh.cornerPositions == std::vector<Index>{0, 1, 2, 3});
}

TEST_CASE("Normals and texture coordinates that are no numbers count as missing", "[mesh][tolerant]") {
    if (const auto path = caseFile("nan-normal/a.obj")) {
        const Loaded loaded = loadPath(*path);
        CHECK(loaded.mesh.faceCount() == 1);
        CHECK(loaded.mesh.cornerNormals.empty());
        REQUIRE(loaded.said.size() == 1);
        CHECK_THAT(loaded.said[0], Catch::EndsWith(": 1 of 1 normals are not finite and count as missing, at 4 of 4 corners"));
    }
    // In each spelling; a corner of another face keeps what it has.
    for (const std::string nan : {"nan", "-nan(ind)", "-1.#IND", "1.#QNAN", "1.#INF", "inf", "-inf", "1e99"}) {
        CAPTURE(nan);
        const Loaded loaded =
            load("nan.obj", kQuad + "vn 0 -1 0\nvn 0 " + nan + " 1\nvt 0 0\nvt " + nan + " 1\nf 1/1/1 2/2/2 3/1/1\nf 1/1/1 3/1/1 4/1/1\n");
        CHECK(loaded.mesh.cornerNormals == std::vector<Index>{0, kNone, 0, 0, 0, 0});
        CHECK(loaded.mesh.cornerUvs == std::vector<Index>{0, kNone, 0, 0, 0, 0});
        CHECK(std::isfinite(loaded.mesh.uvs[1].x));
        REQUIRE(loaded.said.size() == 2);
        CHECK_THAT(loaded.said[0], Catch::EndsWith(": 1 of 2 normals are not finite and count as missing, at 1 of 6 corners"));
        CHECK_THAT(loaded.said[1], Catch::EndsWith(": 1 of 2 texture coordinates are not finite and count as missing, at 1 of 6 corners"));
    }
    const Loaded off = load("nan.off", "NOFF\n3 1 0\n0 0 0 0 0 1\n1 0 0 nan 0 0\n0 1 0 0 0 1\n3 0 1 2\n");
    CHECK(off.mesh.cornerNormals == std::vector<Index>{0, kNone, 2});
    CHECK(off.said.size() == 1);
    std::string binary = plyBinarySample(false);
    const std::size_t normal = binary.find("end_header\n") + 11 + 25; // of the first vertex, behind its position and a byte
    const float infinite = std::numeric_limits<float>::infinity();
    std::memcpy(binary.data() + normal, &infinite, sizeof infinite);
    CHECK(load("nan.ply", binary).mesh.cornerNormals == std::vector<Index>{kNone, 1, 2, kNone, 2, 3, kNone, 1, 2, 4, 3});
    // A position is the picture itself.
    CHECK_THAT(errorOf("nan.off", "OFF\n3 1 0\n0 0 nan\n1 0 0\n0 1 0\n3 0 1 2\n"), Catch::Contains("nan.off:3:5: found 'nan'"));
}

TEST_CASE("OFF: counts at the end of the keyword", "[mesh][tolerant][off]") {
    const std::string rest = " 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
    checkSame(load("glued.off", "OFF3" + rest).mesh, load("glued.off", "OFF\n3" + rest).mesh);
    CHECK_THAT(errorOf("glued.off", "OFF3x" + rest), Catch::Contains("glued.off:1:1: found '3x'"));
}

TEST_CASE("Keywords that are not read are counted by name", "[mesh][tolerant][obj]") {
    const Loaded loaded =
        load("words.obj", "mtllib a.mtl\nvcolor 1\n" + kQuad + "vcolor 2\nl 1 2\no name\ng group\nf 1 2 3 4\nline 1\n\x01\x02\n");
    CHECK(loaded.mesh.faceCount() == 1);
    REQUIRE(loaded.said.size() == 1);
    CHECK_THAT(loaded.said[0],
               Catch::EndsWith(": not read: 1 'mtllib' (materials come from the scene), 2 'vcolor', 1 'l', 1 'line', 1 '\\x01\\x02'"));
    // Smoothing groups say something only where there are no normals.
    CHECK(load("smooth.obj", kQuad + "s 1\nvn 0 -1 0\nf 1//1 2//1 3//1 4//1\n").said.empty());
    REQUIRE(load("smooth.obj", kQuad + "s 1\nf 1 2 3 4\n").said.size() == 1);
    std::string many = kQuad + "f 1 2 3 4\n";
    for (int i = 0; i < 1000; ++i) many += "word" + std::to_string(i) + "\n";
    REQUIRE(load("many.obj", many).said.size() == 1);
    CHECK_THAT(load("many.obj", many).said[0], Catch::EndsWith(" and 984 of other keywords"));
}

TEST_CASE("Bytes behind the end are counted", "[mesh][tolerant]") {
    if (const auto path = caseFile("stl-trailing/a.stl")) {
        const Loaded loaded = loadPath(*path);
        CHECK(loaded.mesh.faceCount() == 2);
        REQUIRE(loaded.said.size() == 1);
        CHECK_THAT(loaded.said[0], Catch::Contains("triangles were not read"));
    }
    for (const std::string head : {"solid", "a.exe"}) { // a binary header may begin with either
        std::string bytes = stlBinarySample();
        bytes.replace(0, 5, head);
        const Mesh plain = load("tail.stl", bytes).mesh;
        for (const std::string &tail : {std::string(1, '\0'), std::string("\r\n"), std::string(1000, 'x')}) {
            const Loaded loaded = load("tail.stl", bytes + tail);
            checkSame(loaded.mesh, plain);
            REQUIRE(loaded.said.size() == 1);
            CHECK_THAT(loaded.said[0],
                       Catch::EndsWith(": " + std::to_string(tail.size()) + " bytes that follow its 4 triangles were not read"));
        }
    }
    const Loaded ascii = load("tail.stl", stlAsciiSample() + std::string("\n\x1a\0\0", 4));
    CHECK(ascii.mesh.faceCount() == 4);
    REQUIRE(ascii.said.size() == 1);
    CHECK_THAT(ascii.said[0], Catch::EndsWith(": 3 bytes that follow the last 'endsolid' were not read"));

    const std::string glb = gltfSample().glb();
    Warnings warnings;
    const std::size_t before = (readGltf(writeFile("tail.glb", glb), warnings), warnings.lines.size());
    readGltf(writeFile("tail.glb", glb + "trailing"), warnings);
    REQUIRE(warnings.lines.size() == before + 1);
    CHECK_THAT(warnings.lines.back(), Catch::EndsWith(": 8 bytes that follow the length in its header were not read"));
    std::string within = glb + "xyz";
    const auto length = static_cast<std::uint32_t>(within.size());
    std::memcpy(within.data() + 8, &length, sizeof length);
    readGltf(writeFile("tail.glb", within), warnings);
    CHECK_THAT(warnings.lines.back(), Catch::EndsWith(": 3 bytes that follow the last chunk were not read"));
}

TEST_CASE("PLY: texture coordinates of the corners of a face", "[mesh][tolerant][ply]") {
    const std::string faces = "element face 3\nproperty list uchar int vertex_indices\nproperty list uchar float texcoord\n";
    const Loaded loaded = load("wedge.ply", plyOf(kPlyQuad + faces, kPlyCorners + "3 0 1 2 6 0 0 1 0 1 1\n3 0 2 3 0\n3 1 2 3 4 9 9 9 9\n"));
    CHECK(loaded.mesh.uvs == std::vector<Vec2>{{0, 0}, {1, 0}, {1, 1}});
    CHECK(loaded.mesh.cornerUvs == std::vector<Index>{0, 1, 2, kNone, kNone, kNone, kNone, kNone, kNone});
    REQUIRE(loaded.said.size() == 1);
    CHECK_THAT(loaded.said[0], Catch::Contains("1 faces have a list texcoord of another length"));
    // Before the indices, binary, beside coordinates of the vertices, which they overrule.
    std::string binary = "ply\nformat binary_big_endian 1.0\ncomment TextureFile a b.png\n" + kPlyQuad +
                         "property float s\nproperty float t\nelement face 1\nproperty list uchar double texcoord\n"
                         "property int texnumber\nproperty list uchar short vertex_indices\nend_header\n";
    for (int v = 0; v < 4; ++v) appendAll(binary, {static_cast<float>(v), static_cast<float>(v * v), 0.0F, 0.0F, 0.0F}, true);
    append(binary, std::uint8_t{6});
    appendAll(binary, {0.5, 0.25, 0.75, 0.125, 1.0, 0.0}, true);
    append(binary, std::int32_t{0}, true);
    append(binary, std::uint8_t{3});
    appendAll<std::int16_t>(binary, {0, 1, 3}, true);
    const Loaded big = load("wedge.ply", binary);
    CHECK(big.mesh.uvs == std::vector<Vec2>{{0.5F, 0.25F}, {0.75F, 0.125F}, {1, 0}});
    CHECK(big.mesh.cornerUvs == std::vector<Index>{0, 1, 2});
    REQUIRE(big.said.size() == 1);
    CHECK_THAT(big.said[0], Catch::EndsWith(": not read: properties of element 'face': 'texnumber'; texture 'a b.png' of a comment"));
}

TEST_CASE("PLY: triangle strips", "[mesh][tolerant][ply]") {
    const std::string strips = "element tristrips 1\nproperty list int int vertex_indices\n";
    // Two strips; 1 1 stitches without a triangle of its own.
    const Loaded loaded = load("strips.ply", plyOf("element vertex 5\nproperty float x\nproperty float y\nproperty float z\n" + strips,
                                                   kPlyCorners + "2 0 1\n9 0 1 3 2 -1 1 4 4 2\n"));
    CHECK(loaded.mesh.cornerPositions == std::vector<Index>{0, 1, 3, 3, 1, 2});
    CHECK(loaded.mesh.faceOffsets == std::vector<Index>{0, 3, 6});
    CHECK(loaded.said.empty());
    // As one strip with a swap in it, and after faces.
    const Loaded both = load("strips.ply", plyOf(kPlyQuad + kPlyFace + strips, kPlyCorners + "3 0 1 2\n5 0 1 3 3 2\n"));
    CHECK(both.mesh.cornerPositions == std::vector<Index>{0, 1, 2, 0, 1, 3});
    CHECK_THAT(errorOf("strips.ply", plyOf(kPlyQuad + strips, kPlyCorners + "3 0 1 4\n")), Catch::Contains("vertex index 4"));
    CHECK_THAT(errorOf("strips.ply", plyOf(kPlyQuad + strips, kPlyCorners + "3 0 1 -2\n")), Catch::Contains("vertex index -2"));
}

TEST_CASE("PLY: values over several lines, or several elements on one", "[mesh][tolerant][ply]") {
    const std::string header = kPlyQuad + kPlyFace;
    const Mesh plain = load("lines.ply", plyOf(header, kPlyCorners + "4 0 1 2 3\n")).mesh;
    for (const std::string body : {"0 0 0 1 0 0 1 1 0 0 1 0 4 0 1 2 3\n", "0 0 0\n1 0\n0\n1 1 0\n0 1 0\n4 0 1\n2 3\n",
                                   "0\n0\n0\n1\n0\n0\n1\n1\n0\n0\n1\n0\n4\n0\n1\n2\n3"}) {
        CAPTURE(body);
        const Loaded loaded = load("lines.ply", plyOf(header, body));
        checkSame(loaded.mesh, plain);
        CHECK(loaded.said.empty());
    }
    // One value too few or too many is no wrapped line: it is named where it is missing.
    CHECK_THAT(errorOf("lines.ply", plyOf(header, "0 0 0\n1 0\n1 1 0\n0 1 0\n4 0 1 2 3\n")),
               Catch::Contains("lines.ply:11:4: found the end of the line"));
    CHECK_THAT(errorOf("lines.ply", plyOf(header, "0 0 0\n1 0 0 7\n1 1 0\n0 1 0\n4 0 1 2 3\n")),
               Catch::Contains("lines.ply:11:7: found '7'"));
}

TEST_CASE("PLY: elements and properties of others are skipped and named", "[mesh][tolerant][ply]") {
    const std::string edges = "element edge 2\nproperty int vertex1\nproperty int vertex2\nproperty list uchar float weights\n";
    const Loaded loaded = load("edges.ply", plyOf(edges + kPlyQuad + "property uchar red\n" + kPlyFace,
                                                  "0 1 2 0.5 0.5\n1 2 0\n0 0 0 9\n1 0 0 9\n1 1 0 9\n0 1 0 9\n4 0 1 2 3\n"));
    CHECK(loaded.mesh.cornerPositions == std::vector<Index>{0, 1, 2, 3});
    REQUIRE(loaded.said.size() == 1);
    CHECK_THAT(loaded.said[0], Catch::EndsWith(": not read: 2 of element 'edge'; properties of element 'vertex': 'red'"));
}
