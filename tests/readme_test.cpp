/// What the README and docs/command.md promise, run: the scene is saved, the commands are executed.

#include "assets.h"
#include "catch.h"

#include <cstdlib>
#include <fstream>
#include <sstream>

namespace fs = std::filesystem;

namespace {

std::string readAll(const fs::path &path) {
    std::ifstream file(path, std::ios::binary);
    std::stringstream text;
    text << file.rdbuf();
    return text.str();
}

/// The contents of every fenced block in one language.
std::vector<std::string> blocks(const std::string &text, const std::string &language) {
    std::vector<std::string> found;
    const std::string fence = "```" + language + "\n";
    for (std::size_t at = text.find(fence); at != std::string::npos; at = text.find(fence, at)) {
        at += fence.size();
        const std::size_t end = text.find("```", at);
        found.push_back(text.substr(at, end - at));
        at = end + 3;
    }
    return found;
}

} // namespace

TEST_CASE("The README's scene and the documented commands run as they are printed", "[readme]") {
    const fs::path source = TAUT_SOURCE_DIR;
    const fs::path folder = taut::test::outputFolder("readme");
    fs::remove_all(folder);
    fs::create_directories(folder / "build/release");
    fs::create_symlink(source / "meshes", folder / "meshes");
    fs::create_symlink(TAUT_COMMAND, folder / "build/release/taut");
    const std::string readme = readAll(source / "README.md");
    const auto scenes = blocks(readme, "toml");
    REQUIRE(scenes.size() == 1);
    std::ofstream(folder / "first.toml") << scenes[0];
    int commands = 0;
    for (const std::string &block : blocks(readme + readAll(source / "docs/command.md"), "sh")) {
        std::istringstream lines(block);
        for (std::string line; std::getline(lines, line);) {
            if (line.empty()) continue;
            INFO(line);
            REQUIRE(line.rfind("build/release/taut ", 0) == 0);
            CHECK(std::system(("cd '" + folder.string() + "' && " + line + " > /dev/null 2> errors.txt").c_str()) == 0);
            CHECK(readAll(folder / "errors.txt").find("taut: error") == std::string::npos);
            ++commands;
        }
    }
    CHECK(commands >= 14);
    for (const char *file : {"out/first.0001.png", "out/first.0024.png", "out/fixed.png", "out/first.exr", "out/body.png"})
        CHECK(fs::exists(folder / file));
}
