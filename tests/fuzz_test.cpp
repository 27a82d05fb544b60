/// The harnesses over their seeds, over small changes of them, and over what fuzzing found.

#include "assets.h"

#include "fuzz/mutate.h"
#include "taut/base/file_bytes.h"
#include "taut/scene/png_guard.h"

#include "catch.h"
#include <nlohmann/json.hpp>

#include <filesystem>

using namespace taut;
using namespace taut::fuzz;

namespace fs = std::filesystem;

namespace {

/// As libFuzzer would, but by a few bytes alone.
std::string withOtherBytes(const std::string &bytes, Dice &dice) {
    std::string out = bytes;
    for (std::size_t i = 1 + dice.below(4); i > 0 && !out.empty(); --i) out[dice.below(out.size())] = static_cast<char>(dice.below(256));
    return out;
}

} // namespace

TEST_CASE("Every harness takes its seeds, their begins and changes of them", "[fuzz]") {
    for (const Harness &harness : harnesses()) {
        INFO(harness.name);
        Dice dice(1);
        const std::vector<std::string> seeds = harness.seeds();
        REQUIRE(!seeds.empty());
        CHECK_NOTHROW(harness.run({}));
        for (const std::string &seed : seeds) {
            CHECK_NOTHROW(harness.run(seed));
            for (int i = 0; i < 4; ++i) {
                CHECK_NOTHROW(harness.run(seed.substr(0, dice.below(seed.size()))));
                CHECK_NOTHROW(harness.run(withOtherBytes(seed, dice)));
                const auto change = [&](const std::string &bytes) { return withOtherBytes(bytes, dice); };
                CHECK_NOTHROW(harness.run(mutated(harness.grammar, seed, dice, change)));
            }
        }
    }
}

TEST_CASE("What fuzzing found stays mended", "[fuzz]") {
    const fs::path folder = fs::path(TAUT_SOURCE_DIR) / "tests/fuzz/regressions";
    std::size_t count = 0;
    for (const auto &entry : fs::recursive_directory_iterator(folder)) {
        if (!entry.is_regular_file() || entry.path().parent_path() == folder) continue;
        INFO(entry.path().string());
        CHECK_NOTHROW(harnessNamed(entry.path().parent_path().filename().string()).run(readFileBytes(entry.path().string())));
        ++count;
    }
    CHECK(count > 0);
}

TEST_CASE("Changes keep to their grammar", "[fuzz]") {
    Dice dice(7);
    const auto change = [&](const std::string &bytes) { return withOtherBytes(bytes, dice); };
    std::string json = harnessNamed("gltf").seeds().front();
    std::string glb = harnessNamed("glb").seeds().front();
    std::string png = harnessNamed("png").seeds().front();
    for (int i = 0; i < 100; ++i) {
        json = mutated(Grammar::Json, json, dice, change);
        REQUIRE(nlohmann::json::accept(json));
        glb = mutated(Grammar::Glb, glb, dice, change);
        REQUIRE(glb.compare(0, 4, "glTF") == 0);
        REQUIRE(glb.size() % 4 == 0);
        png = mutated(Grammar::Png, harnessNamed("png").seeds().front(), dice, change);
        const std::string damage = damageOfPng(png); // order and kinds of chunks may be wrong, checksums never
        REQUIRE(damage.find("checksum") == std::string::npos);
        REQUIRE(damage.find("CRC") == std::string::npos);
    }
    const std::string toml = harnessNamed("scene").seeds().front();
    CHECK(mutated(Grammar::Toml, toml, dice, change) != toml);
    CHECK(mutated(Grammar::Json, "{", dice, change).empty());
}
