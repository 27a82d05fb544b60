/// What Blender makes of an export: its importers and the add-on read it, and Cycles shows the gloss that Taut renders.

#include "assets.h"
#include "command.h"

#include <map>

using namespace taut::test;

namespace {

bool hasBlender() {
    const bool found = runProgram({"blender", "--version"}, 60).exitCode == 0;
    if (!found) std::cout << "SKIPPED: there is no Blender on this machine" << std::endl;
    return found;
}

struct Error {
    double raw, filtered;
};

/// What apps/blender/compare.sh prints, by name of the image.
std::map<std::string, Error> compare(const std::string &scene, const std::string &frame, const std::string &folder, Arguments more = {}) {
    Arguments words{"sh", TAUT_SOURCE_DIR "/apps/blender/compare.sh", TAUT_COMMAND, TAUT_SOURCE_DIR "/apps/blender/" + scene, frame, folder,
                    "64"};
    words.insert(words.end(), more.begin(), more.end());
    const CommandResult result = runProgram(words, 300);
    INFO(result.out << result.err);
    REQUIRE(result.exitCode == 0);
    std::map<std::string, Error> errors;
    for (const std::string &line : linesOf(result.out)) {
        std::istringstream stream(line);
        std::string keyword;
        std::string name;
        std::string filtered;
        Error error{};
        if (stream >> keyword >> name >> error.raw >> filtered >> error.filtered && keyword == "relMSE") errors[name] = error;
    }
    REQUIRE(errors.size() == 4);
    for (const auto &[name, error] : errors)
        std::cout << scene << ": relMSE " << name << " " << error.raw << ", after a 4 x 4 box filter " << error.filtered << std::endl;
    return errors;
}

} // namespace

TEST_CASE("export: Blender's importers, its Mesh Cache and the add-on read every format", "[export][blender]") {
    if (!hasBlender()) return;
    const std::string folder = freshFolder("export_blender");
    std::string obj; // a curved grid with UVs
    for (int y = 0; y <= 4; ++y)
        for (int x = 0; x <= 4; ++x)
            obj += "v " + std::to_string(x) + " " + std::to_string(y) + " " + std::to_string(0.1 * x * y) + "\nvt " +
                   std::to_string(x / 4.0) + " " + std::to_string(y / 4.0) + "\n";
    const auto corner = [](int i) { return std::to_string(i) + "/" + std::to_string(i) + " "; };
    for (int y = 0; y < 4; ++y)
        for (int x = 0; x < 4; ++x) {
            const int a = 1 + x + 5 * y;
            if (x == 0 && y % 2 == 0) obj += y == 0 ? "usemtl Lower\n" : "usemtl Upper\n";
            obj += "f " + corner(a) + corner(a + 1) + corner(a + 6) + corner(a + 5) + "\n";
        }
    writeBytes(folder + "/grid.obj", obj);
    writeBytes(folder + "/scene.toml", "[render]\nframes = \"1-3\"\n[material.Lower]\ntype = \"conductor\"\nalpha = [0.1, 0.3]\n"
                                       "[material.Upper]\ntype = \"conductor\"\nalpha = [0.2, 0.2]\n[[mesh]]\nfile = \"grid.obj\"\n"
                                       "material = { Lower = \"Lower\", Upper = \"Upper\" }\n[[mesh.deform]]\ntype = \"shear\"\n"
                                       "plane = \"xy\"\namount = [[1, 0], [3, 0.9]]\n");
    const auto run = [&](Arguments arguments) {
        arguments.insert(arguments.begin(), {"export", "scene.toml", "-q", "--convention", "blender_anisotropic"});
        REQUIRE(runTaut(arguments, folder).exitCode == 0);
    };
    run({"-o", "m.####.npz", "-o", "m.####.ply", "-o", "m.pc2", "-o", "m.mdd"});
    run({"--frames", "3", "-o", "b.ply", "-o", "m.glb"});
    run({"--frames", "3", "-o", "t.ply", "--ascii"});
    const CommandResult result =
        runProgram({"blender", "-b", "-noaudio", "--factory-startup", "--python-exit-code", "1", "--python",
                    TAUT_SOURCE_DIR "/tests/blender/read_export.py", "--", folder, TAUT_SOURCE_DIR "/apps/blender"},
                   120);
    INFO(result.out << result.err);
    CHECK(result.exitCode == 0);
    CHECK(result.out.find("READ EVERYTHING") != std::string::npos);
}

TEST_CASE("export: Cycles shows the gloss of a sheared panel as Taut renders it", "[export][blender][cycles]") {
    if (!hasBlender()) return;
    const auto errors = compare("panel.toml", "24", freshFolder("export_cycles_panel"));
    // Two pictures differ by the noise of each; measured at 64 samples, filtered: fixed 0.0070.
    const double noise = 0.5 * (errors.at("taut_other_seed").filtered + errors.at("cycles_two_seeds").filtered);
    CHECK(errors.at("cycles_follow").filtered < 1.5 * noise);
    CHECK(errors.at("cycles_follow").filtered < 0.2 * errors.at("cycles_fixed").filtered);
}

TEST_CASE("export: Cycles shows the gloss of a skinned character as Taut renders it", "[export][blender][cycles]") {
    const auto file = asset("anim/khronos/CesiumMan.glb");
    if (!file || !hasBlender()) return;
    const auto errors = compare("character.toml", "24", freshFolder("export_cycles_character"), {"-D", "mesh.0.file=" + *file});
    CHECK(errors.at("cycles_follow").filtered < 0.2 * errors.at("cycles_fixed").filtered);
}
