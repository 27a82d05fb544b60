/// TOML texts: how deep they may go, where dots and brackets are none, ends of lines; frame sets.

#include "scene_fixtures.h"

#include "taut/base/frame_set.h"
#include "taut/scene/toml_depth.h"
#include "taut/scene/toml_value.h"

using namespace taut;
using namespace taut::test;

namespace {

std::string repeated(const std::string &text, int count) {
    std::string out;
    for (int i = 0; i < count; ++i) out += text;
    return out;
}

std::string errorOfToml(const std::string &text) {
    return errorOf([&] { parseToml(text, "a.toml"); });
}

} // namespace

TEST_CASE("TOML that nests without end is one line, whatever it nests", "[toml][malformed]") {
    constexpr int kMany = 300000;
    for (const std::string &text : {
             repeated("a.", kMany) + "a=1",
             repeated("\"=\".", kMany) + "x=1",
             repeated("'#' . ", kMany) + "x=1",
             repeated("\"\\\"\".", kMany) + "x=1",
             "[" + repeated("a.", kMany) + "a]",
             "[[" + repeated("'.'.", kMany) + "a]]",
             "a=" + repeated("[", kMany),
             "a=" + repeated("[\n", kMany) + repeated("]", kMany),
             "a=" + repeated("{a=", kMany) + "1" + repeated("}", kMany),
             "a=" + repeated("{a.b.c.d=", kMany) + "1" + repeated("}", kMany),
             "a=" + repeated("[{a=", kMany) + "1" + repeated("}]", kMany),
             "[a.b.c]\nx={" + repeated("b.", kMany) + "b=1}",
             "x={a='}',b=\"\"\"\n\"\"\"," + repeated("b.", kMany) + "b=1}",
         }) {
        INFO(text.substr(0, 60));
        CHECK(says(errorOfToml(text), "a.toml:", {"nested more than 64 deep"}));
    }
    // Each part alone is allowed, and their sum is not.
    const std::string sum = "[" + repeated("a.", 29) + "a]\n" + repeated("b.", 29) + "b={" + repeated("c.", 9) + "c=1}\n";
    CHECK(says(errorOfToml(sum), "a.toml:2:", {"nested more than 64 deep"}));
    CHECK(placeDeeperThan(sum, 71) == std::nullopt);
    CHECK(placeDeeperThan(sum, 70) != std::nullopt);
}

TEST_CASE("TOML: dots and brackets in comments, strings and numbers nest nothing", "[toml]") {
    const std::string dots = repeated("a.", 100);
    const std::string brackets = repeated("[{", 100);
    for (const std::string &text : {
             "# " + dots + brackets + "\na = 1 # " + dots + brackets + "\n",
             "a = \"" + dots + brackets + "\"\n",
             "a = '" + dots + brackets + "'\n",
             "a = \"\"\"\n" + dots + "\n" + brackets + "\"\"\"\"\nb = 1\n",
             "a = '''\n" + dots + "\n#" + brackets + "'''''\nb = 1\n",
             "\"" + dots + brackets + "\" = 1\n",
             "a = \"\\\"" + dots + "\\\\\" # \"\nb = '\\' # '" + dots + "\n",
             "a = [" + repeated("0.5, ", 100) + "]\n",
             "a = [" + repeated("{x.y.z = 0.5, w = [1.5]},\n", 100) + "]\n",
             "a = 1979-05-27T07:32:00.999\n" + repeated("b", 200) + ".c = 2.5\n",
             repeated("[a.b]\nc.d = 0.5\n", 1) + repeated("[[e.f]]\ng.h = 0.5\n", 100),
         }) {
        INFO(text.substr(0, 60));
        CHECK(errorOfToml(text).empty());
    }
}

TEST_CASE("TOML: a byte order mark and any ends of lines", "[toml]") {
    const std::string text = "[render]\nwidth = 8\nheight = 9 # nine\n";
    for (const std::string end : {"\n", "\r\n", "\r"}) {
        std::string other = "\xef\xbb\xbf";
        for (const char c : text) other += c == '\n' ? end : std::string(1, c);
        const TomlValue root = parseToml(other, "a.toml");
        REQUIRE(root.find("render") != nullptr);
        CHECK(root.find("render")->find("height")->integer == 9);
        CHECK(root.find("render")->find("height")->where.line == 3);
    }
    CHECK(says(errorOfToml("a = 1\rb = \r"), "a.toml:2:", {}));
}

TEST_CASE("The limit of frames is on all ranges together", "[frames][malformed]") {
    const Location where{"--frames"};
    const auto error = [&](const std::string &text) { return errorOf([&] { parseFrameSet(text, where); }); };
    CHECK(parseFrameSet("1-3,2-5,9-7", where) == std::vector<int>{1, 2, 3, 4, 5, 9, 8, 7});
    CHECK(parseFrameSet("1-500000,600001-1100000", where).size() == 1000000);
    CHECK(says(error("1-500000,600001-1100001"), "--frames: ", {"a million frames in all ranges together"}));
    std::string many = "0-999999";
    for (int i = 1; i < 2000; ++i) (((many += ",") += std::to_string(i)) += "000000-") += std::to_string(i) + "999999";
    CHECK(says(error(many), "--frames: ", {"million"}));
    CHECK(says(error("-2147483648-2147483647"), "--frames: ", {"million"}));
    CHECK(says(error(repeated("1,", 1000000) + "1"), "--frames: ", {"million"}));
}
