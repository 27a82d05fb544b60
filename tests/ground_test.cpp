// The stage of a bare file: where the ground lies and how far it goes, what is framed, what stays as the file has it.

#include "assets.h"
#include "cli_fixtures.h"
#include "mesh_samples.h"

#include "taut/scene/ground.h"
#include "taut/scene/load_scene.h"

#include <nlohmann/json.hpp>

#include <cmath>

using namespace taut;
using namespace taut::test;

namespace {

/// A box from a corner to another, outward.
std::string boxObj(const DVec3 &a, const DVec3 &b) {
    std::ostringstream text;
    text.precision(12);
    for (int i = 0; i < 8; ++i)
        text << "v " << ((i & 1) ? b.x : a.x) << ' ' << ((i & 2) ? b.y : a.y) << ' ' << ((i & 4) ? b.z : a.z) << '\n';
    text << "f 1 3 4 2\nf 5 6 8 7\nf 1 2 6 5\nf 3 7 8 4\nf 1 5 7 3\nf 2 4 8 6\n";
    return text.str();
}

Scene bare(const std::string &path, const std::vector<std::string> &overrides = {}) {
    Warnings warnings;
    return loadScene(path, overrides, warnings);
}

/// Where a world point is in the picture: -1 to 1 across and up.
DVec2 seenAt(const Scene &scene, const DVec3 &p) {
    const CameraState camera = cameraAtFrame(scene.camera, 1, scene.render.fps);
    const DVec3 local(glm::inverse(camera.worldFromCamera) * glm::dvec4(p, 1));
    const double tangent = std::tan(camera.fovY / 2);
    return {local.x / -local.z / tangent * scene.render.height / scene.render.width, local.y / -local.z / tangent};
}

Image rendered(const std::string &folder, const std::string &file, Arguments more, int spp = 16) {
    Arguments words{"render", file, "-q", "--spp", std::to_string(spp), "-o", "a.exr", "-D", "render.width=64", "-D", "render.height=36"};
    words.insert(words.end(), more.begin(), more.end());
    requireSuccess(runTaut(words, folder));
    return readImage(folder + "/a.exr");
}

/// A box with a camera and a lamp of its own, y up.
std::string ownStage(bool camera, bool lamp) {
    GltfBuilder b;
    const int positions = b.addFloats("VEC3", {0, 0, 0, 1, 0, 0, 1, 2, 0, 0, 2, 0});
    const int indices = b.add<std::uint16_t>("SCALAR", 5123, {0, 1, 2, 0, 2, 3});
    b.json["meshes"] = {{{"primitives", {{{"attributes", {{"POSITION", positions}}}, {"indices", indices}}}}}};
    b.json["nodes"] = {{{"mesh", 0}}};
    nlohmann::json nodes{0};
    if (camera) {
        b.json["cameras"] = {{{"type", "perspective"}, {"perspective", {{"yfov", 0.6}, {"znear", 0.1}}}}};
        nodes.push_back(b.json["nodes"].size());
        b.json["nodes"].push_back({{"camera", 0}, {"translation", {0.5, 1, 6}}});
    }
    if (lamp) {
        b.json["extensionsUsed"] = {"KHR_lights_punctual"};
        b.json["extensions"] = {{"KHR_lights_punctual", {{"lights", {{{"type", "point"}, {"intensity", 20}}}}}}};
        nodes.push_back(b.json["nodes"].size());
        b.json["nodes"].push_back({{"translation", {1, 3, 2}}, {"extensions", {{"KHR_lights_punctual", {{"light", 0}}}}}});
    }
    b.json["scenes"] = {{{"nodes", nodes}}};
    return b.gltf();
}

} // namespace

TEST_CASE("ground: it lies below the lowest point, and all is framed with room", "[ground]") {
    const std::string folder = freshFolder("box");
    struct Case {
        const char *name;
        DVec3 a, b;
    };
    for (const Case &c : {Case{"cube", {-1, -1, -1}, {1, 1, 1}},
                          {"wide", {-5, -0.2, 3}, {5, 0.2, 3.5}},
                          {"tall", {10, 10, 0}, {10.1, 10.1, 4}},
                          {"flat", {-1, -2, 0.5}, {1, 2, 0.5}},
                          {"far", {1e6, 1e6, 1e6}, {1e6 + 2, 1e6 + 2, 1e6 + 2}}}) {
        CAPTURE(c.name);
        const std::string path = folder + "/" + c.name + ".obj";
        writeBytes(path, boxObj(c.a, c.b));
        Scene scene = bare(path);
        const std::optional<Ground> ground = groundOf(scene);
        REQUIRE(ground);
        const double radius = glm::length(c.b - c.a) / 2;
        CHECK(ground->height < c.a.z);
        CHECK(ground->height > c.a.z - 1e-3 * radius - 1e-6 * glm::length(c.b));
        CHECK(glm::length(ground->centre - DVec2(c.a + c.b) / 2.0) < 1e-5 * (radius + glm::length(c.b)));
        CHECK(ground->radius > 15 * radius);
        const std::size_t objects = scene.objects.size();
        standOn(*ground, scene);
        CHECK(scene.objects.size() == objects + 1);
        CHECK(scene.objects.back().name == "ground");
        double greatest = 0, left = 1, right = -1, lower = 1, upper = -1;
        for (int i = 0; i < 8; ++i) {
            const DVec2 at = seenAt(scene, {(i & 1) ? c.b.x : c.a.x, (i & 2) ? c.b.y : c.a.y, (i & 4) ? c.b.z : c.a.z});
            greatest = std::max({greatest, std::fabs(at.x), std::fabs(at.y)});
            left = std::min(left, at.x), right = std::max(right, at.x), lower = std::min(lower, at.y), upper = std::max(upper, at.y);
        }
        CHECK(greatest == Approx(0.74).margin(0.01)); // one side is as full as it may be
        CHECK((std::fabs(left + right) < 0.02 || std::fabs(lower + upper) < 0.02));
    }
}

TEST_CASE("ground: a mesh whose file says nothing of up stands", "[ground]") {
    const std::string folder = freshFolder("up");
    // A table: a slab on four legs, along z and along y.
    const auto table = [](bool yUp) {
        std::string text;
        int first = 0;
        const auto add = [&](const DVec3 &a, const DVec3 &b) {
            const auto turned = [&](const DVec3 &p) { return yUp ? DVec3(p.x, p.z, -p.y) : p; };
            const DVec3 u = turned(a), v = turned(b);
            std::istringstream lines(boxObj(glm::min(u, v), glm::max(u, v)));
            for (std::string line; std::getline(lines, line);) {
                if (line[0] == 'f') {
                    std::istringstream corners(line.substr(1));
                    line = "f";
                    for (int c = 0; corners >> c;) line += " " + std::to_string(c + first);
                }
                text += line + "\n";
            }
            first += 8;
        };
        add({-1, -0.6, 1}, {1, 0.8, 1.1});
        for (const double x : {-0.9, 0.8})
            for (const double y : {-0.5, 0.6}) add({x, y, 0}, {x + 0.1, y + 0.1, 1});
        return text;
    };
    writeBytes(folder + "/z.obj", table(false));
    writeBytes(folder + "/y.obj", table(true));
    CHECK(!groundOf(bare(folder + "/z.obj"))->yUp);
    Scene turned = bare(folder + "/y.obj");
    const Ground ground = *groundOf(turned);
    CHECK(ground.yUp);
    CHECK(ground.height == Approx(0).margin(2e-3));
    standOn(ground, turned);
    CHECK(turned.objects[0].placement.worldFromUp == bare(folder + "/y.obj", {"mesh.0.up=y"}).objects[0].placement.worldFromUp);
    for (const char *said : {"mesh.0.up=z", "mesh.0.up=y", "mesh.0.rotate_deg=[0,0,5]", "camera.position=[0,-5,1]"})
        CHECK(!groundOf(bare(folder + "/y.obj", {said}))->yUp);
    const CommandResult told = runTaut({"render", "y.obj", "--check"}, folder);
    requireSuccess(told);
    CHECK(told.err.find("y is taken for up") != std::string::npos);
    CHECK(runTaut({"render", "z.obj", "--check"}, folder).err.find("up") == std::string::npos);
    // Real ones with y up, and ours, with z.
    for (const char *name : {"static/hand_lowres.obj", "static/penguin_control_mesh.obj", "static/spot_control_mesh.obj",
                             "static/wingnut.obj", "static/goathead.obj"})
        if (const auto path = asset(name)) CHECK(groundOf(bare(*path))->yUp);
    for (const char *name : {"body", "ring", "plate", "panel", "twist_bar"})
        CHECK(!groundOf(bare(std::string(TAUT_SOURCE_DIR "/meshes/") + name + ".obj"))->yUp);
}

TEST_CASE("ground: what moves never falls below it, and is framed at every frame", "[ground]") {
    const std::string folder = freshFolder("motion");
    writeBytes(folder + "/box.obj", boxObj(DVec3(-1), DVec3(1)));
    const std::string falls = "mesh.0.translate=[[1,[0,0,0]],[20,[4,0,-3]]]";
    const Scene first = bare(folder + "/box.obj", {falls});
    CHECK(groundOf(first)->height == Approx(-1).margin(1e-2));
    Scene all = bare(folder + "/box.obj", {falls, "render.frames=\"1-20\""});
    const Ground ground = *groundOf(all);
    CHECK(ground.height == Approx(-4).margin(1e-2));
    standOn(ground, all);
    for (const DVec3 &p : {DVec3(-1, -1, 1), DVec3(5, 1, -4), DVec3(5, -1, -4), DVec3(-1, 1, 1)}) {
        CHECK(std::fabs(seenAt(all, p).x) < 0.75);
        CHECK(std::fabs(seenAt(all, p).y) < 0.75);
    }
    // Of very many frames some are looked at, the last among them.
    CHECK(groundOf(bare(folder + "/box.obj", {"mesh.0.translate=[[1,[0,0,0]],[1000,[0,0,-3]]]", "render.frames=\"1-1000\""}))->height ==
          Approx(-4).margin(1e-2));
    // A subdivided cube is smaller than its cage: the ground is below its surface.
    const double smooth = groundOf(bare(folder + "/box.obj", {"mesh.0.subdivision=3"}))->height;
    CHECK(smooth > -0.9);
    CHECK(smooth < -0.75);
}

TEST_CASE("ground: what the file or the command line says stays", "[ground]") {
    const std::string folder = freshFolder("own");
    for (const bool camera : {false, true})
        for (const bool lamp : {false, true}) {
            CAPTURE(camera, lamp);
            writeBytes(folder + "/own.gltf", ownStage(camera, lamp));
            Scene scene = bare(folder + "/own.gltf");
            const Scene before = scene;
            const std::optional<Ground> ground = groundOf(scene);
            REQUIRE(ground);
            CHECK(ground->height == Approx(0).margin(1e-3)); // y up: the lowest y of the file
            standOn(*ground, scene);
            CHECK(scene.camera.rig.has_value() == camera);
            if (camera) CHECK(cameraAtFrame(scene.camera, 1, 24).worldFromCamera == cameraAtFrame(before.camera, 1, 24).worldFromCamera);
            CHECK(scene.lights.size() == (lamp ? 1 : 0));
            CHECK(scene.environment.has_value() == !lamp);
        }
    writeBytes(folder + "/box.obj", boxObj(DVec3(-1), DVec3(1)));
    Scene lit = bare(folder + "/box.obj", {"environment.radiance=[1,0,0]", "camera.position=[0,-9,1]"});
    standOn(*groundOf(lit), lit);
    CHECK(lit.environment->constant);
    CHECK(DVec3(cameraAtFrame(lit.camera, 1, 24).worldFromCamera[3]) == DVec3(0, -9, 1));
    writeBytes(folder + "/scene.toml", "[[mesh]]\nfile = \"box.obj\"\n");
    CHECK(!groundOf(bare(folder + "/scene.toml")));
}

TEST_CASE("ground: --no-ground is the picture of a scene file with that mesh", "[ground][cli]") {
    const std::string folder = freshFolder("without");
    writeBytes(folder + "/box.obj", boxObj(DVec3(-1), DVec3(1)));
    writeBytes(folder + "/scene.toml", "[[mesh]]\nfile = \"box.obj\"\n");
    const Image without = rendered(folder, "box.obj", {"--no-ground"});
    CHECK(without.values == rendered(folder, "scene.toml", {}).values);
    CHECK(without.values != rendered(folder, "box.obj", {}).values);
    const CommandResult info = runTaut({"info", "box.obj"}, folder);
    requireSuccess(info);
    CHECK(info.out.find("stands it on a ground at z = -1.00") != std::string::npos);
    const CommandResult json = runTaut({"info", "box.obj", "--json"}, folder);
    CHECK(nlohmann::json::parse(json.out)["objects"].size() == 1);
    CHECK(nlohmann::json::parse(json.out)["ground"]["height"].get<double>() == Approx(-1).margin(1e-2));
    CHECK(runTaut({"info", "scene.toml"}, folder).out.find("ground") == std::string::npos);
    requireSuccess(runTaut({"export", "box.obj", "-q", "-o", "box.usda"}, folder));
    const std::string exported = readBytes(folder + "/box.usda");
    CHECK(exported.find("box") != std::string::npos);
    CHECK(exported.find("ground") == std::string::npos);
}

TEST_CASE("ground: a shadow, no edge, and the same picture at every scale", "[ground][cli]") {
    const std::string folder = freshFolder("picture");
    writeBytes(folder + "/box.obj", boxObj(DVec3(-1), DVec3(1)));
    const Image image = rendered(folder, "box.obj", {}, 64);
    /// Mean of a block of pixels.
    const auto block = [&](int x0, int y0, int x1, int y1) {
        double sum = 0;
        for (int y = y0; y < y1; ++y)
            for (int x = x0; x < x1; ++x) sum += valueAt(image, x, y, "G");
        return sum / (x1 - x0) / (y1 - y0);
    };
    // From the backdrop above down to the open ground at the left, row by row: no step.
    for (int y = 0; y + 1 < 36; ++y) CHECK(block(0, y + 1, 12, y + 2) == Approx(block(0, y, 12, y + 1)).epsilon(0.15));
    double darkest = 1;
    for (int y = 18; y < 34; ++y)
        for (int x = 38; x < 60; ++x) darkest = std::min(darkest, block(x, y, x + 2, y + 2));
    CHECK(darkest < 0.5 * block(2, 22, 12, 34));
    for (const char *scale : {"1e-5", "1e3", "1e12"}) {
        CAPTURE(scale);
        const Image other = rendered(folder, "box.obj", {"-D", std::string("mesh.0.scale=") + scale}, 64);
        double difference = 0, sum = 0;
        for (std::size_t i = 1; i < image.values.size(); i += 4) {
            difference += std::fabs(static_cast<double>(image.values[i] - other.values[i]));
            sum += static_cast<double>(image.values[i]);
        }
        CHECK(difference < 0.03 * sum);
    }
}

TEST_CASE("ground: what is flat lies on it and not in it; from below it is not there", "[ground][cli]") {
    const std::string folder = freshFolder("flat");
    writeBytes(folder + "/plate.obj", "v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nf 1 2 3 4\n");
    const Arguments red{"--aov", "albedo", "-D", "material.red.color=[0.8,0,0]", "-D", "mesh.0.material=red"};
    const Image image = rendered(folder, "plate.obj", red);
    int plate = 0;
    for (int y = 0; y < 36; ++y)
        for (int x = 0; x < 64; ++x)
            if (const double r = valueAt(image, x, y, "Albedo.R"), g = valueAt(image, x, y, "Albedo.G"); r > 0 && g < 1e-6) {
                CHECK(r == Approx(0.8));
                ++plate;
            }
    CHECK(plate > 200); // pixels that see nothing but the plate
    Arguments below = red;
    below.insert(below.end(), {"-D", "camera.position=[0,-3,-2]", "-D", "camera.look_at=[0,0,0]", "-D", "environment.radiance=1", "-D",
                               "environment.camera_visible=false"});
    const Image under = rendered(folder, "plate.obj", below);
    CHECK(meanOf(under, "A") < 0.6);
    CHECK(valueAt(under, 32, 18, "A") == 1);
    CHECK(valueAt(under, 32, 18, "Albedo.R") == Approx(0.8));
}
