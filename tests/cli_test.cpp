/// The command from the outside: what a user types, what comes back, which files are there afterwards.

#include "assets.h"
#include "cli_fixtures.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <regex>

using namespace taut;
using namespace taut::test;

TEST_CASE("cli: --help and --version go to standard output", "[cli]") {
    for (const Arguments &arguments : {Arguments{"--help"}, Arguments{"-h"}}) {
        const CommandResult help = runTaut(arguments);
        CHECK(help.exitCode == 0);
        CHECK(help.err.empty());
        for (const char *word : {"render", "info", "--version"}) CHECK(help.out.find(word) != std::string::npos);
    }
    const CommandResult version = runTaut({"--version"});
    CHECK(version.exitCode == 0);
    CHECK(version.err.empty());
    CHECK(std::regex_match(version.out, std::regex("taut [0-9]+\\.[0-9]+\\.[0-9]+\n")));
    const CommandResult render = runTaut({"render", "--help"});
    CHECK(render.exitCode == 0);
    for (const char *option : {"--output", "--spp", "--time", "--noise", "--seed", "--fixed-seed", "--crop", "--aov", "--check", "--quiet",
                               "--progress", "--stats", "--define", "--frames", "--threads"})
        CHECK(render.out.find(option) != std::string::npos);
    CHECK(runTaut({"info", "--help"}).out.find("--json") != std::string::npos);
}

TEST_CASE("cli: bad usage is exit code 2 and one line on standard error", "[cli]") {
    const Workplace place("usage");
    const std::string &scene = place.scene;
    const std::vector<std::pair<Arguments, std::string>> cases{
        {{}, "subcommand"},
        {{"rendre"}, "rendre"},
        {{"--verbose"}, "--verbose"},
        {{"render"}, "scene"},
        {{"info"}, "scene"},
        {{"render", scene, "--sppp", "4"}, "--sppp"},
        {{"render", scene, "stray"}, "stray"},
        {{"render", scene, "--spp", "0"}, "--spp"},
        {{"render", scene, "--spp", "many"}, "--spp"},
        {{"render", scene, "--spp"}, "--spp"},
        {{"render", scene, "-t", "0"}, "--threads"},
        {{"render", scene, "--seed", "red"}, "--seed"},
        {{"render", scene, "--time", "5 parsecs"}, "5 parsecs"},
        {{"render", scene, "--time", "-1s"}, "-1s"},
        {{"render", scene, "--crop", "0,0,25,16"}, "x1 <= 24"},
        {{"render", scene, "--crop", "4,4,4,8"}, "4,4,4,8"},
        {{"render", scene, "--crop", "1,2,3"}, "1,2,3"},
        {{"render", scene, "--crop", "0,0,8,8,9"}, "0,0,8,8,9"},
        {{"render", scene, "--progress", "jsn"}, "did you mean 'json'?"},
        {{"render", scene, "--frames", "1-"}, "--frames"},
        {{"render", scene, "--frames", "one"}, "one"},
        {{"render", scene, "-o", place.path("x.jpeg")}, ".exr or .png"},
        {{"render", scene, "--frames", "1-2", "-o", place.path("x.exr")}, "####"},
        {{"render", scene, "-D", "render.width"}, "render.width"},
        {{"render", scene, "-D", "render.widht=4"}, "did you mean 'width'?"},
        {{"render", scene, "-D", "render.width=0"}, "render.width=0"},
        {{"render", scene, "-D", "mesh.7.follow=false"}, "mesh.7"},
        {{"render", scene, "--aov", "alpa"}, "did you mean 'alpha'?"},
        {{"render", scene, "--aov", "depth,normall"}, "did you mean 'normal'?"},
        {{"render", place.path("absent.toml")}, "absent.toml"},
        {{"info", place.path("absent.glb")}, "absent.glb"},
        {{"render", place.folder}, place.folder},
        {{"info", scene, "--spp", "4"}, "--spp"},
        {{"render", scene, "--two\nlines"}, "'--two\\x0alines', expected one of --help"},
    };
    for (const auto &[arguments, part] : cases) {
        INFO("taut " << (arguments.empty() ? "" : arguments.front()) << " ... " << (arguments.empty() ? "" : arguments.back()));
        checkUsageError(runTaut(arguments, place.folder), part);
    }
    CHECK(namesIn(place.folder) == std::vector<std::string>{"plate.toml"});
}

TEST_CASE("cli: --check and --quiet", "[cli]") {
    const Workplace place("check");
    const CommandResult check = runTaut(
        {"render", place.scene, "--check", "--frames", "1-3", "-o", place.path("out.###.exr"), "--stats", place.path("stats.json")});
    requireSuccess(check);
    CHECK(linesOf(check.out).size() == 1);
    CHECK(check.out.find("ok, 3 frames") != std::string::npos);
    const CommandResult quiet = runTaut({"render", place.scene, "--check", "--quiet"}, place.folder);
    requireSuccess(quiet);
    CHECK(quiet.out.empty());
    CHECK(quiet.err.empty());
    CHECK(namesIn(place.folder) == std::vector<std::string>{"plate.toml"});

    const CommandResult silent = runTaut({"render", place.scene, "-q", "-o", place.path("a.exr"), "--spp", "1"});
    requireSuccess(silent);
    CHECK(silent.out.empty());
    CHECK(silent.err.empty());
    checkUsageError(runTaut({"render", place.scene, "-q", "-D", "camera.fov_deg=900"}), "camera.fov_deg=900");
}

TEST_CASE("cli: frames and file names", "[cli]") {
    const Workplace place("frames");
    const CommandResult result = runTaut(
        {"render", place.scene, "--frames", "1-3x2,12", "--spp", "1", "-o", place.path("a_##.png"), "-o", place.path("b.%04d.exr")});
    requireSuccess(result);
    CHECK(linesOf(result.err).size() == 3); // a plain line of progress a frame
    CHECK(namesIn(place.folder) ==
          std::vector<std::string>{"a_01.png", "a_03.png", "a_12.png", "b.0001.exr", "b.0003.exr", "b.0012.exr", "plate.toml"});
    CHECK(metadata(place.path("b.0012.exr"), "taut:frame") == "12");
    // The deformation is held after its last key; the samples differ from frame to frame unless --fixed-seed.
    const std::vector<float> third = readImage(place.path("b.0003.exr")).values;
    CHECK(third != readImage(place.path("b.0001.exr")).values);
    CHECK(third != readImage(place.path("b.0012.exr")).values);
    requireSuccess(runTaut({"render", place.scene, "--frames", "3,12", "--spp", "1", "--fixed-seed", "-q", "-o", place.path("c#.exr")}));
    CHECK(readImage(place.path("c3.exr")).values == readImage(place.path("c12.exr")).values);

    requireSuccess(runTaut({"render", "plate.toml", "--spp", "1", "-q"}, place.folder));
    CHECK(namesIn(place.path("out")) == std::vector<std::string>{"0001.exr"});
}

TEST_CASE("cli: info counts what is there and bounds the stretch", "[cli]") {
    const Workplace place("info");
    const CommandResult result = runTaut({"info", place.scene, "--json", "--frames", "1-3"});
    requireSuccess(result);
    const auto info = nlohmann::json::parse(result.out);
    CHECK(info["width"] == 24);
    CHECK(info["height"] == 16);
    CHECK(info["spp"] == 4);
    CHECK(info["frames"] == 3);
    CHECK(info["first_frame"] == 1);
    CHECK(info["last_frame"] == 3);
    CHECK(info["materials"].size() == 1);
    CHECK(info["textures"] == 0);
    CHECK(info["lights"] == 1);
    CHECK(info["environment"] == true);
    REQUIRE(info["objects"].size() == 1);
    const auto &plate = info["objects"][0];
    CHECK(plate["name"] == "plate");
    CHECK(plate["positions"] == 1089);
    CHECK(plate["faces"] == 1024);
    CHECK(plate["components"] == 1);
    CHECK(plate["boundary_loops"] == 1);
    CHECK(plate["complex_edges"] == 0);
    CHECK(plate["triangles"] == 2048);
    CHECK(plate["render_vertices"] == 1089);
    CHECK(plate["rigid"] == false);
    CHECK(plate["follow"] == true);
    CHECK(plate["deformers"] == 1);
    CHECK(plate["stretch_max"].get<double>() == Approx((std::hypot(kShear, 2) + kShear) / 2).epsilon(1e-4));
    CHECK(plate["stretch_min"].get<double>() == Approx((std::hypot(kShear, 2) - kShear) / 2).epsilon(1e-4));
    CHECK(plate["shear_max"].get<double>() == Approx(kShear).epsilon(1e-4));
    CHECK(plate["collapsed_vertices"] == 0);
    CHECK(plate["folded_triangles"] == 0);

    const auto other = nlohmann::json::parse(
        runTaut({"info", place.scene, "--json", "-D", "mesh.0.file=" TAUT_SOURCE_DIR "/meshes/panel.obj", "-D", "mesh.0.subdivision=1"})
            .out);
    CHECK(other["objects"][0]["faces"] == 4 * 9216);
    CHECK(other["objects"][0]["triangles"] == 8 * 9216);
    CHECK(other["objects"][0]["stretch_max"].get<double>() == Approx(1).epsilon(1e-4));

    // Every question of the plan names its choices with error and cost.
    const auto planned = nlohmann::json::parse(runTaut({"info", place.scene, "--json", "--frames", "1-3", "-D",
                                                        "mesh.0.file=" TAUT_SOURCE_DIR "/meshes/ring.obj", "-D", "mesh.0.subdivision=auto"})
                                                   .out);
    const auto &object = planned["objects"][0];
    std::vector<std::string> names;
    for (const auto &q : object["plan"]["questions"]) {
        names.push_back(q["name"]);
        CHECK(q["choices"].size() >= 1);
        for (const auto &c : q["choices"]) CHECK((c["cost"] >= 0 && c["predicted_error"] >= 0));
    }
    for (const char *name : {"subdivision", "stretch", "bvh"}) CHECK(std::find(names.begin(), names.end(), name) != names.end());
    CHECK(object["plan"]["questions"][0]["taken"] == "level " + std::to_string(object["subdivision"].get<int>()));
    CHECK(planned["materials"][0]["question"]["choices"].size() == 3);
    checkUsageError(runTaut({"info", place.scene, "-D", "mesh.0.subdivision=aut"}), "auto");

    const CommandResult text = runTaut({"info", place.scene});
    requireSuccess(text);
    for (const char *part : {"24 x 16", "1 materials", "2048 triangles", "1 components, 1 boundary loops, 0 edges of more than two faces",
                             "multiscatter: ", "next cheaper"})
        CHECK(text.out.find(part) != std::string::npos);
    checkUsageError(runTaut({"info", place.scene, "--jsn"}), "--jsn");

    if (const auto fox = asset("anim/khronos/Fox.glb")) {
        const auto scene = nlohmann::json::parse(runTaut({"info", *fox, "--json"}).out);
        REQUIRE(scene["objects"].size() == 1);
        CHECK(scene["objects"][0]["positions"] == 1728);
        CHECK(scene["objects"][0]["triangles"] == 576);
        CHECK(scene["objects"][0]["skinned"] == true);
        CHECK(scene["textures"] == 1);
    }
}
