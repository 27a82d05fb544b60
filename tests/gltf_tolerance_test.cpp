/// What the glTF reader lets pass, holds, names and refuses.

#include "scene_fixtures.h"

#include "taut/formats/gltf.h"

using namespace taut;
using namespace taut::test;

namespace {

/// One triangle, not indexed.
GltfBuilder plainTriangle() {
    GltfBuilder b;
    b.json["meshes"] = {{{"primitives", {{{"attributes", {{"POSITION", b.addFloats("VEC3", {0, 0, 0, 1, 0, 0, 0, 1, 0})}}}}}}}};
    b.json["nodes"] = {{{"mesh", 0}}};
    return b;
}

/// What reading says, error or warnings, lines apart by newlines.
std::string said(const std::string &path) {
    Warnings warnings;
    std::string text = errorOf([&] { loadScene(path, {}, warnings); });
    for (const std::string &line : warnings.lines) text += "\n" + line;
    return text;
}
std::string saidOf(const GltfBuilder &b) {
    return said(writeTo(outputFolder("gltf_tolerance"), "file.gltf", b.gltf()));
}
bool loads(const std::string &text) {
    return text.empty() || text[0] == '\n';
}
bool contains(const std::string &text, const std::string &part) {
    return text.find(part) != std::string::npos;
}

} // namespace

TEST_CASE("case unknown-members: they are passed over and named", "[gltf][cases]") {
    const auto path = caseFile("unknown-members/unknown_property_typed.gltf");
    if (!path) return;
    const std::string text = said(*path);
    CHECK(loads(text));
    CHECK(contains(text, "member 'accessorz' (1)"));
    CHECK(contains(text, "member 'foo' (1)"));
}

TEST_CASE("members that an object does not have are named, whatever they hold; those that it has are checked", "[gltf]") {
    GltfBuilder b = plainTriangle();
    b.json["nodes"][0]["uri"] = 5; // a member of buffers and images
    b.json["nodes"][0]["children"] = nlohmann::json::array();
    b.json["meshes"][0]["primitives"][0]["indicez"] = {{"count", "many"}};
    b.json["meshes"][0]["primitives"][0]["extras"] = {{"mode", "any"}};
    b.json["asset"]["licence"] = "CC0";
    const std::string text = saidOf(b);
    CHECK(loads(text));
    for (const char *name : {"member 'uri' (1)", "member 'indicez' (1)", "member 'licence' (1)"}) CHECK(contains(text, name));
    CHECK(!contains(text, "'mode'"));
    b.json["nodes"][0]["children"] = 5;
    CHECK(contains(saidOf(b), "nodes[0].children: found '5'"));
}

TEST_CASE("case min-version: a file for a later version is refused", "[gltf][cases]") {
    const auto path = caseFile("min-version/min_version_21.gltf");
    if (!path) return;
    CHECK(contains(said(*path), "asset.minVersion: found '2.1', expected at most '2.0'"));
}

TEST_CASE("minVersion 2.0 and a later version are read, indices that restart a primitive are refused", "[gltf]") {
    GltfBuilder b = plainTriangle();
    b.json["asset"]["version"] = "2.3";
    b.json["asset"]["minVersion"] = "2.0";
    CHECK(loads(saidOf(b)));
    b.json["asset"]["minVersion"] = "3.0";
    CHECK(contains(saidOf(b), "asset.minVersion: found '3.0'"));
    b.json["asset"].erase("minVersion");
    // 256 vertices, so that 255 is a vertex.
    b.json["meshes"][0]["primitives"][0]["attributes"]["POSITION"] = b.addFloats("VEC3", std::vector<float>(768, 0.5F));
    b.json["meshes"][0]["primitives"][0]["indices"] = b.add<std::uint8_t>("SCALAR", 5121, {0, 1, 255});
    CHECK(contains(saidOf(b), "indices: found vertex index 255 at place 2, the value of primitive restart"));
}

TEST_CASE("case rounded-factor: factors that rounding put above 1 are 1", "[gltf][cases]") {
    const auto path = caseFile("rounded-factor/a.gltf");
    if (!path) return;
    Warnings warnings;
    const Scene scene = loadScene(*path, {}, warnings);
    const Material &material = scene.materials.at(scene.objects.at(0).materials.at(0));
    CHECK(material.color.value == Vec3(1));
    CHECK(material.metallic.value == 1);
}

TEST_CASE("rounded factors at both ends, and messages that tell what is outside from what is inside", "[gltf]") {
    GltfBuilder b = plainTriangle();
    b.json["meshes"][0]["primitives"][0]["material"] = 0;
    const auto roughness = [&](double value) {
        b.json["materials"] = {{{"pbrMetallicRoughness", {{"roughnessFactor", value}}}, {"emissiveFactor", {0, 0, -1e-9}}}};
        return saidOf(b);
    };
    CHECK(loads(roughness(1.000001)));
    CHECK(loads(roughness(-1e-7)));
    CHECK(contains(roughness(1.0001), "roughnessFactor: found 1.0001, expected 0 to 1"));
    CHECK(contains(roughness(-0.00002), "found -2e-05, expected 0 to 1"));
    CHECK(contains(roughness(1.00001000001), "found 1.00001000001, expected 0 to 1"));
}

TEST_CASE("case data-uri: the type is found from the bytes", "[gltf][cases]") {
    if (const auto path = caseFile("data-uri/a.gltf")) {
        Warnings warnings;
        const Scene scene = loadScene(*path, {}, warnings);
        CHECK(warnings.lines.empty());
        REQUIRE(scene.textures.size() == 1);
        CHECK(scene.textures[0].width == 4);
    }
    if (const auto path = caseFile("data-uri/cs.gltf")) { // no image at all, under the name of one
        const std::string text = said(*path);
        CHECK(loads(text));
        CHECK(contains(text, "a texture has no image that can be read and is left out"));
    }
}

TEST_CASE("URIs: data of any type and encoding, backslashes, percent signs that mean themselves", "[gltf]") {
    const std::string folder = outputFolder("gltf_tolerance");
    const GltfBuilder b = plainTriangle();
    const auto positions = [&](const std::string &uri) {
        nlohmann::json file = b.json;
        file["buffers"] = {{{"byteLength", b.bin.size()}, {"uri", uri}}};
        Warnings warnings;
        return readGltf(writeTo(folder, "uri.gltf", file.dump()), warnings).meshes.at(0).positions;
    };
    const std::vector<Vec3> expected{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
    const std::string base64 = GltfBuilder::base64(b.bin);
    for (const std::string type : {"", "application/x-anything", "text/plain;charset=utf-8", "model/gltf-buffer;name=\"a,b\""}) {
        if (type.find(',') != std::string::npos) continue; // RFC 2397 parts head and data at the first comma
        CHECK(positions("data:" + type + ";base64," + base64) == expected);
    }
    std::string broken = base64; // over several lines
    broken.insert(20, "\n  ");
    CHECK(positions("data:;base64," + broken) == expected);
    std::string escaped;
    for (const char c : b.bin) {
        char text[4];
        std::snprintf(text, sizeof text, "%%%02x", static_cast<unsigned>(static_cast<unsigned char>(c)));
        escaped += text;
    }
    CHECK(positions("data:," + escaped) == expected);
    std::filesystem::create_directories(folder + "/sub");
    for (const char *name : {"sub/plain.bin", "100%.bin", "a%20b.bin", "c d.bin", "50%zz.bin"}) writeTo(folder, name, b.bin);
    for (const char *uri : {"sub/plain.bin", "sub\\plain.bin", "100%.bin", "100%25.bin", "a%20b.bin", "c%20d.bin", "c d.bin", "50%zz.bin"})
        CHECK(positions(uri) == expected);
    CHECK(says(errorOf([&] { positions("sub\\gone.bin"); }), "which is no file", {"sub/gone.bin"}));
    CHECK(!errorOf([&] { positions("http://host/a.bin"); }).empty());
}

TEST_CASE("bytes behind a .glb are none of it", "[gltf]") {
    const std::string folder = outputFolder("gltf_tolerance");
    const std::string glb = plainTriangle().glb();
    CHECK(loads(said(writeTo(folder, "tail.glb", glb + "a tail of other things"))));
    CHECK(contains(said(writeTo(folder, "cut.glb", glb.substr(0, glb.size() - 4))), "byte 8: found a length of"));
}

TEST_CASE("one line names what a file uses and the picture does not show, with counts", "[gltf]") {
    GltfBuilder b = plainTriangle();
    nlohmann::json &primitives = b.json["meshes"][0]["primitives"];
    primitives[0]["attributes"]["COLOR_1"] = primitives[0]["attributes"]["POSITION"];
    primitives[0]["attributes"]["_WIND"] = primitives[0]["attributes"]["POSITION"];
    primitives.push_back(primitives[0]);
    primitives.push_back(primitives[0]);
    primitives[1]["mode"] = 1;
    primitives[2]["mode"] = 3;
    b.json["images"] = {{{"uri", "bumps.png"}}};
    b.json["textures"] = {{{"source", 0}}};
    for (int i = 0; i < 2; ++i) b.json["materials"].push_back({{"occlusionTexture", {{"index", 0}}}});
    b.json["extensionsUsed"] = {"KHR_animation_pointer", "KHR_materials_dispersion"};
    b.json["materials"][0]["extensions"] = {{"KHR_materials_dispersion", {{"dispersion", 0.1}}}};
    b.json["animations"] = {
        {{"channels", {{{"sampler", 0}, {"target", {{"path", "pointer"}}}}}}, {"samplers", {{{"input", 0}, {"output", 0}}}}}};
    const std::string text = saidOf(b);
    CHECK(loads(text));
    CHECK(std::count(text.begin(), text.end(), '\n') == 1);
    for (const char *part :
         {"occlusionTexture (2)", "primitive of lines (2)", "COLOR_1 (1)", "_WIND (1)",
          "extension 'KHR_materials_dispersion' (1)", "extension 'KHR_animation_pointer' (1)", "animation channel of a pointer (1)"})
        CHECK(contains(text, part));
    Warnings warnings;
    const Scene scene = loadScene(outputFolder("gltf_tolerance") + "/file.gltf", {}, warnings);
    REQUIRE(scene.files.size() == 1);
    CHECK(contains(scene.files[0].leftOut, "occlusionTexture (2)"));
}
