// TOML written out reads back as the same tree.

#include "command.h"

#include "taut/scene/toml_text.h"

using namespace taut;
using namespace taut::test;

namespace {

bool isSame(const TomlValue &a, const TomlValue &b) {
    if (a.kind != b.kind || a.boolean != b.boolean || a.integer != b.integer || a.number != b.number || a.text != b.text ||
        a.items.size() != b.items.size() || a.entries.size() != b.entries.size())
        return false;
    for (std::size_t i = 0; i < a.items.size(); ++i)
        if (!isSame(a.items[i], b.items[i])) return false;
    for (const TomlEntry &entry : a.entries) // sections come after plain keys, so the order may be another
        if (b.find(entry.key) == nullptr || !isSame(entry.value, *b.find(entry.key))) return false;
    return true;
}

} // namespace

TEST_CASE("TOML text reads back as the same tree", "[toml]") {
    for (const std::string text : {
             "a = 1\nb = 1.0\nc = -0.1\nd = 1e300\ne = inf\nf = true\ng = \"\"\n",
             "text = \"quote \\\" back \\\\ line \\n tab \\t bell \\u0007 \xc3\xa9\"\n\"a key\" = 'x'\n",
             "[a.b]\nc = [1, 2.5, [3, [4]]]\n[a]\nx = { y = 1, z = { w = [] } }\n[[m]]\nf = 1\n[[m.d]]\ng = 2\n[[m.d]]\n[[m]]\n[m.s]\nt = 0\n",
             "k = [[1, 0.0], [14, 1]]\nempty = []\nmixed = [{ a = 1 }, { b = 2 }]\n",
         }) {
        INFO(text);
        const TomlValue tree = parseToml(text, "a");
        const std::string written = tomlText(tree);
        INFO(written);
        CHECK(isSame(tree, parseToml(written, "b")));
        CHECK(tomlText(parseToml(written, "b")) == written);
    }
}

TEST_CASE("TOML text of the demo's scenes reads back as the same tree", "[toml]") {
    const std::string folder = std::string(TAUT_SOURCE_DIR) + "/apps/demo";
    int scenes = 0;
    for (const std::string &name : namesIn(folder)) {
        if (fs::path(name).extension() != ".toml") continue;
        const TomlValue tree = readToml(folder + "/" + name);
        CHECK(isSame(tree, parseToml(tomlText(tree), name)));
        ++scenes;
    }
    CHECK(scenes >= 4);
}

TEST_CASE("TOML text of an override's table replaces what was there", "[toml]") {
    TomlValue tree = parseToml("[camera]\ngltf = \"a.glb\"\n", "a");
    applyOverride(tree, "camera={ position = [1, 2, 3] }");
    CHECK(tomlText(tree) == "camera = { position = [1, 2, 3] }\n");
    CHECK_THROWS_AS(tomlText(parseToml("a = 1979-05-27\n", "a")), InputError);
}
