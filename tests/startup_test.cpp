/// What a program loads before it does anything: no image library, until an image is read or written.

#include "cli_fixtures.h"

using namespace taut::test;

namespace {

/// Whether the command opens OpenImageIO's library, as the loader says.
bool loadsImageLibrary(const Arguments &arguments) {
    Arguments words{"/usr/bin/env", "LD_DEBUG=files", TAUT_COMMAND};
    words.insert(words.end(), arguments.begin(), arguments.end());
    const CommandResult result = runProgram(words, 120);
    INFO(result.out);
    REQUIRE(result.exitCode == 0);
    REQUIRE(result.err.find("libembree") != std::string::npos); // the loader did speak
    return result.err.find("libOpenImageIO") != std::string::npos;
}

} // namespace

TEST_CASE("The image library is loaded by what reads or writes an image, and by nothing else", "[startup][cli]") {
    const Workplace place("startup");
    CHECK_FALSE(loadsImageLibrary({"--version"}));
    CHECK_FALSE(loadsImageLibrary({"info", place.scene}));
    CHECK_FALSE(loadsImageLibrary({"render", place.scene, "--check"}));
    CHECK_FALSE(loadsImageLibrary({"export", place.scene, "-o", place.path("a.npz")}));
    CHECK(loadsImageLibrary({"render", place.scene, "--spp", "1", "-o", place.path("a.png")}));
}

TEST_CASE("A program without the module of image files says where it looked", "[startup][cli]") {
    const Workplace place("startup_alone");
    const std::string alone = place.path("taut");
    fs::copy_file(TAUT_COMMAND, alone, fs::copy_options::overwrite_existing);
    CHECK(runProgram({alone, "info", place.scene}, 120).exitCode == 0);
    const CommandResult result = runProgram({alone, "render", place.scene, "--spp", "1", "-q", "-o", place.path("a.png")}, 120);
    CHECK(result.exitCode == 1);
    CHECK(errorLine(result).find("the module that reads and writes images was not found") != std::string::npos);
    CHECK_FALSE(fs::exists(place.path("a.png")));
    // Beside the program it is found.
    fs::copy_file(fs::path(TAUT_COMMAND).parent_path() / "taut_images.so", place.path("taut_images.so"),
                  fs::copy_options::overwrite_existing);
    CHECK(runProgram({alone, "render", place.scene, "--spp", "1", "-q", "-o", place.path("a.png")}, 120).exitCode == 0);
    CHECK(fs::exists(place.path("a.png")));
}
