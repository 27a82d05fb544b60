/// `taut export`: every writer's file read again by readers that are not ours, against one another and against the deformation
/// itself; bad input.

#include "assets.h"
#include "command.h"

#include "taut/formats/point_cache.h"
#include "taut/formats/read_mesh.h"
#include "taut/export/gloss_export.h"
#include "taut/scene/load_scene.h"

#include <nlohmann/json.hpp>

using namespace taut;
using namespace taut::test;

namespace {

/// Two materials on one twisted, sheared and stretched grid: a seam between materials, a mirrored half of the UV map.
std::string writeScene(const std::string &folder) {
    std::string obj;
    constexpr int kCells = 6;
    for (int y = 0; y <= kCells; ++y)
        for (int x = 0; x <= kCells; ++x) {
            obj += "v " + std::to_string(x / 3.0 - 1) + " " + std::to_string(y / 3.0 - 1) + " " + std::to_string(0.02 * x * y) + "\n";
            obj += "vt " + std::to_string(std::abs(x - 3) / 3.0) + " " + std::to_string(y / 6.0) + "\n";
        }
    for (int y = 0; y < kCells; ++y)
        for (int x = 0; x < kCells; ++x) {
            const int a = 1 + x + y * (kCells + 1);
            const int b = a + kCells + 1;
            if (x == 0) obj += y < 3 ? "usemtl Lower\n" : "usemtl Upper\n";
            const auto corner = [](int i) { return std::to_string(i) + "/" + std::to_string(i) + " "; };
            obj += "f " + corner(a) + corner(a + 1) + corner(b + 1) + corner(b) + "\n";
        }
    writeBytes(folder + "/grid.obj", obj);
    writeBytes(folder + "/scene.toml", R"(
[render]
frames = "1-4"
fps = 24
[material.Lower]
type = "conductor"
f0 = [1, 1, 1]
alpha = [0.1, 0.3]
rotation_deg = 30
[material.Upper]
type = "conductor"
metal = "Au"
alpha = 0.2
poisson = 0.4
[[mesh]]
file = "grid.obj"
material = { Lower = "Lower", Upper = "Upper" }
translate = [0.5, -0.25, 2]
rotate_deg = [20, 0, 40]
scale = 1.5
[[mesh.deform]]
type = "twist"
axis = "x"
angle_deg = [[1, 0], [4, 70]]
[[mesh.deform]]
type = "shear"
plane = "xy"
amount = [[1, 0], [4, 0.8]]
)");
    return folder + "/scene.toml";
}

CommandResult exportIn(const std::string &folder, Arguments arguments) {
    arguments.insert(arguments.begin(), "export");
    return runTaut(arguments, folder);
}

/// An interpreter that has numpy; empty where there is none.
std::string pythonWithNumpy() {
    for (const std::string python : {"python3", "/usr/bin/python3"})
        if (runProgram({python, "-c", "import numpy; numpy.load"}, 60).exitCode == 0) return python;
    std::cout << "SKIPPED: there is no python3 with numpy on this machine" << std::endl;
    return "";
}

Scene load(const std::string &path) {
    Warnings warnings;
    return loadScene(path, {}, warnings);
}

} // namespace

TEST_CASE("export: M is A M0 of the deformation at every vertex", "[export]") {
    const Scene scene = load(writeScene(freshFolder("export_m")));
    GlossObject object;
    prepareGlossObject(scene, scene.objects.front(), object);
    const GlossMesh &mesh = object.mesh;
    REQUIRE(mesh.materials.size() == 2);
    CHECK(mesh.triangles.size() == 72);
    // 49 points; the row between the materials twice. The UV map's mirror line splits the middle column once more.
    CHECK(object.sources.size() == 49 + 7 + 7 + 1);
    double worst = 0;
    for (const double frame : {1.0, 2.5, 4.0}) {
        glossAtFrame(scene, frame, {}, object);
        for (std::size_t v = 0; v < mesh.vertexCount(); ++v) {
            const Material &material = scene.materials[object.materials[v]];
            const DVec3 n(mesh.normals[v]);
            const DVec3 t(Vec3(mesh.tangents[v]));
            const DVec3 b = glm::cross(n, t);
            // A = [t.ds t.dt; b.ds b.dt], M0 = R diag(1/alpha), lambda from the area: all in double.
            const glm::dmat2 a(glm::dot(t, DVec3(mesh.ds[v])), glm::dot(b, DVec3(mesh.ds[v])), glm::dot(t, DVec3(mesh.dt[v])),
                               glm::dot(b, DVec3(mesh.dt[v])));
            const auto angle = static_cast<double>(material.rotation.value);
            const glm::dmat2 rotation(std::cos(angle), std::sin(angle), -std::sin(angle), std::cos(angle));
            const glm::dmat2 alpha(1 / static_cast<double>(material.alphaX.value), 0, 0, 1 / static_cast<double>(material.alphaY.value));
            const double nu = static_cast<double>(material.poisson);
            const glm::dmat2 full = a * rotation * alpha * std::pow(std::fabs(glm::determinant(a)), nu / (1 - nu));
            const glm::dmat2 expected = full * glm::transpose(full);
            const glm::dmat2 block(static_cast<double>(mesh.m[v].x), 0, static_cast<double>(mesh.m[v].y), static_cast<double>(mesh.m[v].z));
            const glm::dmat2 got = block * glm::transpose(block);
            const double size = expected[0][0] + expected[1][1];
            for (int i = 0; i < 2; ++i)
                for (int k = 0; k < 2; ++k) worst = std::max(worst, std::fabs(got[i][k] - expected[i][k]) / size);
            CHECK(std::fabs(glm::dot(n, t)) < 1e-6);
            if (frame == 1.0) CHECK(mesh.stretch[v].x == Approx(1).margin(2e-6)); // at rest the placement leaves no trace
        }
    }
    std::cout << "exported M M^T against A M0 in double: largest relative difference " << worst << std::endl;
    CHECK(worst < 3e-6);
}

TEST_CASE("export: a leaning M has its third column", "[export]") {
    const std::string folder = freshFolder("export_lean");
    writeBytes(folder + "/flat.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nf 1/1 2/2 3/3 4/4\n");
    writeBytes(folder + "/scene.toml", R"(
[material.metal]
type = "conductor"
alpha = [0.1, 0.4]
[[mesh]]
file = "flat.obj"
material = "metal"
lean = true
[[mesh.deform]]
type = "shear"
plane = "xz"
amount = 0.7
)"); // x moves by 0.7 z: the surface stays, the space above it leans along the tangent
    const Scene scene = load(folder + "/scene.toml");
    GlossObject object;
    prepareGlossObject(scene, scene.objects.front(), object);
    glossAtFrame(scene, 1, {}, object);
    for (std::size_t v = 0; v < 4; ++v) {
        CHECK(object.mesh.m[v].x == Approx(10));
        CHECK(object.mesh.m[v].y == Approx(0).margin(1e-5));
        CHECK(object.mesh.m[v].z == Approx(2.5));
        CHECK(object.mesh.lean[v].x == Approx(0.7));
        CHECK(object.mesh.lean[v].y == Approx(0).margin(1e-6));
    }
}

TEST_CASE("export: rest positions carry the frame's M", "[export]") {
    const Scene scene = load(writeScene(freshFolder("export_rest")));
    GlossObject world;
    GlossObject rest;
    GlossObject start;
    for (GlossObject *object : {&world, &rest, &start}) prepareGlossObject(scene, scene.objects.front(), *object);
    glossAtFrame(scene, 3, {}, world);
    glossAtFrame(scene, 3, {true, nullptr}, rest);
    CHECK(rest.mesh.positions == rest.mesh.restPositions);
    CHECK(rest.mesh.m == world.mesh.m);
    CHECK(rest.mesh.alpha == world.mesh.alpha);
    glossAtFrame(scene, 1, {}, start); // undeformed: a placement away
    const DMat4 placement = placementAt(scene.objects.front().placement, 1);
    const DMat3 rotation = DMat3(placement) / std::cbrt(glm::determinant(DMat3(placement)));
    for (std::size_t v = 0; v < start.mesh.vertexCount(); ++v) {
        const Vec3 placed(DVec3(placement * glm::dvec4(DVec3(rest.mesh.positions[v]), 1)));
        CHECK(glm::length(placed - start.mesh.positions[v]) < 1e-5F);
        CHECK(glm::length(Vec3(rotation * DVec3(rest.mesh.normals[v])) - start.mesh.normals[v]) < 1e-5F);
        CHECK(glm::length(Vec3(rotation * DVec3(Vec3(rest.mesh.tangents[v]))) - Vec3(start.mesh.tangents[v])) < 1e-5F);
    }
}

TEST_CASE("export: every format says the same, read by other readers", "[export][python]") {
    const std::string folder = freshFolder("export_formats");
    writeScene(folder);
    const CommandResult result = exportIn(folder, {"scene.toml", "--frames", "3", "-o", "m.npz", "-o", "m.csv", "-o", "m.ply", "-o",
                                                   "m.glb", "-o", "m.gltf", "--json", "--convention", "openpbr"});
    INFO(result.err);
    REQUIRE(result.exitCode == 0);
    REQUIRE(exportIn(folder, {"scene.toml", "--frames", "3", "-o", "t.ply", "--ascii", "--convention", "openpbr"}).exitCode == 0);
    REQUIRE(exportIn(folder, {"scene.toml", "--frames", "1-4", "-o", "m.usda", "--convention", "openpbr"}).exitCode == 0);
    const nlohmann::json report = nlohmann::json::parse(result.out);
    CHECK(report["files"].size() == 5);
    CHECK(report["clipped"] == 0);
    for (const std::string &name : namesIn(folder)) CHECK(name.find(".partial") == std::string::npos);
    // Our own reader.
    Warnings warnings;
    const Mesh binary = readMesh(folder + "/m.ply", warnings);
    const Mesh text = readMesh(folder + "/t.ply", warnings);
    CHECK(binary.positions == text.positions);
    CHECK(binary.positions.size() == report["objects"][0]["vertices"]);
    CHECK(binary.faceCount() == 72);
    CHECK(warnings.lines.empty());
    const std::string python = pythonWithNumpy();
    if (python.empty()) return;
    const CommandResult checked = runProgram({python, TAUT_SOURCE_DIR "/tests/export/check_export.py", folder, "3"}, 60);
    INFO(checked.out << checked.err);
    CHECK(checked.exitCode == 0);
    CHECK(checked.out.find("SAME 64 vertices") != std::string::npos);
}

TEST_CASE("export: glTF files pass the Khronos validator", "[export][gltf]") {
    const std::string folder = freshFolder("export_validator");
    writeScene(folder);
    REQUIRE(exportIn(folder, {"scene.toml", "--frames", "1,4", "-o", "m.####.glb", "-o", "m.####.gltf", "--convention", "khr"}).exitCode ==
            0);
    Arguments words{"node", TAUT_SOURCE_DIR "/tests/export/validate_gltf.js"};
    for (const char *name : {"/m.0001.glb", "/m.0004.glb", "/m.0004.gltf"}) words.push_back(folder + name);
    ::setenv("NODE_PATH", TAUT_SOURCE_DIR "/build/tools/node_modules", 0);
    const CommandResult result = runProgram(words, 60);
    INFO(result.out << result.err);
    if (result.exitCode == 77 || result.exitCode == 127 || result.out.empty()) {
        std::cout << "SKIPPED: there is no node with gltf-validator on this machine (make export-tools)" << std::endl;
        return;
    }
    CHECK(result.exitCode == 0);
    CHECK(result.out.find("m.0004.gltf: 0 errors, 0 warnings") != std::string::npos);
}

TEST_CASE("export: point caches hold the mesh's own points over the frames", "[export][point_cache]") {
    const std::string folder = freshFolder("export_caches");
    const Scene scene = load(writeScene(folder));
    REQUIRE(exportIn(folder, {"scene.toml", "--frames", "2-4", "-o", "m.pc2", "-o", "m.mdd"}).exitCode == 0);
    for (const std::string name : {"/m.pc2", "/m.mdd"}) {
        PointCacheReader reader(folder + name);
        CHECK(reader.info().points == 49);
        CHECK(reader.info().samples == 3);
        for (int frame = 2; frame <= 4; ++frame) CHECK(reader.info().sampleAtFrame(frame, 24) == Approx(frame - 2).margin(1e-5));
        std::vector<Vec3> points;
        reader.read(2, points);
        GlossObject object;
        prepareGlossObject(scene, scene.objects.front(), object);
        std::vector<Vec3> expected;
        pointsAtFrame(scene, 4, PointSpace::World, object, expected);
        CHECK(points == expected);
        glossAtFrame(scene, 4, {}, object);
        const Surface &surface = object.surface.surface;
        for (std::size_t v = 0; v < object.sources.size(); ++v) // the same places as the vertices
            CHECK(glm::length(points[surface.surfacePosition[surface.vertexSurface[object.sources[v]]]] - object.mesh.positions[v]) <
                  1e-6F);
    }
    // Without the placement, at rest: the file's own points.
    REQUIRE(exportIn(folder, {"scene.toml", "--frames", "1", "-o", "own.pc2", "--space", "object"}).exitCode == 0);
    PointCacheReader own(folder + "/own.pc2");
    std::vector<Vec3> points;
    own.read(0, points);
    for (std::size_t i = 0; i < points.size(); ++i) CHECK(glm::length(points[i] - scene.objects.front().mesh->positions[i]) < 1e-6F);
    REQUIRE(exportIn(folder, {"scene.toml", "--frames", "2-4", "-o", "fine.pc2", "--level", "1"}).exitCode == 0);
    CHECK(PointCacheReader(folder + "/fine.pc2").info().points == 13 * 13);
}

TEST_CASE("export: several objects, names and clips", "[export]") {
    const std::string folder = freshFolder("export_objects");
    writeScene(folder);
    std::string scene = readBytes(folder + "/scene.toml");
    scene += "[[mesh]]\nfile = \"grid.obj\"\nname = \"a/b c\"\nmaterial = \"Lower\"\n";
    writeBytes(folder + "/scene.toml", scene);
    const CommandResult result = exportIn(folder, {"scene.toml", "--frames", "4", "-o", "o/####.ply", "-o", "o/all.glb", "-o", "o/all.usda",
                                                   "--convention", "blender", "--json", "-D", "material.Lower.alpha=[0.02, 0.3]"});
    INFO(result.err);
    REQUIRE(result.exitCode == 0);
    CHECK(namesIn(folder + "/o") == std::vector<std::string>{"0004.a_b_c.ply", "0004.grid.ply", "all.glb", "all.usda"});
    CHECK(nlohmann::json::parse(result.out)["clipped"] > 0); // a ratio under 0.1
    CHECK(result.err.find("lay outside its limits and were clipped") != std::string::npos);
    REQUIRE(exportIn(folder, {"scene.toml", "--frames", "4", "-o", "one.ply", "--object", "a/b c"}).exitCode == 0);
    CHECK(fs::exists(folder + "/one.ply"));
}

TEST_CASE("export: objects are not limited by the files that may be open", "[export]") {
    const std::string folder = freshFolder("export_open_files");
    writeScene(folder);
    std::string scene = readBytes(folder + "/scene.toml");
    for (int i = 0; i < 100; ++i) scene += "[[mesh]]\nfile = \"grid.obj\"\nmaterial = \"Lower\"\n";
    writeBytes(folder + "/scene.toml", scene);
    const CommandResult result = runShell("ulimit -Sn 64; exec \"$0\" export scene.toml --frames 1-3 -o all.usda -o p/all.pc2 -q", folder);
    INFO(result.err);
    REQUIRE(result.exitCode == 0);
    CHECK(namesIn(folder + "/p").size() == 101);
    // Samples of several frames, attributes and meshes come back from one spool: as from a file of one mesh.
    REQUIRE(exportIn(folder, {"scene.toml", "--frames", "1-3", "-o", "one.usda", "-q", "--object", "grid"}).exitCode == 0);
    const std::string all = readBytes(folder + "/all.usda");
    const std::string one = readBytes(folder + "/one.usda");
    const std::size_t begin = one.find("    def Mesh");
    CHECK(all.find(one.substr(begin, one.rfind("}\n") - begin)) != std::string::npos);
}

TEST_CASE("export: bad input is one line and leaves nothing", "[export][malformed]") {
    const std::string folder = freshFolder("export_bad");
    writeScene(folder);
    const std::vector<std::string> before = namesIn(folder);
    const std::vector<std::pair<Arguments, std::string>> bad{
        {{"scene.toml"}, "--output is required"},
        {{"scene.toml", "-o", "a.plx"}, "did you mean 'ply'?"},
        {{"scene.toml", "-o", "a.ply"}, "a frame number such as ####"},
        {{"scene.toml", "-o", "####.pc2"}, "without a frame number"},
        {{"scene.toml", "--frames", "1,2,4", "-o", "a.pc2"}, "evenly spaced"},
        {{"scene.toml", "--frames", "3,1", "-o", "a.usda"}, "increasing"},
        {{"scene.toml", "-o", "####.ply", "--convention", "blendr"}, "did you mean 'blender'?"},
        {{"scene.toml", "-o", "####.ply", "--positions", "rset"}, "did you mean 'rest'?"},
        {{"scene.toml", "-o", "####.ply", "--space", "object"}, "a .pc2 or .mdd"},
        {{"scene.toml", "-o", "####.ply", "--space", "wrld"}, "did you mean 'world'?"},
        {{"scene.toml", "-o", "####.ply", "--object", "grd"}, "did you mean 'grid'?"},
        {{"scene.toml", "-o", "####.ply", "--level", "9"}, "9"},
        {{"missing.toml", "-o", "####.ply"}, "missing.toml"},
    };
    for (const auto &[arguments, says] : bad) {
        const CommandResult result = exportIn(folder, arguments);
        INFO(result.err);
        CHECK(result.exitCode == 2);
        CHECK(errorLine(result).find(says) != std::string::npos);
    }
    CHECK(exportIn(folder, {"scene.toml", "--frames", "1", "-o", "/proc/nowhere/a.ply"}).exitCode == 1);
    CHECK(namesIn(folder) == before);
}
