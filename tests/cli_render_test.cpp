/// `taut render` from the outside: the images, their channels and metadata, and that they are whole or not touched.

#include "assets.h"
#include "cli_fixtures.h"
#include "mesh_samples.h"

#include "taut/base/srgb.h"

#include <nlohmann/json.hpp>

using namespace taut;
using namespace taut::test;

TEST_CASE("cli: a render with everything asked for", "[cli]") {
    const Workplace place("render");
    const CommandResult result = runTaut({"render",     place.scene,
                                          "-o",         place.path("new/a.exr"),
                                          "-o",         place.path("a.png"),
                                          "--crop",     "4,2,20,14",
                                          "--spp",      "3",
                                          "--seed",     "7",
                                          "-t",         "2",
                                          "-D",         "render.width=32",
                                          "-D",         "render.height=20",
                                          "--frames",   "3",
                                          "--aov",      "all",
                                          "--stats",    place.path("stats.json"),
                                          "--progress", "json"});
    requireSuccess(result);
    CHECK(result.out.empty());
    CHECK(namesIn(place.folder) == std::vector<std::string>{"a.png", "new", "plate.toml", "stats.json"});
    CHECK(namesIn(place.path("new")) == std::vector<std::string>{"a.exr"});

    const Image exr = readImage(place.path("new/a.exr"));
    CHECK(exr.width == 32);
    CHECK(exr.height == 20);
    CHECK(exr.window.x0 == 4);
    CHECK(exr.window.y0 == 2);
    CHECK(exr.window.x1 == 20);
    CHECK(exr.window.y1 == 14);
    const std::vector<std::string> expected{"R",   "G",      "B",      "A",         "Z",         "Albedo.R", "Albedo.G", "Albedo.B", "N.X",
                                            "N.Y", "N.Z",    "Ns.X",   "Ns.Y",      "Ns.Z",      "Nf.X",     "Nf.Y",     "Nf.Z",     "P.X",
                                            "P.Y", "P.Z",    "Pref.X", "Pref.Y",    "Pref.Z",    "u",        "v",        "M.X",      "M.Y",
                                            "M.Z", "Lean.X", "Lean.Y", "Stretch.X", "Stretch.Y", "Alpha.X",  "Alpha.Y",  "Alpha.Z"};
    CHECK(exr.channels.size() == expected.size());
    for (const std::string &name : expected) CHECK(std::count(exr.channels.begin(), exr.channels.end(), name) == 1);

    const Image png = readImage(place.path("a.png"));
    CHECK(png.channels.size() == 3);
    CHECK(png.window.width() == 16);
    CHECK(png.window.height() == 12);
    for (int y = 0; y < 12; ++y)
        for (int x = 0; x < 16; ++x)
            for (const char *c : {"R", "G", "B"})
                CHECK(std::fabs(valueAt(png, x, y, c) - static_cast<double>(srgbFromLinear(static_cast<float>(valueAt(exr, x, y, c))))) <
                      0.51 / 255);

    for (const std::string &path : {place.path("new/a.exr"), place.path("a.png")}) {
        INFO(path);
        CHECK(metadata(path, "taut:spp") == "3");
        CHECK(metadata(path, "taut:seed") == "7");
        CHECK(metadata(path, "taut:frame") == "3");
        CHECK(metadata(path, "taut:sampleRange") == "0-2");
        CHECK("taut " + metadata(path, "taut:version") + "\n" == runTaut({"--version"}).out);
        CHECK(metadata(path, "taut:sceneHash").size() == 32);
        CHECK(metadata(path, "DateTime") == "absent"); // the same picture is the same file
    }

    const auto stats = nlohmann::json::parse(readBytes(place.path("stats.json")));
    REQUIRE(stats["frames"].size() == 1);
    CHECK(stats["frames"][0]["frame"] == 3);
    CHECK(stats["frames"][0]["spp"] == 3);
    CHECK(stats["frames"][0]["counts"]["paths"] == 16 * 12 * 3);
    CHECK(stats["frames"][0]["counts"]["camera_rays"] == 16 * 12 * 3);
    CHECK(stats["frames"][0]["counts"]["not_finite"] == 0);
    for (const char *stage :
         {"deformation_s", "gradient_s", "bvh_s", "camera_rays_s", "scattered_rays_s", "shadow_rays_s", "shading_s", "film_s"})
        CHECK(stats["frames"][0]["times"][stage].get<double>() >= 0);
    CHECK(stats["peak_mb"].get<double>() > 1);

    std::size_t frameEvents = 0;
    for (const std::string &line : linesOf(result.err)) {
        const auto event = nlohmann::json::parse(line);
        if (event["event"] != "frame") continue;
        ++frameEvents;
        CHECK(event["frame"] == 3);
        CHECK(event["output"] == place.path("new/a.exr"));
    }
    CHECK(frameEvents == 1);
}

TEST_CASE("cli: the gloss of the sheared plate in the image is the closed form", "[cli]") {
    const Workplace place("closed_form");
    requireSuccess(runTaut(
        {"render", place.scene, "-o", place.path("a.exr"), "--frames", "3", "--aov", "m,stretch", "--aov", "alpha,depth,uv", "-q"}));
    const Image image = readImage(place.path("a.exr"));
    int inside = 0;
    for (int y = 0; y < 16; ++y)
        for (int x = 0; x < 24; ++x) {
            if (valueAt(image, x, y, "A") < 1) continue; // the edge of the plate
            ++inside;
            // M = R [[1, 1.2], [0, 1]] diag(10, 2.5): its determinant and norm, free of the rotation R of the frame.
            const double a = valueAt(image, x, y, "M.X");
            const double b = valueAt(image, x, y, "M.Y");
            const double d = valueAt(image, x, y, "M.Z");
            CHECK(a * d == Approx(25).epsilon(1e-3));
            CHECK(a * a + b * b + d * d == Approx(100 + 9 + 6.25).epsilon(1e-3));
            // Singular values of a simple shear k: (sqrt(k^2 + 4) +- k) / 2.
            CHECK(valueAt(image, x, y, "Stretch.X") == Approx((std::hypot(kShear, 2) + kShear) / 2).epsilon(1e-3));
            CHECK(valueAt(image, x, y, "Stretch.Y") == Approx((std::hypot(kShear, 2) - kShear) / 2).epsilon(1e-3));
            CHECK(valueAt(image, x, y, "Alpha.X") * valueAt(image, x, y, "Alpha.Y") == Approx(1 / 25.0).epsilon(1e-3));
        }
    CHECK(inside > 20);
}

TEST_CASE("cli: the same bits for any number of threads and for the same seed", "[cli]") {
    const Workplace place("bits");
    const std::vector<float> one = renderedValues(place, "one.exr", {"-t", "1", "--frames", "2", "--aov", "all"});
    CHECK(one == renderedValues(place, "two.exr", {"-t", "2", "--frames", "2", "--aov", "all"}));
    CHECK(one == renderedValues(place, "three.exr", {"-t", "3", "--frames", "2", "--aov", "all"}));
    const std::vector<float> seed5 = renderedValues(place, "seed5.exr", {"--seed", "5"});
    CHECK(seed5 == renderedValues(place, "seed5_again.exr", {"--seed", "5"}));
    CHECK(seed5 == renderedValues(place, "seed5_in_scene.exr", {"-D", "render.seed=5"}));
    CHECK(seed5 != renderedValues(place, "seed6.exr", {"--seed", "6"}));

    // A crop holds the pixels of the whole image.
    const Image whole = readImage(place.path("seed5.exr"));
    renderedValues(place, "crop.exr", {"--seed", "5", "--crop", "5,3,21,11"});
    const Image crop = readImage(place.path("crop.exr"));
    for (int y = 0; y < 8; ++y)
        for (int x = 0; x < 16; ++x) CHECK(valueAt(crop, x, y, "G") == valueAt(whole, x + 5, y + 3, "G"));

    CHECK(metadata(place.path("seed5.exr"), "taut:sceneHash") == metadata(place.path("seed6.exr"), "taut:sceneHash"));
    CHECK(metadata(place.path("seed5.exr"), "taut:sceneHash") != metadata(place.path("seed5_in_scene.exr"), "taut:sceneHash"));
}

TEST_CASE("cli: --time ends a frame early and records the samples it got", "[cli]") {
    const Workplace place("time");
    requireSuccess(runTaut({"render", place.scene, "--time", "1s", "--spp", "16777216", "-q", "-o", place.path("a.exr"), "--stats",
                            place.path("stats.json")}));
    const int spp = std::stoi(metadata(place.path("a.exr"), "taut:spp"));
    CHECK(spp >= 1);
    CHECK(spp < 16777216);
    const auto stats = nlohmann::json::parse(readBytes(place.path("stats.json")));
    CHECK(stats["frames"][0]["spp"] == spp);
    CHECK(stats["frames"][0]["counts"]["paths"] == 24 * 16 * static_cast<std::int64_t>(spp));
    CHECK(metadata(place.path("a.exr"), "taut:sampleRange") == "0-" + std::to_string(spp - 1));
    // The samples that did fit are the same as without a limit.
    renderedValues(place, "b.exr", {"--spp", "6"});
    requireSuccess(runTaut({"render", place.scene, "--time", "1h", "--spp", "6", "-q", "-o", place.path("c.exr")}));
    CHECK(readImage(place.path("b.exr")).values == readImage(place.path("c.exr")).values);
}

TEST_CASE("cli: a bare OBJ, PLY or GLB is framed and lit", "[cli]") {
    const std::string folder = freshFolder("cli_bare");
    writeBytes(folder + "/tetrahedron.obj", "v 0 0 0\nv 100 0 0\nv 0 100 0\nv 0 0 100\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n");
    writeBytes(folder + "/square.ply", plyAsciiSample());
    GltfBuilder glb;
    const int positions = glb.addFloats("VEC3", {0, 0, 0, 1e-3F, 0, 0, 1e-3F, 2e-3F, 0, 0, 2e-3F, 0});
    const int indices = glb.add<std::uint16_t>("SCALAR", 5123, {0, 1, 2, 0, 2, 3});
    glb.json["meshes"] = {{{"primitives", {{{"attributes", {{"POSITION", positions}}}, {"indices", indices}}}}}};
    glb.json["nodes"] = {{{"mesh", 0}, {"translation", {5, 0, 0}}}};
    glb.json["scenes"] = {{{"nodes", {0}}}};
    writeBytes(folder + "/tiny.glb", glb.glb());
    writeBytes(folder + "/tiny.gltf", glb.gltf());

    std::vector<std::string> files{folder + "/tetrahedron.obj", folder + "/square.ply", folder + "/tiny.glb", folder + "/tiny.gltf",
                                   TAUT_SOURCE_DIR "/meshes/ring.obj"};
    for (const char *name : {"static/spot_control_mesh.obj", "static/suzi.glb", "anim/khronos/Fox.glb", "anim/khronos/CesiumMan.glb",
                             "anim/khronos/AnimatedMorphSphere.glb", "anim/kaykit/Knight.glb"})
        if (const auto path = asset(name)) files.push_back(*path);
    for (const std::string &file : files) {
        INFO(file);
        requireSuccess(runTaut({"render", file, "--no-ground", "-o", folder + "/a.exr", "-D", "render.width=64", "-D", "render.height=48",
                                "-D", "environment.camera_visible=false", "-D", "render.filter=box", "--spp", "4"}));
        const Image image = readImage(folder + "/a.exr");
        CHECK(image.width == 64);
        const double covered = meanOf(image, "A");
        CHECK(covered > 0.02);
        CHECK(covered < 0.8);
        CHECK(meanOf(image, "G") > 0.01 * covered); // the built-in studio is there
        double border = 0;                          // and nothing is cut off: the box filter sees no further than the pixel
        for (int x = 0; x < 64; ++x) border += valueAt(image, x, 0, "A") + valueAt(image, x, 47, "A");
        for (int y = 0; y < 48; ++y) border += valueAt(image, 0, y, "A") + valueAt(image, 63, y, "A");
        CHECK(border == 0);
    }
}

TEST_CASE("cli: an output file is replaced whole or not at all", "[cli]") {
    const Workplace place("output");
    const std::string output = place.path("a.exr");
    writeBytes(output, "what was there before");
    const auto untouched = [&] { return readBytes(output) == "what was there before"; };
    const std::vector<std::string> before = namesIn(place.folder);

    checkUsageError(runTaut({"render", place.scene, "-o", output, "-D", "material.brushed.alpha=-1"}), "material.brushed.alpha=-1");
    checkUsageError(runTaut({"render", place.scene, "-o", output, "-D", "mesh.0.file=gone.obj"}), "gone.obj");
    CHECK(untouched());
    // A second output that can't be is found out before the first is written.
    checkUsageError(runTaut({"render", place.scene, "-o", output, "-o", place.path("b.tiff")}), "b.tiff");
    CHECK(untouched());
    // Interrupted in the middle of a frame.
    CHECK(runTaut({"render", place.scene, "-o", output, "--spp", "16777216", "-q"}, "", 1).exitCode == kTimedOut);
    CHECK(untouched());
    fs::remove(output + ".checkpoint"); // what there was of it
    CHECK(namesIn(place.folder) == before);

    // What can't be written is a failure while running: exit code 1, one line, nothing left behind.
    for (const std::string &bad : {output + "/below_a_file.exr", place.path("folder.exr")}) {
        fs::create_directories(place.path("folder.exr"));
        const CommandResult result = runTaut({"render", place.scene, "-o", bad, "--spp", "1", "-q"});
        CHECK(result.exitCode == 1);
        CHECK(errorLine(result).find(bad) != std::string::npos);
    }
    CHECK(untouched());
    CHECK(namesIn(place.folder) == std::vector<std::string>{"a.exr", "folder.exr", "plate.toml"});
    CHECK(namesIn(place.path("folder.exr")).empty());

    requireSuccess(runTaut({"render", place.scene, "-o", output, "--spp", "1", "-q"}));
    CHECK(readImage(output).width == 24);
    CHECK(namesIn(place.folder) == std::vector<std::string>{"a.exr", "folder.exr", "plate.toml"});
}
