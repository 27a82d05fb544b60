/// The glTF reader against a file built here, of which every number is known, and against the counts of real ones.

#include "mesh_samples.h"

#include "taut/formats/gltf.h"

using namespace taut;
using namespace taut::test;

namespace {

GltfFile read(const std::string &name, const std::string &bytes, std::size_t warningCount = 0) {
    Warnings warnings;
    GltfFile file = readGltf(writeFile(name, bytes), warnings);
    CAPTURE(warnings.lines);
    CHECK(warnings.lines.size() == warningCount);
    for (const Mesh &mesh : file.meshes) requireValid(mesh);
    return file;
}

/// One triangle, not indexed, in a mesh of one primitive.
GltfBuilder triangle() {
    GltfBuilder b;
    b.json["meshes"] = {{{"primitives", {{{"attributes", {{"POSITION", b.addFloats("VEC3", {0, 0, 0, 1, 0, 0, 0, 1, 0})}}}}}}}};
    b.json["nodes"] = {{{"mesh", 0}}};
    return b;
}

void checkSample(const GltfFile &file) {
    REQUIRE(file.meshes.size() == 1);
    const Mesh &mesh = file.meshes[0];
    CHECK(mesh.name == "square");
    CHECK(mesh.positions == std::vector<Vec3>{{0, 0, 0}, {1, 0, 0}, {1, 2, 0}, {0, 2, 0}});
    CHECK(mesh.faceOffsets == std::vector<Index>{0, 3, 6});
    CHECK(mesh.cornerPositions == std::vector<Index>{0, 1, 2, 0, 2, 3});
    CHECK(mesh.cornerNormals == mesh.cornerPositions);
    CHECK(mesh.cornerUvs == mesh.cornerPositions);
    CHECK(mesh.cornerTangents == mesh.cornerPositions);
    CHECK(mesh.normals == std::vector<Vec3>(4, Vec3(0, 0, 1)));
    CHECK(mesh.uvs == std::vector<Vec2>{{0, 1}, {1, 1}, {1, 0}, {0, 1 - 0.2F}});
    CHECK(mesh.tangents == std::vector<Vec4>{{1, 0, 0, -1}, {1, 0, 0, -1}, {1, 0, 0, 1}, {1, 0, 0, 1}});
    REQUIRE(mesh.morphs.size() == 2);
    CHECK(mesh.morphs[0].name == "bulge");
    CHECK(mesh.morphs[0].positionDeltas == std::vector<Vec3>{{0, 0, 0}, {0, 0, 0}, {0, 0.5F, 1}, {0, 0, 0}});
    CHECK(mesh.morphs[1].name == "still");
    CHECK(mesh.morphs[1].positionDeltas == std::vector<Vec3>(4, Vec3(0)));
    CHECK(mesh.morphs[0].normalDeltas.empty());
    CHECK(mesh.morphs[1].normalDeltas == std::vector<Vec3>{{0, 0, 2}, {0, 0, 1}, {0, 0, 1}, {0, 0, 1}});
    CHECK(mesh.skin.offsets == std::vector<Index>{0, 1, 3, 5, 5});
    CHECK(mesh.skin.joints == std::vector<Index>{1, 0, 1, 0, 1});
    CHECK(mesh.skin.weights == std::vector<float>{1, 0.25F, 0.75F, 0.25F, 0.75F});
    CHECK(file.slots == std::vector<std::vector<GltfSlot>>{{{0, {}}}});
}

} // namespace

TEST_CASE("glTF: the mesh of a .glb and of a .gltf with a data: URI", "[mesh][gltf]") {
    const GltfBuilder sample = gltfSample();
    for (const auto &[name, bytes] : {std::pair("sample.glb", sample.glb()), std::pair("sample.gltf", sample.gltf())}) {
        Warnings warnings;
        const GltfFile file = readGltf(writeFile(name, bytes), warnings);
        requireValid(file.meshes.at(0));
        checkSample(file);
        REQUIRE(warnings.lines.size() == 3);
        CHECK_THAT(warnings.lines[0], Catch::Contains("1 of 4 vertices have no skin weight"));
        CHECK_THAT(warnings.lines[1], Catch::Contains("the skin weights of 1 of 4 vertices did not sum to 1"));
        CHECK_THAT(warnings.lines[2], Catch::Contains("dropped 1 of 3 faces"));
    }
}

TEST_CASE("glTF: nodes with parents first, the default scene, skins", "[mesh][gltf]") {
    const GltfFile file = read("nodes.glb", gltfSample().glb(), 3);
    REQUIRE(file.rig.nodes.size() == 5);
    const auto find = [&](const std::string &name) {
        for (std::size_t n = 0; n < file.rig.nodes.size(); ++n)
            if (file.rig.nodes[n].name == name) return static_cast<Index>(n);
        return kNone;
    };
    const Index tip = find("tip");
    const Index root = find("root");
    const Index body = find("body");
    const Index camera = find("node3");
    const Index lamp = find("lamp");
    for (const Index n : {tip, root, body, camera, lamp}) REQUIRE(n != kNone);
    for (std::size_t n = 0; n < file.rig.nodes.size(); ++n)
        if (file.rig.nodes[n].parent != kNone) CHECK(file.rig.nodes[n].parent < n);
    CHECK(file.rig.nodes[tip].parent == root);
    CHECK(file.rig.nodes[body].parent == root);
    CHECK(file.rig.nodes[root].parent == kNone);
    CHECK(file.rig.nodes[tip].translation == DVec3(0, 2, 0));
    CHECK(file.rig.nodes[root].rotation.z == 1); // of length 2 in the file
    CHECK(file.rig.nodes[root].rotation.w == 0);
    CHECK(file.rig.nodes[root].scale == DVec3(1, 2, 3));
    REQUIRE(file.rig.nodes[camera].matrix);
    CHECK((*file.rig.nodes[camera].matrix)[3] == glm::dvec4(5, 6, 7, 1));
    CHECK_FALSE(file.rig.nodes[root].matrix);
    CHECK(file.attached[camera].camera == 0);
    CHECK(file.attached[lamp].light == 0);
    CHECK(file.attached[body].mesh == 0);
    CHECK(file.rig.nodes[body].skin == 0);
    CHECK(file.rig.nodes[body].morphWeights == std::vector<float>{0.25F, 0.5F});
    std::vector<Index> shown{tip, root, body, camera};
    std::sort(shown.begin(), shown.end());
    CHECK(file.sceneNodes == shown);
    REQUIRE(file.rig.skins.size() == 1);
    CHECK(file.rig.skins[0].name == "skin0");
    CHECK(file.rig.skins[0].joints == std::vector<Index>{root, tip});
    CHECK(file.rig.skins[0].inverseBindMatrix[0] == DMat4(1));
    CHECK(file.rig.skins[0].inverseBindMatrix[1][3] == glm::dvec4(0, -2, 0, 1));
}

TEST_CASE("glTF: clips with all three interpolations and normalised keys", "[mesh][gltf]") {
    const GltfFile file = read("clips.glb", gltfSample().glb(), 3);
    REQUIRE(file.rig.clips.size() == 1);
    const Clip &clip = file.rig.clips[0];
    CHECK(clip.name == "clip0");
    CHECK(clip.duration == 2);
    REQUIRE(clip.channels.size() == 3);
    const Channel &turn = clip.channels[0];
    CHECK(file.rig.nodes[turn.node].name == "tip");
    CHECK(turn.path == ChannelPath::Rotation);
    CHECK(turn.interpolation == Interpolation::Linear);
    CHECK(turn.width == 4);
    CHECK(turn.times == std::vector<float>{0, 0.5F, 2});
    CHECK(turn.values == std::vector<float>{0, 0, 0, 1, 0, 0, 1, 0, 0, 0, -1, 0}); // -32768 is clamped to -1
    const Channel &morph = clip.channels[1];
    CHECK(morph.path == ChannelPath::Weights);
    CHECK(morph.interpolation == Interpolation::Step);
    CHECK(morph.width == 2);
    CHECK(morph.values == std::vector<float>{0, 0, 1, 0.5F, 0.25F, 0.125F});
    const Channel &move = clip.channels[2];
    CHECK(file.rig.nodes[move.node].name == "root");
    CHECK(move.path == ChannelPath::Translation);
    CHECK(move.interpolation == Interpolation::CubicSpline);
    CHECK(move.width == 3);
    CHECK(move.values.size() == 18);
    CHECK(move.values[4] == 2); // the first key's value, after its in-tangent
}

TEST_CASE("glTF: materials, images, cameras and lights", "[mesh][gltf]") {
    const GltfFile file = read("material.glb", gltfSample().glb(), 3);
    REQUIRE(file.materials.size() == 1);
    const GltfMaterial &m = file.materials[0];
    CHECK(m.name == "steel");
    CHECK(m.baseColor == Vec4(0.5F, 0.25F, 0.125F, 1));
    CHECK(m.metallic == 0.75F);
    CHECK(m.roughness == 0.5F);
    CHECK(m.emissive == Vec3(4, 2, 0));
    CHECK(m.anisotropyStrength == 0.5F);
    CHECK(m.anisotropyRotation == 0.25F);
    CHECK(m.ior == 1.75F);
    CHECK(m.transmission == 0.125F);
    CHECK(m.doubleSided);
    CHECK(m.baseColorTexture.image == 0);
    CHECK(m.baseColorTexture.sampler.wrapU == TextureWrap::Clamp);
    CHECK(m.baseColorTexture.sampler.wrapV == TextureWrap::Repeat);
    CHECK_FALSE(m.baseColorTexture.sampler.moved);
    CHECK(m.anisotropyTexture.image == 0);
    CHECK(m.metallicRoughnessTexture.image == kNone);
    REQUIRE(file.images.size() == 2);
    CHECK(std::string(file.images[0].bytes.begin(), file.images[0].bytes.end()) == "not decoded");
    CHECK(file.images[0].path.empty());
    CHECK(file.images[1].path == outputFolder("mesh") + "/a b+c.png");
    REQUIRE(file.cameras.size() == 1);
    CHECK(file.cameras[0].perspective);
    CHECK(file.cameras[0].yFov == 0.75F);
    REQUIRE(file.lights.size() == 1);
    CHECK(file.lights[0].type == "spot");
    CHECK(file.lights[0].color == Vec3(1, 0.5F, 0.25F));
    CHECK(file.lights[0].intensity == 20);
    CHECK(file.lights[0].innerConeAngle == 0.25F);
    CHECK(file.lights[0].outerConeAngle == 0.5F);
}

TEST_CASE("glTF: lists, strips and fans, indexed or not", "[mesh][gltf]") {
    const auto corners = [](int mode, bool indexed) {
        GltfBuilder b;
        nlohmann::json primitive = {
            {"attributes", {{"POSITION", b.addFloats("VEC3", {0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0, 2, 1, 0, 2, 2, 0})}}}, {"mode", mode}};
        if (indexed) primitive["indices"] = b.add<std::uint32_t>("SCALAR", 5125, {5, 4, 3, 2, 1, 0});
        b.json["meshes"] = {{{"primitives", {primitive}}}};
        return read("mode.glb", b.glb()).meshes.at(0).cornerPositions;
    };
    CHECK(corners(4, false) == std::vector<Index>{0, 1, 2, 3, 4, 5});
    CHECK(corners(4, true) == std::vector<Index>{5, 4, 3, 2, 1, 0});
    CHECK(corners(5, false) == std::vector<Index>{0, 1, 2, 1, 3, 2, 2, 3, 4, 3, 5, 4});
    CHECK(corners(6, true) == std::vector<Index>{4, 3, 5, 3, 2, 5, 2, 1, 5, 1, 0, 5});
}

TEST_CASE("glTF: primitives are slots of one mesh, points left out, names for what has none", "[mesh][gltf]") {
    GltfBuilder b = triangle();
    nlohmann::json &primitives = b.json["meshes"][0]["primitives"];
    primitives.push_back(primitives[0]);
    primitives.push_back(primitives[0]);
    primitives[1]["mode"] = 0;
    primitives[2]["material"] = 0;
    b.json["materials"] = {{{"name", "red"}}};
    Warnings warnings;
    const GltfFile file = readGltf(writeFile("several.glb", b.glb()), warnings);
    REQUIRE(file.meshes.size() == 1);
    const Mesh &mesh = file.meshes[0];
    CHECK(mesh.name == "mesh0");
    CHECK(mesh.positions.size() == 3); // shared by the two, as they are in the file
    CHECK(mesh.cornerPositions == std::vector<Index>{0, 1, 2, 0, 1, 2});
    CHECK(mesh.faceMaterials == std::vector<Index>{0, 1});
    CHECK(mesh.materialNames == std::vector<std::string>{"", "red"});
    CHECK(file.attached.at(0).mesh == 0);
    CHECK(file.rig.nodes.at(0).name == "node0");
    CHECK(file.sceneNodes == std::vector<Index>{0}); // no scene: everything
    CHECK(file.slots == std::vector<std::vector<GltfSlot>>{{{kNone, {}}, {0, {}}}});
    REQUIRE(warnings.lines.size() == 1);
    CHECK_THAT(warnings.lines[0], Catch::EndsWith("used, but not shown in the picture: primitive of points (1)"));
}

TEST_CASE("glTF: two sets of influences, interleaved and strided vertices, quantised positions", "[mesh][gltf]") {
    GltfBuilder b;
    std::string bytes;
    for (int v = 0; v < 3; ++v) { // position as bytes and a pad, then weights as normalised bytes
        appendAll<std::int8_t>(bytes, {static_cast<std::int8_t>(v == 1 ? 127 : 0), static_cast<std::int8_t>(v == 2 ? -127 : 0), 0, 0});
        appendAll<std::uint8_t>(bytes, {51, 51, 51, 51});
    }
    const int view = b.addView(bytes);
    b.json["bufferViews"][static_cast<std::size_t>(view)]["byteStride"] = 8;
    b.json["accessors"] = {
        {{"bufferView", view}, {"componentType", 5120}, {"normalized", true}, {"count", 3}, {"type", "VEC3"}},
        {{"bufferView", view}, {"byteOffset", 4}, {"componentType", 5121}, {"normalized", true}, {"count", 3}, {"type", "VEC4"}}};
    const int joints0 = b.add<std::uint8_t>("VEC4", 5121, {0, 1, 2, 3, 0, 1, 2, 3, 0, 1, 2, 3});
    const int joints1 = b.add<std::uint16_t>("VEC4", 5123, {4, 5, 6, 7, 4, 5, 6, 7, 4, 5, 6, 7});
    const int weights1 = b.addFloats("VEC4", {0.2F, 0, 0, 0, 0, 0.2F, 0, 0, 0, 0, 0, 0.2F});
    b.json["meshes"] = {
        {{"primitives",
          {{{"attributes", {{"POSITION", 0}, {"JOINTS_0", joints0}, {"WEIGHTS_0", 1}, {"JOINTS_1", joints1}, {"WEIGHTS_1", weights1}}}}}}}};
    const Mesh mesh = read("strided.glb", b.glb()).meshes.at(0);
    CHECK(mesh.positions == std::vector<Vec3>{{0, 0, 0}, {1, 0, 0}, {0, -1, 0}});
    CHECK(mesh.skin.offsets == std::vector<Index>{0, 5, 10, 15});
    CHECK(mesh.skin.joints == std::vector<Index>{0, 1, 2, 3, 4, 0, 1, 2, 3, 5, 0, 1, 2, 3, 7});
    for (const float w : mesh.skin.weights) CHECK(w == Approx(0.2));
}

TEST_CASE("glTF: a buffer in a file of its own, under a percent-encoded name", "[mesh][gltf]") {
    const GltfBuilder b = triangle();
    writeFile("a b.bin", b.bin + "more bytes than the buffer has");
    nlohmann::json file = b.json;
    file["buffers"] = {{{"byteLength", b.bin.size()}, {"uri", "a%20b.bin"}}};
    CHECK(read("external.gltf", file.dump()).meshes.at(0).positions[1] == Vec3(1, 0, 0));
}

TEST_CASE("glTF: unknown extensions are said, texture transforms move only where they differ from none", "[mesh][gltf]") {
    GltfBuilder b = gltfSample();
    nlohmann::json &transform = b.json["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"]["extensions"]["KHR_texture_transform"];
    transform = {{"offset", {0, 0}}, {"rotation", 0}, {"scale", {1, 1}}};
    CHECK_FALSE(read("transform.glb", b.glb(), 3).materials[0].baseColorTexture.sampler.moved);
    transform["scale"] = {2, 1};
    transform["texCoord"] = 1;
    b.json["extensionsUsed"].push_back("ACME_shine");
    b.json["extensionsUsed"].push_back("ACME_gleam");
    b.json["materials"][0]["extensions"]["ACME_gleam"] = {{"much", "yes"}};
    b.json["nodes"][0]["extensions"]["ACME_gleam"] = 3;
    Warnings warnings;
    const TextureSampler sampler = readGltf(writeFile("transform.glb", b.glb()), warnings).materials[0].baseColorTexture.sampler;
    CHECK(sampler.moved);
    CHECK(sampler.moveU == Vec3(2, 0, 0));
    CHECK(sampler.uvSet == 1);
    REQUIRE(warnings.lines.size() == 4);
    CHECK_THAT(warnings.lines[3], Catch::EndsWith(": extension 'ACME_gleam' (2), extension 'ACME_shine' (1)"));
}

TEST_CASE("glTF paths", "[mesh][gltf]") {
    CHECK(isGltfPath("a.glb"));
    CHECK(isGltfPath("x/b.GLTF"));
    CHECK_FALSE(isGltfPath("a.obj"));
    CHECK_FALSE(isGltfPath("glb"));
}

TEST_CASE("Real glTF files have the counts that their list states", "[mesh][gltf][assets]") {
    struct Counts {
        const char *file;
        std::size_t positions, triangles, primitives, skins, joints, morphs, clips, keys;
        float duration;
        bool uv, tangent;
    };
    constexpr Counts kFiles[] = {
        {"anim/khronos/Fox.glb", 1728, 576, 1, 1, 24, 0, 3, 2646, 3.42F, true, false},
        {"anim/khronos/CesiumMan.glb", 3273, 4672, 1, 1, 19, 0, 1, 2736, 2.0F, true, false},
        {"anim/khronos/RiggedFigure.glb", 370, 256, 1, 1, 19, 0, 1, 114, 1.25F, false, false},
        {"anim/khronos/RiggedSimple.glb", 160, 188, 1, 1, 2, 0, 1, 150, 2.08F, false, false},
        {"anim/khronos/AnimatedMorphCube.glb", 24, 12, 1, 0, 0, 2, 1, 127, 4.2F, false, true},
        {"anim/khronos/AnimatedMorphSphere.glb", 1876, 960, 1, 0, 0, 2, 1, 217, 7.2F, false, true},
        {"anim/khronos/MorphPrimitivesTest.glb", 30, 32, 2, 0, 0, 1, 0, 0, 0, true, false},
        {"anim/khronos/InterpolationTest.glb", 220, 110, 10, 0, 0, 0, 9, 45, 1.71F, true, false},
        {"anim/khronos/BoxAnimated.glb", 320, 254, 2, 0, 0, 0, 1, 6, 3.71F, false, false},
        {"anim/khronos/AnisotropyStrengthTest.glb", 53311, 97240, 50, 0, 0, 0, 0, 0, 0, true, true},
        {"anim/khronos/AnisotropyRotationTest.glb", 5799, 7476, 6, 0, 0, 0, 0, 0, 0, true, true},
        {"anim/khronos/SimpleSkin.gltf", 10, 8, 1, 1, 2, 0, 1, 12, 5.5F, false, false},
        {"anim/khronos/SimpleMorph.gltf", 3, 1, 1, 0, 0, 2, 1, 5, 4.0F, false, false},
        {"anim/kaykit/Knight.glb", 7024, 6952, 15, 1, 41, 0, 76, 90748, 4.0F, true, false},
        {"anim/blender_io/03_skinned_cylinder/03_skinned_cylinder.gltf", 750, 316, 1, 1, 4, 0, 1, 588, 2.0F, true, false},
        {"static/suzi.glb", 8098, 15744, 1, 0, 0, 0, 0, 0, 0, true, false},
    };
    for (const Counts &counts : kFiles) {
        const auto path = asset(counts.file);
        if (!path) continue;
        CAPTURE(counts.file);
        Warnings warnings;
        const GltfFile file = readGltf(*path, warnings);
        CHECK(warnings.lines.size() == (file.leftOut.counts.empty() ? 0 : 1));
        std::size_t positions = 0, triangles = 0, keys = 0, morphs = 0;
        bool uv = false, tangent = false;
        for (const Mesh &mesh : file.meshes) {
            requireValid(mesh);
            positions += mesh.positions.size();
            triangles += mesh.faceCount();
            morphs = std::max(morphs, mesh.morphs.size());
            uv |= !mesh.cornerUvs.empty();
            tangent |= !mesh.cornerTangents.empty();
        }
        float duration = 0;
        for (const Clip &clip : file.rig.clips) {
            duration = std::max(duration, clip.duration);
            for (const Channel &channel : clip.channels) keys += channel.times.size();
        }
        CHECK(positions == counts.positions);
        CHECK(triangles == counts.triangles);
        CHECK(file.meshes.size() <= counts.primitives);
        CHECK(file.rig.skins.size() == counts.skins);
        CHECK((file.rig.skins.empty() ? 0 : file.rig.skins[0].joints.size()) == counts.joints);
        CHECK(morphs == counts.morphs);
        CHECK(file.rig.clips.size() == counts.clips);
        CHECK(keys == counts.keys);
        CHECK(duration == Approx(counts.duration).margin(0.006));
        CHECK(uv == counts.uv);
        CHECK(tangent == counts.tangent);
    }
}
