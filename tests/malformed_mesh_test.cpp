/// Broken files, one mistake each: it is named with its place, what was found and what was expected, on one line.

#include "mesh_samples.h"

#include <functional>

using namespace taut;
using namespace taut::test;

namespace {

/// A file, and what its error must hold: first its place, right after the file's name.
struct MeshCase {
    std::string bytes;
    std::string place;
    std::vector<std::string> says;
};

void checkCases(const std::string &name, const std::vector<MeshCase> &cases) {
    for (const MeshCase &c : cases) {
        const std::string error = errorOf(name, c.bytes);
        CAPTURE(c.bytes.substr(0, 400), error);
        CHECK_THAT(error, Catch::StartsWith(outputFolder("mesh") + "/" + name + c.place));
        for (const std::string &said : c.says) CHECK_THAT(error, Catch::Contains(said));
        CHECK(error.find('\n') == std::string::npos);
    }
}

const std::string kBareTriangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";

} // namespace

TEST_CASE("Malformed OBJ", "[mesh][malformed][obj]") {
    checkCases("bad.obj", {
                              {"v 0 0 zero\n", ":1:7: ", {"'zero'", "a coordinate"}},
                              {"v 0 0\nv 1 0 0\n", ":1:6: ", {"the end of the line", "a coordinate"}},
                              {"v 0 0", ":1:6: ", {"the end of the file"}},
                              {"v 0 1e99 0\n", ":1:5: ", {"'1e99'", "finite"}},
                              {"v 0 0 nan\n", ":1:7: ", {"'nan'", "finite"}},
                              {"v 0 0 0 red\n", ":1:9: ", {"'red'"}},
                              {"vt\n", ":1:3: ", {"the end of the line"}},
                              {"vn 0 0 1 1\n", ":1:10: ", {"'1'", "the end of the line"}},
                              {kBareTriangle + "f 1 2\n", ":4:6: ", {"a face of 2 corners", "at least 3"}},
                              {kBareTriangle + "f 1 2 0\n", ":4:7: ", {"index '0'", "1 to 3 or -3 to -1"}},
                              {kBareTriangle + "f 1 2 4\nv 0 0 0 # too late? no: read after\nf 1 2 9\n",
                               ":6:7: ",
                               {"index '9' of a position", "1 to 4 or -4 to -1"}},
                              {kBareTriangle + "f 1 2 -4\n", ":4:7: ", {"index '-4'"}},
                              {kBareTriangle + "f 1/1 2 3\n", ":4:5: ", {"index '1' of a texture coordinate", "the file has none"}},
                              {kBareTriangle + "vn 0 0 1\nf 1//1 2//1 3//2\n", ":5:16: ", {"index '2' of a normal"}},
                              {kBareTriangle + "f 1/2/3/4 2 3\n", ":4:8: ", {"'/4'", "at most three"}},
                              {kBareTriangle + "f 1 2 x3\n", ":4:7: ", {"'x3'", "1/2/3"}},
                              {kBareTriangle + "f 1 2 \\\n 3.5\n", ":5:2: ", {"'3.5'"}},
                              {kBareTriangle + "f 1 2 99999999999999999999\n", ":4:7: ", {"'99999999999999999999'"}},
                              {kBareTriangle, ": ", {"found no face"}},
                              {kBareTriangle + "f 1 1 2\n", ": ", {"found no face"}},
                              {"", ": ", {"found no face"}},
                              {std::string("v 0 0 \0\n", 8), ":1:7: ", {"'\\x00'"}},
                              {"v 0 0 " + std::string(5000, 'x') + "\n", ":1:7: ", {"xxx...xxx"}},
                          });
}

TEST_CASE("Malformed PLY", "[mesh][malformed][ply]") {
    const std::string ascii = plyAsciiSample();
    const std::string binary = plyBinarySample(false);
    const auto body = static_cast<std::int64_t>(binary.find("end_header\n")) + 11;
    const std::int64_t vertex = 8 * 3 + 1 + 4 * 5; // bytes of one vertex
    const std::int64_t faces = body + 5 * vertex;
    const auto at = [](std::int64_t offset) { return ": byte " + std::to_string(offset) + ": "; };
    const auto poked = [&](std::int64_t offset, const std::string &bytes) {
        std::string out = binary;
        return out.replace(static_cast<std::size_t>(offset), bytes.size(), bytes);
    };
    const std::string nan("\0\0\0\0\0\0\xf8\x7f", 8);
    checkCases("bad.ply",
               {
                   {"", ":1:1: ", {"the end of the file", "'ply'"}},
                   {replaced(ascii, "ply", "plx"), ":1:1: ", {"'plx'", "'ply'"}},
                   {replaced(ascii, "ascii", "asci"), ":2:8: ", {"'asci'", "did you mean 'ascii'?"}},
                   {replaced(ascii, "1.0", "1.1"), ":2:14: ", {"'1.1'", "version 1.0"}},
                   {replaced(ascii, "element vertex 5", "elemnt vertex 5"), ":5:1: ", {"'elemnt'", "did you mean 'element'?"}},
                   {replaced(ascii, "element vertex 5", "element vertx 5"), ":", {"no element 'vertex' (the nearest is 'vertx')"}},
                   {replaced(ascii, "element vertex 5", "element vertex many"), ":5:16: ", {"'many'"}},
                   {replaced(ascii, "element vertex 5", "element vertex -5"), ":5:16: ", {"-5 elements 'vertex'"}},
                   {replaced(ascii, "element vertex 5", "element vertex 4000000000"),
                    ":5:16: ",
                    {"4000000000 elements 'vertex'", "fits into the rest"}},
                   {replaced(binary, "element face 3", "element face 2000000000"), ":15:14: ", {"2000000000 elements 'face'"}},
                   {replaced(ascii, "property float x", "property flaot x"), ":6:10: ", {"'flaot'", "did you mean 'float'?"}},
                   {replaced(ascii, "property float z", "property float w"), ":5:16: ", {"x, y and z"}},
                   {replaced(ascii, "property float y", "property float x"), ":7:16: ", {"a second property 'x'"}},
                   {replaced(ascii, "list uchar int", "list float int"), ":17:15: ", {"'float'", "did you mean"}},
                   {replaced(ascii, "int vertex_indices", "int indices"), ":15:14: ", {"vertex_indices"}},
                   {replaced(ascii, "end_header\n", ""), ":", {"'0'", "end_header"}},
                   {"ply\nformat ascii 1.0\nelement vertex 1\n", ":4:1: ", {"the end of the file", "'end_header'"}},
                   {"ply\nproperty float x\n", ":2:1: ", {"'property'", "'format'"}},
                   {"ply\nformat ascii 1.0\nproperty float x\n", ":3:1: ", {"an element before"}},
                   {replaced(ascii, "1 0 0 7 0", "1 0 zero 7 0"), ":21:5: ", {"'zero'", "property 'z'"}},
                   {replaced(ascii, "1 0 0 7 0 0 1 1 0", "1 0 0 7"), ":21:8: ", {"the end of the line", "property 'nx'"}},
                   {replaced(ascii, "1 0 0 7 0 0 1 1 0", "1 0 0 7 0 0 1 1 0 9"), ":21:19: ", {"'9'", "the end of the line"}},
                   {replaced(ascii, "1 0 0 7", "1 inf 0 7"), ":21:3: ", {"'inf'", "finite"}},
                   {replaced(ascii, "1 3 0 1 2 0", "1 2 0 1 0"), ":25:3: ", {"a face of 2 corners", "at least 3"}},
                   {replaced(ascii, "1 3 0 1 2 0", "1 3 0 1 5 0"), ":25:9: ", {"vertex index 5", "0 to 4"}},
                   {replaced(ascii, "1 3 0 1 2 0", "1 3 0 -1 2 0"), ":25:7: ", {"vertex index -1"}},
                   {replaced(ascii, "1 3 0 1 2 0", "1 3 0 1.5 2 0"), ":25:7: ", {"'1.5'", "a vertex index"}},
                   {replaced(ascii, "1 3 0 1 2 0", "1 300 0 1 2 0"), ":25:3: ", {"300 items"}},
                   {ascii.substr(0, ascii.find("3 5 0 1 2 4")), ":", {"the end of the file"}},
                   {poked(body + vertex + 8, nan), at(body + vertex + 8), {"property 'y'", "finite"}},
                   {poked(faces + 2, std::string(1, '\x02')), at(faces + 2), {"a face of 2 corners"}},
                   {poked(faces + 2, std::string(1, '\xff')), at(faces + 2), {"255 items in list 'vertex_indices'"}},
                   {poked(faces + 3, std::string("\x05\0\0\0", 4)), at(faces + 3), {"vertex index 5", "0 to 4"}},
                   {poked(faces + 3, std::string("\xff\xff\xff\xff", 4)), at(faces + 3), {"vertex index -1"}},
                   {binary.substr(0, binary.size() - 1),
                    at(static_cast<std::int64_t>(binary.size()) - 5),
                    {"1 items in list 'more'", "the rest of the file"}},
                   {binary.substr(0, static_cast<std::size_t>(faces) + 1), at(faces), {"the end of the file", "2 bytes"}},
                   {replaced(binary, "element face 3", "element face 4") + std::string(2, 'x'),
                    at(static_cast<std::int64_t>(binary.size()) + 2),
                    {"the end of the file", "1 bytes"}},
                   {binary.substr(0, static_cast<std::size_t>(body)), ":5:16: ", {"5 elements 'vertex'", "0 to 0"}},
               });
}

TEST_CASE("Malformed OFF", "[mesh][malformed][off]") {
    const std::string square = "0 0 0\n1 0 0\n1 1 0\n0 1 0\n";
    checkCases("bad.off",
               {
                   {"", ":1:1: ", {"''", "OFF"}},
                   {"OOF\n4 1 0\n" + square + "4 0 1 2 3\n", ":1:1: ", {"'OOF'", "did you mean 'OFF'?"}},
                   {"4OFF\n4 1 0\n", ":1:1: ", {"'4OFF'", "did you mean"}},
                   {"OFF BINARY\n4 1 0\n", ":1:5: ", {"binary"}},
                   {"OFF\n4 x 0\n" + square, ":2:3: ", {"'x'", "the number of faces"}},
                   {"OFF\n4000000 1 0\n" + square, ":2:1: ", {"4000000 vertices"}},
                   {"OFF\n4 1000 0\n" + square + "4 0 1 2 3\n", ":2:3: ", {"1000 faces"}},
                   {"OFF\n-4 1 0\n" + square, ":2:1: ", {"-4 vertices"}},
                   {"OFF\n4 1 0\n0 0 0\n1 0\n1 1 0\n0 1 0\n4 0 1 2 3\n", ":4:4: ", {"the end of the line"}},
                   {"OFF\n4 1 0\n0 0 0 1\n" + square, ":3:7: ", {"'1'", "the end of the line"}},
                   {"NOFF\n4 1 0\n" + square + "4 0 1 2 3\n", ":3:6: ", {"the end of the line", "a number"}},
                   {"OFF\n4 1 0\n" + square + "4 0 1 2 4\n", ":7:9: ", {"vertex index 4", "0 to 3"}},
                   {"OFF\n4 1 0\n" + square + "2 0 1\n# and nothing more\n", ":7:1: ", {"a face of 2 corners"}},
                   {"OFF\n4 1 0\n" + square + "4 0 1 2\n", ":7:8: ", {"the end of the line", "a vertex index"}},
                   {"OFF\n4 2 0\n" + square + "4 0 1 2 3\n\n# the end\n", ":10:1: ", {"the end of the file", "the number of corners"}},
                   {"OFF\n4 0 0\n" + square, ": ", {"found no face"}},
               });
}

TEST_CASE("Malformed STL", "[mesh][malformed][stl]") {
    const std::string ascii = stlAsciiSample();
    const std::string binary = stlBinarySample();
    const auto poked = [&](std::size_t offset, const std::string &bytes) {
        return std::string(binary).replace(offset, bytes.size(), bytes);
    };
    const std::string headless = poked(0, "binary");
    checkCases("bad.stl", {
                              {"", ": byte 0: ", {"the end of the file", "84 bytes"}},
                              {"soild x\n", ": byte 8: ", {"'solid'"}},
                              {headless.substr(0, headless.size() - 1), ": byte 80: ", {"4 triangles in a file of 283 bytes", "284 bytes"}},
                              {headless.substr(0, 100), ": byte 80: ", {"4 triangles in a file of 100 bytes"}},
                              {ascii + "  facet normal 0 0 1 vertex", ":", {"'facet'", "'solid'"}},
                              {std::string(headless).replace(80, 4, "\xff\xff\xff\xff"), ": byte 80: ", {"4294967295 triangles"}},
                              {poked(84 + 12 + 4, std::string("\0\0\x80\x7f", 4)), ": byte 100: ", {"not finite"}},
                              {replaced(ascii, "  facet normal nan", "  faset normal nan"), ":2:3: ", {"'faset'", "'facet'"}},
                              {replaced(ascii, "nan 0 1", "nan 0"), ":2:21: ", {"the end of the line", "normal"}},
                              {replaced(ascii, "outer loop", "outer lop"), ":3:11: ", {"'lop'", "'loop'"}},
                              {replaced(ascii, "vertex 0.000000", "vertx 0.000000"), ":4:7: ", {"'vertx'", "'vertex'"}},
                              {replaced(ascii, "vertex 0.000000 0.000000", "vertex 0.000000 up"), ":4:23: ", {"'up'"}},
                              {replaced(ascii, "vertex 0.000000 0.000000", "vertex 0.000000 inf"), ":4:23: ", {"'inf'", "finite"}},
                              {replaced(ascii, "    endloop\n", ""), ":7:3: ", {"'endfacet'", "'endloop'"}},
                              {ascii.substr(0, ascii.find("endsolid")), ":30:1: ", {"the end of the file"}},
                              {"solid nothing\nendsolid nothing\n", ": ", {"found no face"}},
                          });
}

TEST_CASE("Malformed .glb containers", "[mesh][malformed][gltf]") {
    const std::string glb = gltfSample().glb();
    const auto poked = [&](std::size_t offset, std::uint32_t word) {
        std::string bytes;
        append(bytes, word);
        return std::string(glb).replace(offset, 4, bytes);
    };
    const std::string text = R"({"asset": {"version" "2.0"}})";
    checkCases("bad.glb",
               {
                   {"", ": byte 0: ", {"''", "'glTF'"}},
                   {"{}", ": byte 0: ", {"'{}'"}},
                   {"glTF\2", ": byte 5: ", {"12 bytes"}},
                   {poked(4, 1), ": byte 4: ", {"version 1", "version 2"}},
                   {glb.substr(0, glb.size() - 4), ": byte 8: ", {"a length of " + std::to_string(glb.size())}},
                   {glb.substr(0, 12).replace(8, 4, std::string("\x0c\0\0\0", 4)), ": byte 12: ", {"the end of the file", "JSON"}},
                   {poked(12, 0xfffffff0U), ": byte 12: ", {"a chunk of 4294967280 bytes"}},
                   {poked(16, 0x004E4942), ": byte 16: ", {"'BIN\\x00'", "'JSON'"}},
                   {GltfBuilder::container(text, ""), ": byte 41: ", {"valid JSON"}},
                   {GltfBuilder::container(R"({"asset": {"version": "2.0"}, "buffers": [{"byteLength": 4}]})", ""),
                    ": buffers[0]: ",
                    {"no 'uri'", "no BIN chunk"}},
               });
}

TEST_CASE("Malformed glTF JSON text", "[mesh][malformed][gltf]") {
    const std::string asset = R"({"asset": {"version": "2.0"},)";
    checkCases("bad.gltf",
               {
                   {"", ":1:1: ", {"valid JSON"}},
                   {"{\n \"asset\": {,\n}", ":2:12: ", {"',", "valid JSON"}},
                   {"[]", ": the JSON: ", {"an object"}},
                   {"{}", ": asset.version: ", {"none", "'2.0'"}},
                   {R"({"asset": {"version": "1.0"}})", ": asset.version: ", {"'1.0'", "'2.0'"}},
                   {R"({"asset": {"version": 2}})", ": asset.version: ", {"'2'", "a string"}},
                   {asset + R"("meshes": {}})", ": meshes: ", {"an object", "an array of objects"}},
                   {asset + R"("nodes": [{"children": [-1]}]})", ": nodes[0].children: ", {"'[-1]'", "integers from 0"}},
                   {asset + R"("nodes": [{"mesh": 4294967296}]})", ": nodes[0].mesh: ", {"'4294967296'"}},
                   {asset + R"("nodes": [{"mesh": 1.5}]})", ": nodes[0].mesh: ", {"'1.5'", "an integer"}},
                   {asset + R"("nodes": [{"scale": [1, 1e60, 1]}]})", ": nodes[0].scale: ", {"finite"}},
                   {asset + R"("nodes": [{"translation": [1e999, 0, 0]}]})", ": the JSON: ", {"valid JSON"}},
                   {asset + R"("bufferViews": [{"bufer": 0, "byteLength": 3}]})",
                    ": bufferViews[0]: ",
                    {"no member 'buffer' (the nearest is 'bufer')"}},
                   {asset + R"("extensionsRequired": ["KHR_draco_mesh_compression"]})",
                    ": extensionsRequired[0]: ",
                    {"'KHR_draco_mesh_compression'", "did you mean"}},
                   {asset + R"("extensionsRequired": ["KHR_light_punctual"]})",
                    ": extensionsRequired[0]: ",
                    {"did you mean 'KHR_lights_punctual'?"}},
                   {asset + R"("buffers": [{"byteLength": 4, "uri": "missing.bin"}]})", ": buffers[0].uri: ", {"'missing.bin'", "no file"}},
                   {asset + R"("buffers": [{"byteLength": 4, "uri": "http://example.com/a.bin"}]})", ": buffers[0].uri: ", {"relative"}},
                   {asset + R"("buffers": [{"byteLength": 4, "uri": "data:application/octet-stream;base64,AAA="}]})",
                    ": buffers[0].byteLength: ",
                    {"4", "at most 2"}},
                   {asset + R"("buffers": [{"byteLength": 4, "uri": "data:text/html,"}]})", ": buffers[0].uri: ", {"base64"}},
                   {asset + "\"extras\": " + std::string(100000, '[') + std::string(100000, ']') + "}", ": the JSON: ", {"nested deeper"}},
               });
}

TEST_CASE("Malformed glTF content", "[mesh][malformed][gltf]") {
    struct Edit {
        std::function<void(nlohmann::json &)> apply;
        std::string place;
        std::vector<std::string> says;
    };
    using Json = nlohmann::json;
    const auto primitive = [](Json &j) -> Json & { return j["meshes"][0]["primitives"][0]; };
    const std::vector<Edit> edits{
        {[&](Json &j) { primitive(j)["attributes"].erase("POSITION"); }, ": meshes[0].primitives[0].attributes: ", {"no POSITION"}},
        {[&](Json &j) { primitive(j)["attributes"]["NORMAL"] = 99; }, ": meshes[0].primitives[0].attributes.NORMAL: ", {"99", "0 to 13"}},
        {[&](Json &j) { primitive(j)["attributes"]["NORMAL"] = 2; }, ": accessors[2].type: ", {"'VEC2'", "'VEC3'"}},
        {[&](Json &j) { primitive(j)["indices"] = 99; }, ": meshes[0].primitives[0].indices: ", {"99", "0 to 13"}},
        {[&](Json &j) { primitive(j)["indices"] = 9; }, ": accessors[9].componentType: ", {"FLOAT", "unsigned"}},
        {[&](Json &j) { primitive(j)["material"] = 1; }, ": meshes[0].primitives[0].material: ", {"1", "0 to 0"}},
        {[&](Json &j) { primitive(j)["mode"] = 7; }, ": meshes[0].primitives[0].mode: ", {"7", "0 to 6"}},
        {[&](Json &j) { primitive(j)["attributes"].erase("WEIGHTS_0"); }, ": meshes[0].primitives[0].attributes: ", {"no WEIGHTS_0"}},
        {[](Json &j) { j["accessors"][0]["count"] = 3; },
         ": meshes[0].primitives[0].attributes.NORMAL: ",
         {"4 elements", "3, the count of POSITION"}},
        {[](Json &j) { j["accessors"][0]["count"] = 5; }, ": accessors[0]: ", {"5 elements of 12 bytes", "48 bytes of bufferViews[0]"}},
        {[](Json &j) { j["accessors"][0]["count"] = 2147483647; }, ": accessors[0]: ", {"2147483647 elements"}},
        {[](Json &j) { j["accessors"][0]["byteOffset"] = 4; }, ": accessors[0]: ", {"from byte 4"}},
        {[](Json &j) { j["accessors"][0]["componentType"] = 5130; }, ": accessors[0].componentType: ", {"5130"}},
        {[](Json &j) {
             j["accessors"][0].erase("bufferView");
             j["accessors"][0]["count"] = 2000000000;
         },
         ": accessors[0].count: ",
         {"2000000000"}},
        {[](Json &j) { j["accessors"][6]["count"] = 8; }, ": meshes[0].primitives[0]: ", {"8 indices", "a multiple of three"}},
        {[](Json &j) { j["accessors"][7]["sparse"]["count"] = 5; }, ": accessors[7].sparse.count: ", {"5", "1 to 4"}},
        {[](Json &j) {
             j["accessors"][7]["sparse"]["indices"]["bufferView"] = 0;
             j["accessors"][7]["sparse"]["indices"]["byteOffset"] = 15;
         },
         ": accessors[7].sparse.indices: ",
         {"index 63"}},
        {[](Json &j) { j["bufferViews"][0]["byteLength"] = 1000000; }, ": bufferViews[0]: ", {"1000000 bytes from byte 0"}},
        {[](Json &j) { j["bufferViews"][0]["buffer"] = 1; }, ": bufferViews[0].buffer: ", {"1", "0 to 0"}},
        {[](Json &j) { j["bufferViews"][1]["byteStride"] = 13; },
         ": bufferViews[1].byteStride: ",
         {"'13'", "a multiple of 4 from 0 to 252"}},
        {[](Json &j) { j["accessors"][0]["type"] = "VEC5"; }, ": accessors[0].type: ", {"'VEC5'", "'VEC3'"}},
        {[](Json &j) { j["accessors"][0]["componentType"] = 1; }, ": accessors[0].componentType: ", {"1", "5120"}},
        {[](Json &j) { j["bufferViews"][0]["byteStride"] = 8; }, ": bufferViews[0].byteStride: ", {"8", "at least 12"}},
        {[](Json &j) { j["meshes"][0]["weights"] = {1}; }, ": meshes[0].weights: ", {"1 weights", "2"}},
        {[](Json &j) {
             j["nodes"][1]["children"] = {0, 2, 2};
         },
         ": nodes[1].children[2]: ",
         {"already a child of node 1"}},
        {[](Json &j) {
             j["nodes"][1]["children"] = {0, 9};
         },
         ": nodes[1].children[1]: ",
         {"9", "0 to 4"}},
        {[](Json &j) { j["nodes"][2]["children"] = {1}; }, ": nodes[0]: ", {"its own ancestor"}},
        {[](Json &j) {
             j["nodes"][0]["translation"] = {1, 2};
         },
         ": nodes[0].translation: ",
         {"an array of 2 numbers", "3"}},
        {[](Json &j) {
             j["nodes"][1]["rotation"] = {0, 0, 0, 0};
         },
         ": nodes[1].rotation: ",
         {"unit quaternion"}},
        {[](Json &j) { j["nodes"][2]["mesh"] = 1; }, ": nodes[2].mesh: ", {"1", "0 to 0"}},
        {[](Json &j) { j["nodes"][2]["skin"] = 1; }, ": nodes[2].skin: ", {"1", "0 to 0"}},
        {[](Json &j) { j["nodes"][3]["camera"] = 1; }, ": nodes[3].camera: ", {"0 to 0"}},
        {[](Json &j) { j["nodes"][4]["extensions"]["KHR_lights_punctual"]["light"] = 1; },
         ": nodes[4].extensions.KHR_lights_punctual.light: ",
         {"0 to 0"}},
        {[](Json &j) { j["scene"] = 2; }, ": scene: ", {"2", "0 to 1"}},
        {[](Json &j) { j["scenes"][1]["nodes"] = {7}; }, ": scenes[1].nodes[0]: ", {"7", "0 to 4"}},
        {[](Json &j) { j["skins"][0]["joints"] = {1}; }, ": nodes[2].skin: ", {"joint 1 in mesh 'square'", "0 to 0"}},
        {[](Json &j) {
             j["skins"][0]["joints"] = {1, 5};
         },
         ": skins[0].joints[1]: ",
         {"5", "0 to 4"}},
        {[](Json &j) {
             j["skins"][0]["joints"] = {1, 0, 2};
         },
         ": skins[0].inverseBindMatrices: ",
         {"2 matrices", "3, one a joint"}},
        {[](Json &j) { j["animations"][0]["channels"][0]["sampler"] = 3; }, ": animations[0].channels[0].sampler: ", {"3", "0 to 2"}},
        {[](Json &j) { j["animations"][0]["channels"][0]["target"]["path"] = "rotate"; },
         ": animations[0].channels[0].target.path: ",
         {"did you mean 'rotation'?"}},
        {[](Json &j) { j["animations"][0]["channels"][1]["target"]["node"] = 0; },
         ": animations[0].channels[1].target.path: ",
         {"morph targets"}},
        {[](Json &j) { j["animations"][0]["samplers"][0]["interpolation"] = "LINAER"; },
         ": animations[0].samplers[0].interpolation: ",
         {"did you mean 'LINEAR'?"}},
        {[](Json &j) { j["animations"][0]["samplers"][2]["interpolation"] = "LINEAR"; },
         ": animations[0].samplers[2].output: ",
         {"18 numbers", "6 for 2 keys of translation"}},
        {[](Json &j) { j["animations"][0]["samplers"][0]["input"] = 11; }, ": animations[0].samplers[0].input: ", {"strictly increasing"}},
        {[](Json &j) { j["animations"][0]["samplers"][0].erase("output"); }, ": animations[0].samplers[0]: ", {"no member 'output'"}},
        {[](Json &j) { j["materials"][0]["pbrMetallicRoughness"]["roughnessFactor"] = 1.5; },
         ": materials[0].pbrMetallicRoughness.roughnessFactor: ",
         {"found 1.5, expected 0 to 1"}},
        {[](Json &j) {
             j["materials"][0]["emissiveFactor"] = {1, 1};
         },
         ": materials[0].emissiveFactor: ",
         {"'[1,1]'", "an array of 3 finite numbers"}},
        {[](Json &j) { j["materials"][0]["extensions"]["KHR_materials_ior"]["ior"] = 0.5; },
         ": materials[0].extensions.KHR_materials_ior.ior: ",
         {"at least 1"}},
        {[](Json &j) { j["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"]["index"] = 1; },
         ": materials[0].pbrMetallicRoughness.baseColorTexture.index: ",
         {"0 to 0"}},
        {[](Json &j) { j["textures"][0]["source"] = 2; }, ": textures[0].source: ", {"2", "0 to 1"}},
        {[](Json &j) { j["images"][1].erase("uri"); }, ": images[1]: ", {"neither"}},
        {[](Json &j) {
             j["nodes"] = {0, 1};
         },
         ": nodes: ",
         {"'[0,1]'", "an array of objects"}},
        {[](Json &j) { j["scenes"][0]["nodes"] = {Json::object()}; }, ": scenes[0].nodes: ", {"an array of integers"}},
        {[](Json &j) { j["cameras"][0]["type"] = "orthografic"; }, ": cameras[0].type: ", {"did you mean 'orthographic'?"}},
        {[](Json &j) { j["cameras"][0]["type"] = "orthographic"; }, ": cameras[0]: ", {"no member 'orthographic'"}},
        {[](Json &j) { j["extensions"]["KHR_lights_punctual"]["lights"][0].erase("spot"); },
         ": extensions.KHR_lights_punctual.lights[0]: ",
         {"no member 'spot'"}},
        {[](Json &j) { j["cameras"][0]["perspective"]["yfov"] = 4; }, ": cameras[0].perspective.yfov: ", {"found 4, "}},
        {[](Json &j) { j["extensions"]["KHR_lights_punctual"]["lights"][0]["type"] = "sport"; },
         ": extensions.KHR_lights_punctual.lights[0].type: ",
         {"did you mean 'spot'?"}},
    };
    for (const Edit &edit : edits) {
        GltfBuilder b = gltfSample();
        edit.apply(b.json);
        checkCases("content.gltf", {{b.gltf(), edit.place, edit.says}});
    }
    GltfBuilder b = gltfSample();
    const float infinity = INFINITY;
    std::memcpy(b.bin.data() + 12, &infinity, sizeof infinity);
    checkCases("content.gltf", {{b.gltf(), ": meshes[0].primitives[0].attributes.POSITION: ", {"not finite in element 1"}}});
}

TEST_CASE("Files that are no files", "[mesh][malformed]") {
    Warnings warnings;
    const std::string folder = outputFolder("mesh");
    CHECK_THROWS_WITH(readMesh(folder + "/absent.obj", warnings), Catch::Contains("absent.obj: found no such file"));
    CHECK_THROWS_WITH(readGltf(folder + "/absent.glb", warnings), Catch::Contains("absent.glb: found no such file"));
    CHECK_THROWS_WITH(readMesh(outputFolder("mesh/folder.obj"), warnings), Catch::Contains("not a file"));
    CHECK_THROWS_WITH(readMesh(writeFile("mesh.obk", "v"), warnings),
                      Catch::Contains("'obk', expected one of obj, ply, off, stl; did you mean 'obj'?"));
}
