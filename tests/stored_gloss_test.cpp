/// Export and back: a mesh with a stored M renders as the deformed mesh that it was exported from.

#include "assets.h"
#include "command.h"
#include "render_fixtures.h"

#include "study/measures/image_error.h"
#include "taut/export/gloss_export.h"
#include "taut/formats/read_mesh.h"
#include "taut/scene/load_scene.h"

using namespace taut;
using namespace taut::test;

namespace {

constexpr const char *kHead = R"(
[render]
width = 64
height = 48
spp = 16
max_events = 3
frames = "1-8"
filter = "box"
[camera]
position = [0.3, -3.4, 2.6]
fov_deg = 40
[environment]
radiance = [0.2, 0.25, 0.3]
[[light]]
type = "quad"
corner = [0.6, 2.2, 2.6]
u = [-1.2, 0, 0]
v = [0, 0.5, -0.45]
radiance = [6, 5, 4]
[material.metal]
type = "conductor"
f0 = [1, 0.9, 0.8]
alpha = [0.1, 0.45]
rotation_deg = 25
multiscatter = "off"
)";

Scene load(const std::string &path) {
    Warnings warnings;
    return loadScene(path, {}, warnings);
}

/// Writes the scene with `meshPart`, exports a frame in `extension`, and renders both that frame and what was exported, with the
/// same random numbers; `material` of the second scene says another alpha, which must not matter. Returns the relMSE.
double roundTrip(const std::string &folder, const std::string &meshPart, const std::string &extension) {
    writeBytes(folder + "/scene.toml", kHead + meshPart);
    REQUIRE(runTaut({"export", "scene.toml", "--frames", "8", "-q", "-o", "m." + extension}, folder).exitCode == 0);
    std::string other = kHead;
    other.replace(other.find("[0.1, 0.45]"), 11, "0.7");
    writeBytes(folder + "/back_" + extension + ".toml", other + "[[mesh]]\nfile = \"m." + extension + "\"\nmaterial = \"metal\"\n");
    const std::vector<float> direct = renderImage(load(folder + "/scene.toml"), 8, 16);
    const std::vector<float> back = renderImage(load(folder + "/back_" + extension + ".toml"), 8, 16);
    const double error = chart::relativeMse(coloursOf(back), coloursOf(direct));
    std::cout << "rendered from a stored M (" << extension << ") against the deformed mesh: relMSE " << error << std::endl;
    return error;
}

} // namespace

TEST_CASE("stored gloss: a sheared panel comes back from PLY and glTF as it was", "[export][stored]") {
    const std::string folder = freshFolder("stored_panel");
    const std::string part = "[[mesh]]\nfile = \"" TAUT_SOURCE_DIR "/meshes/panel.obj\"\nmaterial = \"metal\"\nrotate_deg = [0, 0, 10]\n"
                             "[[mesh.deform]]\ntype = \"shear\"\nplane = \"xy\"\namount = [[1, 0], [8, 1.2]]\n";
    for (const std::string extension : {"ply", "glb"}) CHECK(roundTrip(folder, part, extension) < 1e-9);
    // It must not be the material's alpha that is seen.
    const Scene back = load(folder + "/back_ply.toml");
    Scene without = back;
    Mesh mesh = *back.objects.front().mesh;
    mesh.storedM.clear();
    without.objects.front().mesh = std::make_shared<const Mesh>(std::move(mesh));
    const double blind = chart::relativeMse(coloursOf(renderImage(without, 8, 16)), coloursOf(renderImage(back, 8, 16)));
    CHECK(blind > 0.01);
}

TEST_CASE("stored gloss: a twisted body, where M varies, comes back closely", "[export][stored]") {
    const std::string folder = freshFolder("stored_body");
    const std::string mesh = "[[mesh]]\nfile = \"" TAUT_SOURCE_DIR "/meshes/body.obj\"\nmaterial = \"metal\"\n"
                             "[[mesh.deform]]\ntype = \"twist\"\naxis = \"z\"\nangle_deg = [[1, 0], [8, 150]]\n"
                             "[[mesh.deform]]\ntype = \"stretch\"\nfactor = [[1, [1, 1, 1]], [8, [0.8, 0.8, 1.5]]]\n";
    // Inside triangles a varying V R M0 and its square root are interpolated, which differ in second order.
    for (const std::string extension : {"ply", "glb"}) CHECK(roundTrip(folder, mesh, extension) < 1e-5);
}

TEST_CASE("stored gloss: exported again it is the same, and deformed further it is A M", "[export][stored]") {
    const std::string folder = freshFolder("stored_again");
    writeBytes(folder + "/scene.toml", std::string(kHead) + "[[mesh]]\nfile = \"" TAUT_SOURCE_DIR
                                                            "/meshes/plate.obj\"\nmaterial = \"metal\"\n[[mesh.deform]]\ntype = \"shear\"\n"
                                                            "plane = \"xy\"\namount = [[1, 0], [8, 0.7]]\n");
    REQUIRE(runTaut({"export", "scene.toml", "--frames", "4,8", "-q", "-o", "m.####.ply", "-o", "m.####.glb"}, folder).exitCode == 0);
    const auto gloss = [&](const std::string &toml, double frame) {
        static std::vector<Scene> scenes; // what a GlossObject refers to
        scenes.reserve(16);
        scenes.push_back(load(toml));
        GlossObject object;
        prepareGlossObject(scenes.back(), scenes.back().objects.front(), object);
        glossAtFrame(scenes.back(), frame, {}, object);
        return object.mesh;
    };
    const GlossMesh middle = gloss(folder + "/scene.toml", 4);
    const GlossMesh end = gloss(folder + "/scene.toml", 8);
    for (const std::string extension : {"ply", "glb"}) {
        const std::string file =
            "[[mesh]]\nfile = \"m.0004." + extension + "\"\nmaterial = \"metal\"\nrotate_deg = [0, 0, 30]\nscale = 3\n";
        writeBytes(folder + "/back.toml", kHead + file);
        const GlossMesh back = gloss(folder + "/back.toml", 8);
        REQUIRE(back.vertexCount() == middle.vertexCount());
        for (std::size_t v = 0; v < back.vertexCount(); ++v) { // a placement changes no gloss
            CHECK(back.alpha[v].x == Approx(middle.alpha[v].x).epsilon(1e-5));
            CHECK(back.alpha[v].y == Approx(middle.alpha[v].y).epsilon(1e-5));
            CHECK(back.alpha[v].z == Approx(middle.alpha[v].z).margin(1e-5));
        }
        // Frame 4 is sheared by 0.3; 0.4 more makes frame 8, since shears add up.
        writeBytes(folder + "/on.toml", std::string(kHead) + "[[mesh]]\nfile = \"m.0004." + extension + "\"\nmaterial = \"metal\"\n" +
                                            "up = \"z\"\n[[mesh.deform]]\ntype = \"shear\"\nplane = \"xy\"\namount = 0.4\n");
        if (extension == "glb") continue; // its deformers act in the file's own space, y up
        const GlossMesh on = gloss(folder + "/on.toml", 8);
        for (std::size_t v = 0; v < on.vertexCount(); ++v) {
            CHECK(on.alpha[v].x == Approx(end.alpha[v].x).epsilon(1e-5));
            CHECK(on.alpha[v].y == Approx(end.alpha[v].y).epsilon(1e-5));
            CHECK(on.alpha[v].z == Approx(end.alpha[v].z).margin(1e-5));
        }
    }
}

TEST_CASE("stored gloss: what is malformed is said", "[export][stored][malformed]") {
    const std::string folder = freshFolder("stored_bad");
    const auto ply = [&](const std::string &properties, const std::string &row) {
        std::string text = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n" + properties +
                           "element face 1\nproperty list uchar int vertex_indices\nend_header\n";
        for (const std::string corner : {"0 0 0 ", "1 0 0 ", "0 1 0 "}) text += corner + row + "\n";
        writeBytes(folder + "/m.ply", text + "3 0 1 2\n");
        Warnings warnings;
        return readMesh(folder + "/m.ply", warnings);
    };
    const std::string m = "property float M_x\nproperty float M_y\nproperty float M_z\n";
    const std::string frame = "property float tangent_x\nproperty float tangent_y\nproperty float tangent_z\n";
    const Mesh good = ply(m + frame, "10 1 5 1 0 0");
    REQUIRE(good.storedM.size() == 3);
    CHECK(good.storedM[1] == Vec3(10, 1, 5));
    CHECK(good.tangents[2] == Vec4(1, 0, 0, 1));
    CHECK(ply(m, "10 1 5").storedM.empty()); // no frame to be in
    CHECK_THROWS_WITH(ply(m + frame, "0 1 5 1 0 0"), Catch::Contains("m.ply:16:") && Catch::Contains("M_x and M_z above 0"));
    CHECK_THROWS_WITH(ply(m + frame, "10 1 -5 1 0 0"), Catch::Contains("above 0"));
    CHECK_THROWS_AS(ply(m + frame, "10 nan 5 1 0 0"), InputError);
}
