/// Geometry, motion and cameras of glTF files: one mesh where the file has one, flat faces without normals, quantised vertices,
/// instances, variants, clips together, parallel rays.

#include "render_fixtures.h"
#include "scene_fixtures.h"

#include <set>

using namespace taut;
using namespace taut::test;

namespace {

/// A roof in the glTF's xy plane and one that rises from it, without normals, in one primitive.
GltfBuilder roofGltf() {
    GltfBuilder b;
    const int positions = b.addFloats("VEC3", {-1, 0, 0, 0, 0, 0, 0, 1, 0, -1, 1, 0, 1, 0, 2, 1, 1, 2});
    const int indices = b.add<std::uint16_t>("SCALAR", 5123, {0, 1, 2, 0, 2, 3, 1, 4, 5, 1, 5, 2});
    b.json["meshes"] = {{{"primitives", {{{"attributes", {{"POSITION", positions}}}, {"indices", indices}}}}}};
    b.json["nodes"] = {{{"mesh", 0}}};
    return b;
}

/// How many directions the render vertices' normals have, within rounding.
std::size_t directionsOf(const DeformedVertices &frame) {
    std::vector<Vec3> found;
    for (const Vec3 &n : frame.normals)
        if (std::none_of(found.begin(), found.end(), [&](const Vec3 &other) { return glm::length(other - n) < 1e-4F; })) found.push_back(n);
    return found.size();
}

/// Positions and normals, rounded, without order: what a surface is, however its vertices are numbered.
std::set<std::array<int, 6>> surfaceSet(const Scene &scene) {
    std::set<std::array<int, 6>> all;
    for (const Object &object : scene.objects) {
        const DeformedVertices frame = surfaceOf(object, 1);
        for (std::size_t v = 0; v < frame.normals.size(); ++v) {
            std::array<int, 6> entry{};
            for (int c = 0; c < 3; ++c) {
                entry[static_cast<std::size_t>(c)] = static_cast<int>(std::lround(frame.positions[v][c] * 1000 + 0.137F));
                entry[static_cast<std::size_t>(3 + c)] = static_cast<int>(std::lround(frame.normals[v][c] * 1000 + 0.137F));
            }
            all.insert(entry);
        }
    }
    return all;
}

} // namespace

TEST_CASE("case no-normals: faces without normals are flat", "[gltf][cases]") {
    const auto path = caseFile("no-normals/a.glb");
    if (!path) return;
    const Scene scene = loadFile(*path);
    CHECK(directionsOf(surfaceOf(scene.objects.at(0), 1)) == 2);
}

TEST_CASE("faces without normals are flat under deformation too, unless they are subdivided or asked to be smooth", "[gltf]") {
    const std::string folder = outputFolder("gltf_geometry");
    GltfBuilder b = roofGltf();
    nlohmann::json &primitive = b.json["meshes"][0]["primitives"][0];
    primitive["targets"] = {{{"POSITION", b.addFloats("VEC3", {0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, -1, 0, 0, -1})}}};
    b.json["meshes"][0]["weights"] = {1};
    const std::string path = writeTo(folder, "roof.gltf", b.gltf());
    const DeformedVertices bent = surfaceOf(loadFile(path).objects.at(0), 1);
    CHECK(directionsOf(bent) == 2);
    // The morphed half rises by 1 over 1: y up becomes z up, so (x, y, z) is (x, -z, y).
    const Vec3 slanted = Vec3(-1, -1, 0) / std::sqrt(2.0F);
    CHECK(std::any_of(bent.normals.begin(), bent.normals.end(), [&](const Vec3 &n) { return glm::length(n - slanted) < 1e-4F; }));
    CHECK(directionsOf(surfaceOf(loadFile(path, {"mesh.0.smooth=true"}).objects.at(0), 1)) > 2);
    CHECK(directionsOf(surfaceOf(loadFile(path, {"mesh.0.subdivision=2"}).objects.at(0), 1)) > 10);
}

TEST_CASE("case materials-meet: two materials are one surface", "[gltf][cases]") {
    const auto one = caseFile("materials-meet/one.glb");
    const auto two = caseFile("materials-meet/two.glb");
    if (!one || !two) return;
    const Scene whole = loadFile(*one, {"mesh.0.subdivision=2"});
    const Scene halves = loadFile(*two, {"mesh.0.subdivision=2"});
    REQUIRE(halves.objects.size() == 1);
    CHECK(halves.objects[0].materials.size() == 2);
    CHECK(surfaceSet(halves) == surfaceSet(whole));
}

TEST_CASE("case shared-vertices: primitives over one buffer have each of its vertices once", "[gltf][cases]") {
    const auto path = caseFile("shared-vertices/s60000_200.glb");
    if (!path) return;
    const Scene scene = loadFile(*path);
    std::set<const Mesh *> meshes;
    std::size_t positions = 0;
    std::size_t corners = 0;
    for (const Object &object : scene.objects)
        if (meshes.insert(object.mesh.get()).second) {
            positions += object.mesh->positions.size();
            corners += object.mesh->cornerCount();
        }
    CHECK(corners > 300000);
    CHECK(positions < 70000); // once for each of 200 primitives: 12 million
}

TEST_CASE("meshes over one buffer read the vertices that they use, sparse ones too", "[gltf]") {
    const std::string folder = outputFolder("gltf_geometry");
    constexpr int kRow = 2000; // meshes; each decoding all vertices would be 24 million of them, more than a file of its size may ask for
    GltfBuilder b;
    std::vector<float> points;
    std::vector<float> deltas;
    for (int i = 0; i < 3 * kRow; ++i)
        for (int c = 0; c < 3; ++c) {
            points.push_back(static_cast<float>(c == 0 ? i / 3 + (i % 3 == 1 ? 1 : 0) : c == 1 && i % 3 == 2 ? 1 : 0));
            deltas.push_back(static_cast<float>(c == 2 ? i : 0));
        }
    const int positions = b.addFloats("VEC3", points);
    const int moved = b.addFloats("VEC3", deltas);
    // A sparse accessor: the last vertex lies 5 deep.
    const int place = b.addView(std::string("\x6f\x17", 2)); // 5999
    std::string value;
    appendAll(value, {static_cast<float>(kRow - 1), 1.0F, 5.0F});
    b.json["accessors"][static_cast<std::size_t>(positions)]["sparse"] = {
        {"count", 1}, {"indices", {{"bufferView", place}, {"componentType", 5123}}}, {"values", {{"bufferView", b.addView(value)}}}};
    for (int m = 0; m < kRow; ++m) {
        const auto first = static_cast<std::uint16_t>(3 * m);
        b.json["meshes"].push_back({{"weights", {1}},
                                    {"primitives",
                                     {{{"attributes", {{"POSITION", positions}}},
                                       {"targets", {{{"POSITION", moved}}}},
                                       {"indices", b.add<std::uint16_t>("SCALAR", 5123,
                                                                        {static_cast<std::uint16_t>(first + 1),
                                                                         static_cast<std::uint16_t>(first + 2), first})}}}}});
        b.json["nodes"].push_back({{"mesh", m}});
    }
    const Scene scene = loadFile(writeTo(folder, "row.gltf", b.gltf()));
    REQUIRE(scene.objects.size() == kRow);
    for (std::size_t m = 0; m < kRow; ++m) {
        const Mesh &mesh = *scene.objects[m].mesh;
        const auto x = static_cast<float>(m);
        const float deep = m + 1 == kRow ? 5 : 0;
        REQUIRE(mesh.positions == std::vector<Vec3>{{x, 0, 0}, {x + 1, 0, 0}, {x, 1, deep}});
        REQUIRE(mesh.cornerPositions == std::vector<Index>{1, 2, 0});
        REQUIRE(mesh.morphs.at(0).positionDeltas == std::vector<Vec3>{{0, 0, 3 * x}, {0, 0, 3 * x + 1}, {0, 0, 3 * x + 2}});
    }
}

TEST_CASE("a cube of six materials is the cube of one: limit surface, smooth normals, fitted gradients", "[gltf]") {
    const std::string folder = outputFolder("gltf_geometry");
    const std::vector<std::array<int, 4>> faces{{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}};
    const auto corner = [](int i) { return Vec3((i & 1) != 0 ? 1 : -1, (i & 2) != 0 ? 1 : -1, (i & 4) != 0 ? 1 : -1); };
    const auto cube = [&](std::size_t primitives) {
        GltfBuilder b;
        for (std::size_t p = 0; p < primitives; ++p) {
            std::vector<float> points;
            std::vector<std::uint16_t> indices;
            for (std::size_t f = p; f < faces.size(); f += primitives) {
                const auto first = static_cast<std::uint16_t>(points.size() / 3);
                for (const int i : faces[f])
                    for (int c = 0; c < 3; ++c) points.push_back(corner(i)[c]);
                for (const int k : {0, 1, 2, 0, 2, 3}) indices.push_back(static_cast<std::uint16_t>(first + k));
            }
            b.json["meshes"][0]["primitives"].push_back({{"attributes", {{"POSITION", b.addFloats("VEC3", points)}}},
                                                         {"indices", b.add<std::uint16_t>("SCALAR", 5123, indices)},
                                                         {"material", p}});
        }
        for (std::size_t m = 0; m < faces.size(); ++m) b.json["materials"].push_back({{"name", std::string(1, 'm') + std::to_string(m)}});
        b.json["nodes"] = {{{"mesh", 0}}};
        return writeTo(folder, "cube" + std::to_string(primitives) + ".gltf", b.gltf());
    };
    for (const char *how : {"mesh.0.subdivision=2", "mesh.0.smooth=true"}) {
        const Scene parts = loadFile(cube(6), {how});
        const Scene whole = loadFile(cube(1), {how});
        REQUIRE(parts.objects.size() == 1);
        CHECK(parts.objects[0].materials.size() == 6);
        CHECK(surfaceSet(parts) == surfaceSet(whole));
        ObjectSurface surface;
        prepareObjectSurface(parts.objects[0], 24, surface);
        std::set<Index> used;
        for (Index t = 0; t < surface.surface.triangles.size(); ++t) used.insert(materialOfTriangle(surface, t));
        CHECK(used.size() == 6);
    }
}

TEST_CASE("KHR_mesh_quantization: integers, normalised or not, in every attribute", "[gltf]") {
    const std::string folder = outputFolder("gltf_geometry");
    GltfBuilder b;
    const int positions = b.add<std::uint16_t>("VEC3", 5123, {0, 0, 0, 10, 0, 0, 0, 20, 0});
    // Bytes of vectors are padded to four.
    const auto padded = [&](const std::vector<std::int8_t> &values, const char *type) {
        const int accessor = b.add<std::int8_t>("VEC4", 5120, values, true);
        b.json["accessors"].back()["type"] = type;
        b.json["accessors"].back()["count"] = 3;
        b.json["bufferViews"].back()["byteStride"] = 4;
        return accessor;
    };
    const int normals = padded({0, 0, 127, 0, 0, 0, 127, 0, 0, 0, 127, 0}, "VEC3");
    const int tangents = padded({127, 0, 0, -127, 127, 0, 0, -127, 127, 0, 0, -127}, "VEC4");
    const int uvs = b.add<std::uint16_t>("VEC2", 5123, {0, 1, 1, 1, 0, 0});
    b.json["meshes"] = {
        {{"primitives", {{{"attributes", {{"POSITION", positions}, {"NORMAL", normals}, {"TANGENT", tangents}, {"TEXCOORD_0", uvs}}}}}}}};
    b.json["nodes"] = {{{"mesh", 0}, {"scale", {0.1, 0.1, 0.1}}}};
    b.json["extensionsUsed"] = b.json["extensionsRequired"] = {"KHR_mesh_quantization"};
    Warnings warnings;
    const Scene scene = loadScene(writeTo(folder, "quantised.gltf", b.gltf()), {}, warnings);
    CHECK(warnings.lines.empty());
    const Mesh &mesh = *scene.objects.at(0).mesh;
    CHECK(mesh.positions == std::vector<Vec3>{{0, 0, 0}, {10, 0, 0}, {0, 20, 0}});
    CHECK(mesh.normals == std::vector<Vec3>(3, Vec3(0, 0, 1)));
    CHECK(mesh.tangents == std::vector<Vec4>(3, Vec4(1, 0, 0, -1)));
    CHECK(mesh.uvs == std::vector<Vec2>{{0, 0}, {1, 0}, {0, 1}});
    CHECK(close(DVec3(worldPositions(scene, scene.objects[0], 1).at(2)), DVec3(0, 0, 2), 1e-6));
}

TEST_CASE("EXT_mesh_gpu_instancing: a mesh in several places under its node", "[gltf]") {
    const std::string folder = outputFolder("gltf_geometry");
    GltfBuilder b = roofGltf();
    const float half = std::sqrt(0.5F);
    b.json["nodes"][0]["name"] = "tile";
    b.json["nodes"][0]["translation"] = {0, 0, 5};
    b.json["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"] = {
        {"TRANSLATION", b.addFloats("VEC3", {0, 0, 0, 10, 0, 0})},
        {"ROTATION", b.addFloats("VEC4", {0, 0, 0, 1, 0, 0, half, half})}, // a quarter turn about z
        {"SCALE", b.addFloats("VEC3", {1, 1, 1, 2, 2, 2})},
        {"_ID", b.addFloats("SCALAR", {1, 2})}};
    b.json["extensionsUsed"] = b.json["extensionsRequired"] = {"EXT_mesh_gpu_instancing"};
    Warnings warnings;
    const Scene scene = loadScene(writeTo(folder, "instances.gltf", b.gltf()), {}, warnings);
    REQUIRE(scene.objects.size() == 2);
    CHECK(scene.objects[0].mesh == scene.objects[1].mesh);
    CHECK(scene.objects[1].name == "instances/tile.1");
    // The corner (-1, 1, 0): as it is, and scaled by 2, turned to (-2, -2, 0) and moved by 10; the node adds 5 along z; then z up.
    CHECK(close(DVec3(worldPositions(scene, scene.objects[0], 1).at(3)), DVec3(-1, -5, 1), 1e-5));
    CHECK(close(DVec3(worldPositions(scene, scene.objects[1], 1).at(3)), DVec3(8, -5, -2), 1e-5));
    CHECK(says(warnings.lines.at(0), "instance attribute _ID (1)", {}));
}

TEST_CASE("an orthographic camera sees by parallel rays", "[gltf][camera]") {
    const std::string folder = outputFolder("gltf_geometry");
    // A plate of 1 x 1 metre, near and far: of a picture 4 metres high it covers a sixteenth, wherever it stands.
    const auto coverage = [&](double z, const std::string &camera, int shutter) {
        GltfBuilder b;
        const auto at = static_cast<float>(z);
        const int positions = b.addFloats("VEC3", {-0.5F, -0.5F, at, 0.5F, -0.5F, at, 0.5F, 0.5F, at, -0.5F, 0.5F, at});
        const int indices = b.add<std::uint16_t>("SCALAR", 5123, {0, 1, 2, 0, 2, 3});
        b.json["meshes"] = {{{"primitives", {{{"attributes", {{"POSITION", positions}}}, {"indices", indices}}}}}};
        b.json["nodes"] = {{{"mesh", 0}}, {{"camera", 0}, {"name", "eye"}}};
        b.json["cameras"] = {{{"type", "orthographic"}, {"orthographic", {{"xmag", 9}, {"ymag", 2}, {"znear", 0.1}, {"zfar", 100}}}}};
        std::vector<std::string> overrides{"render.width=64", "render.height=64", "environment.camera_visible=false",
                                           "environment.radiance=1", "render.shutter=" + std::to_string(shutter)};
        if (!camera.empty())
            overrides.insert(overrides.end(), {"camera.position=[0,0.5,0]", "camera.look_at=[0,9,0]", "camera.ortho_height=" + camera});
        Scene scene = loadFile(writeTo(folder, "ortho.gltf", b.gltf()), overrides);
        const std::vector<float> image = renderImage(scene, 1, 16);
        double covered = 0;
        for (std::size_t p = 3; p < image.size(); p += 4) covered += static_cast<double>(image[p]);
        return covered / (64 * 64);
    };
    for (const int shutter : {0, 1}) {
        CHECK(coverage(-3, "", shutter) == Approx(1.0 / 16).epsilon(0.01));
        CHECK(coverage(-50, "", shutter) == Approx(1.0 / 16).epsilon(0.01));
        CHECK(coverage(-3, "2", shutter) == Approx(0.25).epsilon(0.01)); // the scene file's own
    }
}

TEST_CASE("KHR_materials_variants: the file's own materials, or those of the variant that is asked for", "[gltf]") {
    const std::string folder = outputFolder("gltf_geometry");
    GltfBuilder b = roofGltf();
    b.json["extensions"]["KHR_materials_variants"]["variants"] = {{{"name", "night"}}, {{"name", "day"}}};
    nlohmann::json &primitive = b.json["meshes"][0]["primitives"][0];
    primitive["material"] = 0;
    primitive["extensions"]["KHR_materials_variants"]["mappings"] = {{{"material", 1}, {"variants", {1}}}};
    b.json["materials"] = {{{"name", "black"}}, {{"name", "white"}}};
    b.json["extensionsUsed"] = {"KHR_materials_variants"};
    const std::string path = writeTo(folder, "variants.gltf", b.gltf());
    const auto material = [&](const std::vector<std::string> &overrides) {
        const Scene scene = loadFile(path, overrides);
        return scene.materials.at(scene.objects.at(0).materials.at(0)).name;
    };
    CHECK(material({}) == "black");
    CHECK(material({"mesh.0.variant=day"}) == "white");
    CHECK(material({"mesh.0.variant=1"}) == "white");
    CHECK(material({"mesh.0.variant=night"}) == "black"); // no mapping: the primitive's own
    CHECK(says(errorOf([&] { material({"mesh.0.variant=dai"}); }), "'dai'", {"none, night, day", "did you mean 'day'?"}));
    CHECK(loadFile(path).files.at(0).variants == std::vector<std::string>{"night", "day"});
}

TEST_CASE("case two-clips: clips of different nodes play together", "[gltf][cases]") {
    const auto path = caseFile("two-clips/a.glb");
    if (!path) return;
    const Scene scene = loadFile(*path);
    // After half a second A has moved by 0.5 along x, B from z = -3 to -1.5 (which is y in the world, turned).
    CHECK(close(DVec3(worldPositions(scene, scene.objects.at(0), 13).at(4)), DVec3(0.5, 0, 0), 1e-5));
    CHECK(close(DVec3(worldPositions(scene, scene.objects.at(1), 13).at(4)), DVec3(0, 1.5, 0), 1e-5));
    const Scene one = loadFile(*path, {"mesh.0.clip=Bclip"});
    CHECK(close(DVec3(worldPositions(one, one.objects.at(0), 13).at(4)), DVec3(0, 0, 0), 1e-5));
    REQUIRE(scene.files.size() == 1);
    CHECK(scene.files[0].clips == std::vector<std::pair<std::string, double>>{{"Aclip", 1.0}, {"Bclip", 1.0}});
}

TEST_CASE("clips of one node's channels play together, a second for the same channel does not, and --frames clip is their length",
          "[gltf]") {
    const std::string folder = outputFolder("gltf_geometry");
    GltfBuilder b = roofGltf();
    const int halfSecond = b.addFloats("SCALAR", {0, 0.5F});
    const int second = b.addFloats("SCALAR", {0, 1});
    const int up = b.addFloats("VEC3", {0, 0, 0, 0, 1, 0});
    const int grow = b.addFloats("VEC3", {1, 1, 1, 3, 3, 3});
    const int down = b.addFloats("VEC3", {0, 0, 0, 0, -9, 0});
    const auto clip = [](const char *name, const char *path, int input, int output) {
        return nlohmann::json{{"name", name},
                              {"channels", {{{"sampler", 0}, {"target", {{"node", 0}, {"path", path}}}}}},
                              {"samplers", {{{"input", input}, {"output", output}}}}};
    };
    b.json["animations"] = {clip("rise", "translation", halfSecond, up), clip("grow", "scale", second, grow),
                            clip("fall", "translation", second, down)};
    const std::string path = writeTo(folder, "clips.gltf", b.gltf());
    Warnings warnings;
    const Scene scene = loadScene(path, {"render.frames=clip"}, warnings);
    REQUIRE(warnings.lines.size() == 1);
    CHECK(says(warnings.lines[0], "1 of 3 clips move what an earlier one moves and do not play ('fall')", {"`clip`"}));
    CHECK(scene.render.frames.size() == 24);
    CHECK(scene.render.frames.back() == 24);
    // At half a second: risen by 1 and twice as large.
    CHECK(close(DVec3(worldPositions(scene, scene.objects.at(0), 13).at(3)), DVec3(-2, 0, 3), 1e-5));
    CHECK(loadFile(path, {"mesh.0.clip=rise", "render.frames=clip"}).render.frames.size() == 12);
    CHECK(says(errorOf([&] { loadFile(path, {"mesh.0.clip=none", "render.frames=clip"}); }), "found 'clip', but no clip plays", {}));
}

TEST_CASE("a clip moves a node whose rest is a matrix", "[gltf]") {
    const std::string folder = outputFolder("gltf_geometry");
    GltfBuilder b = roofGltf();
    // Mirrored in x, scaled by 2 along y, a quarter turn about z, at (4, 0, 0).
    b.json["nodes"][0]["matrix"] = {0, -1, 0, 0, -2, 0, 0, 0, 0, 0, 1, 0, 4, 0, 0, 1};
    const int times = b.addFloats("SCALAR", {0, 1});
    const int places = b.addFloats("VEC3", {4, 0, 0, 4, 0, 10});
    const std::string still = writeTo(folder, "still.gltf", b.gltf());
    b.json["animations"] = {{{"channels", {{{"sampler", 0}, {"target", {{"node", 0}, {"path", "translation"}}}}}},
                             {"samplers", {{{"input", times}, {"output", places}}}}}};
    const Scene resting = loadFile(still);
    const Scene moving = loadFile(writeTo(folder, "moving.gltf", b.gltf()));
    const std::vector<Vec3> rest = worldPositions(resting, resting.objects.at(0), 1);
    const std::vector<Vec3> first = worldPositions(moving, moving.objects.at(0), 1);
    const std::vector<Vec3> later = worldPositions(moving, moving.objects.at(0), 13);
    for (std::size_t v = 0; v < rest.size(); ++v) {
        CHECK(close(DVec3(first[v]), DVec3(rest[v]), 1e-5));
        CHECK(close(DVec3(later[v]), DVec3(rest[v]) + DVec3(0, -5, 0), 1e-5));
    }
}
