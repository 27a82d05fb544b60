#include "scene_fixtures.h"

using namespace taut;
using namespace taut::test;

namespace {

std::vector<std::string> tomlBlocks(const std::string &markdown) {
    std::vector<std::string> blocks;
    const std::string open = "```toml\n";
    for (std::size_t at = markdown.find(open); at != std::string::npos; at = markdown.find(open, at)) {
        at += open.size();
        blocks.push_back(markdown.substr(at, markdown.find("```", at) - at));
    }
    return blocks;
}

/// The keys a table may have, as the loader lists them when it meets another.
std::vector<std::string> validKeys(const std::string &folder, const std::string &toml) {
    const std::string line = errorOfText(folder, toml);
    const std::size_t begin = line.find("one of ") + 7;
    const std::size_t end = line.find(';', begin);
    REQUIRE(end != std::string::npos);
    std::vector<std::string> keys;
    std::string list = line.substr(begin, end - begin) + ", ";
    for (std::size_t comma; (comma = list.find(", ")) != std::string::npos; list.erase(0, comma + 2)) keys.push_back(list.substr(0, comma));
    return keys;
}

} // namespace

TEST_CASE("the scene manual's examples load", "[scene][docs]") {
    const std::string folder = sceneFolder("scene_docs");
    const std::vector<std::string> blocks = tomlBlocks(readBytes(TAUT_SOURCE_DIR "/docs/scene.md"));
    CHECK(blocks.size() >= 7);
    for (const std::string &block : blocks) {
        INFO(block);
        CHECK(errorOfText(folder, block) == "");
    }
}

TEST_CASE("the scene manual has a line for every key", "[scene][docs]") {
    const std::string folder = sceneFolder("scene_docs");
    const std::string manual = readBytes(TAUT_SOURCE_DIR "/docs/scene.md");
    struct Section {
        const char *heading;
        const char *toml;
    };
    const Section sections[] = {
        {"## [render]", "[render]\nzzz = 1\n"},
        {"## [image]", "[image]\nzzz = 1\n"},
        {"## [camera]", "[camera]\nzzz = 1\n"},
        {"## [environment]", "[environment]\nzzz = 1\n"},
        {"## [[light]]", "[[light]]\nzzz = 1\n"},
        {"## [material.NAME]", "[material.a]\nzzz = 1\n"},
        {"### Textures", "[material.a]\ncolor = { zzz = 1 }\n"},
        {"## [[mesh]]", "[[mesh]]\nzzz = 1\n"},
        {"## [[mesh.deform]]", "[[mesh]]\nfile = \"panel.obj\"\n[[mesh.deform]]\nzzz = 1\n"},
    };
    for (const Section &section : sections) {
        const std::size_t begin = manual.find(std::string(section.heading) + "\n");
        REQUIRE(begin != std::string::npos);
        const std::string chapter = manual.substr(begin, manual.find("\n## ", begin + 1) - begin);
        const std::vector<std::string> keys = validKeys(folder, section.toml);
        CHECK(keys.size() >= 5);
        for (const std::string &key : keys) {
            INFO(section.heading << " " << key);
            CHECK(chapter.find("`" + key + "`") != std::string::npos);
        }
    }
}
