/// The shape of the source tree: includes point one way, small headers stay small, files stay readable.

#include "command.h"

#include <array>
#include <regex>
#include <set>

using namespace taut::test;

namespace {

/// A folder may include itself and the folders before it.
constexpr std::array<std::string_view, 12> kOrder{"base",    "images", "microsurface", "mesh", "deform", "bsdf",
                                                  "formats", "scene",  "export",       "plan", "render", "pilot"};

/// What can be lifted out of the project: these folders include nothing else.
bool isLifted(std::string_view from) {
    return from == "microsurface" || from == "bsdf";
}
bool isAllowedInLifted(std::string_view from, std::string_view to) {
    return to == from || to == "base" || to == "microsurface";
}

/// Place in the order; past the end for a folder that is not in it.
std::size_t rankOf(std::string_view folder) {
    return static_cast<std::size_t>(std::find(kOrder.begin(), kOrder.end(), folder) - kOrder.begin());
}

/// The paths below taut/ that a source text includes: "mesh/mesh.h".
std::vector<std::string> includesOf(const std::string &text) {
    static const std::regex kInclude(R"re(^\s*#\s*include\s*["<]taut/([^">]+)[">])re");
    std::vector<std::string> includes;
    for (const std::string &line : linesOf(text)) {
        std::smatch match;
        if (std::regex_search(line, match, kInclude)) includes.push_back(match[1]);
    }
    return includes;
}

std::string folderOf(const std::string &path) {
    return path.substr(0, path.find('/'));
}

/// Includes of a file of the library ("mesh/mesh.h") that its folder may not have.
std::vector<std::string> forbiddenIncludes(const std::string &file, const std::string &text) {
    const std::string from = folderOf(file);
    std::vector<std::string> bad;
    for (const std::string &include : includesOf(text)) {
        const std::string to = folderOf(include);
        const bool known = rankOf(from) < kOrder.size() && rankOf(to) < kOrder.size();
        const bool allowed = isLifted(from) ? isAllowedInLifted(from, to) : rankOf(to) <= rankOf(from);
        if (!known || !allowed) bad.push_back(include);
    }
    return bad;
}

bool isSource(const fs::path &path) {
    return path.extension() == ".h" || path.extension() == ".cpp" || path.extension() == ".py";
}

/// Source files below a folder of the repository, as paths relative to that folder, sorted.
std::vector<std::string> sourcesBelow(const std::string &folder) {
    const fs::path root = fs::path(TAUT_SOURCE_DIR) / folder;
    std::vector<std::string> files;
    for (const auto &entry : fs::recursive_directory_iterator(root))
        if (entry.is_regular_file() && isSource(entry.path())) files.push_back(fs::relative(entry.path(), root).generic_string());
    std::sort(files.begin(), files.end());
    return files;
}

std::string sourceText(const std::string &file) {
    return readBytes(std::string(TAUT_SOURCE_DIR) + "/" + file);
}

} // namespace

TEST_CASE("structure: the checker of includes finds what it is for", "[structure]") {
    using Paths = std::vector<std::string>;
    CHECK(forbiddenIncludes("mesh/made_up.h", "#pragma once\n#include \"taut/scene/scene.h\"\n") == Paths{"scene/scene.h"});
    CHECK(forbiddenIncludes("base/a.cpp", "  #  include <taut/mesh/mesh.h>\n") == Paths{"mesh/mesh.h"});
    CHECK(forbiddenIncludes("bsdf/a.h", "#include \"taut/mesh/mesh.h\"\n#include \"taut/base/vec.h\"\n") == Paths{"mesh/mesh.h"});
    CHECK(forbiddenIncludes("bsdf/a.h", "#include \"taut/deform/stretch.h\"\n") == Paths{"deform/stretch.h"});
    CHECK(forbiddenIncludes("render/a.cpp", "#include \"taut/apps/a.h\"\n") == Paths{"apps/a.h"});
    CHECK(forbiddenIncludes("novel/a.h", "#include \"taut/base/vec.h\"\n") == Paths{"base/vec.h"});
    CHECK(forbiddenIncludes("microsurface/a.h", "#include \"taut/microsurface/ggx.h\"\n#include \"taut/base/vec.h\"\n#include <cmath>\n")
              .empty());
    CHECK(forbiddenIncludes("render/a.cpp", "#include \"taut/mesh/mesh.h\"\n// #include \"taut/apps/a.h\"\n").empty());
    CHECK(sourcesBelow("src/taut").size() > 40);
}

TEST_CASE("structure: no include of the library points up", "[structure]") {
    for (const std::string &file : sourcesBelow("src/taut")) {
        const std::string text = sourceText("src/taut/" + file);
        for (const std::string &include : forbiddenIncludes(file, text)) FAIL_CHECK(file << " includes " << include);
        for (const std::string &include : includesOf(text))
            if (!fs::exists(fs::path(TAUT_SOURCE_DIR) / "src/taut" / include)) FAIL_CHECK(file << ": there is no " << include);
    }
}

TEST_CASE("structure: no include of the study points up", "[structure]") {
    const std::vector<std::string> order{"chart.h", "text.h", "microsurface", "scenes", "measures", "drawing", "charts.h", "charts"};
    const auto rank = [&](const std::string &path) { return std::find(order.begin(), order.end(), folderOf(path)) - order.begin(); };
    const std::regex include(R"re(#include "study/([^"]+)")re");
    int found = 0;
    for (const std::string &file : sourcesBelow("apps/study")) {
        const std::string text = sourceText("apps/study/" + file);
        for (std::sregex_iterator it(text.begin(), text.end(), include), end; it != end; ++it, ++found)
            if (rank((*it)[1]) > rank(file)) FAIL_CHECK(file << " includes " << (*it)[1]);
    }
    CHECK(found > 100);
}

TEST_CASE("structure: the microsurface and the bsdf are headers, but for the table of metals and the loops over many hits", "[structure]") {
    std::vector<std::string> compiled;
    for (const std::string &file : sourcesBelow("src/taut"))
        if (isLifted(folderOf(file)) && fs::path(file).extension() == ".cpp") compiled.push_back(file);
    CHECK(compiled == std::vector<std::string>{"bsdf/metals.cpp"});
}

TEST_CASE("structure: no file is longer than 400 lines", "[structure]") {
    for (const std::string folder : {"src", "apps", "tests", "meshes"})
        for (const std::string &file : sourcesBelow(folder)) {
            const std::size_t lines = linesOf(sourceText(folder + "/" + file)).size();
            if (lines > 400) FAIL_CHECK(folder << "/" << file << " has " << lines << " lines");
        }
}

TEST_CASE("structure: meshes and what deforms them know no file format", "[structure]") {
    const std::regex format("gltf|tinygltf|fstream|file_bytes|\\.glb|\\.obj", std::regex::icase);
    CHECK(std::regex_search("#include <fstream>", format));
    for (const std::string folder : {"mesh", "deform", "microsurface", "bsdf"})
        for (const std::string &file : sourcesBelow("src/taut/" + folder))
            for (const std::string &line : linesOf(sourceText("src/taut/" + folder + "/" + file)))
                if (line.find("//") == std::string::npos && std::regex_search(line, format)) FAIL_CHECK(folder << '/' << file << ": " << line);
}

TEST_CASE("structure: headers that are installed need no private library, and none is of the study", "[structure]") {
    // cmake/TautPublicHeaders.cmake: roots, and what they include.
    const std::string list = sourceText("cmake/TautPublicHeaders.cmake");
    const std::regex name(R"re([a-z_]+/[a-z_/]+\.h)re");
    std::vector<std::string> waiting;
    const std::string roots = list.substr(list.find("set(TAUT_PUBLIC_ROOTS"), list.find(')') - list.find("set(TAUT_PUBLIC_ROOTS"));
    for (std::sregex_iterator it(roots.begin(), roots.end(), name), end; it != end; ++it) waiting.push_back(it->str());
    std::set<std::string> found;
    const std::regex forbidden(R"re(#\s*include\s*[<"](embree|OpenMesh|opensubdiv|OpenImageIO|toml\+\+|nlohmann|study))re");
    while (!waiting.empty()) {
        const std::string header = waiting.back();
        waiting.pop_back();
        if (!found.insert(header).second) continue;
        const std::string text = sourceText("src/taut/" + header);
        if (std::regex_search(text, forbidden)) FAIL_CHECK(header);
        for (const std::string &include : includesOf(text)) waiting.push_back(include);
    }
    CHECK(found.size() > 60);
    for (const std::string header : {"formats/gltf_source.h", "mesh/limit_rows.h", "render/embree_packets.h", "scene/load_context.h"})
        CHECK(found.count(header) == 0);
}

TEST_CASE("structure: versions of Embree and of Catch2 differ in one header each", "[structure]") {
    const std::regex theirs(R"re(#\s*include\s*[<"](embree|catch2/))re");
    CHECK(std::regex_search("#include <embree4/rtcore.h>", theirs));
    std::set<std::string> found;
    for (const std::string folder : {"src", "apps", "tests"})
        for (const std::string &file : sourcesBelow(folder))
            if (std::regex_search(sourceText(folder + "/" + file), theirs)) found.insert(folder + "/" + file);
    CHECK(found == std::set<std::string>{"src/taut/render/embree_packets.h", "tests/catch.h", "tests/structure_test.cpp"});
}

TEST_CASE("structure: every header has its guard and says what it is", "[structure]") {
    for (const std::string &file : sourcesBelow("src/taut")) {
        if (fs::path(file).extension() != ".h") continue;
        const std::vector<std::string> lines = linesOf(sourceText("src/taut/" + file));
        if (lines.size() < 2 || lines[0] != "#pragma once" || lines[1].rfind("///", 0) != 0) FAIL_CHECK(file);
    }
}

TEST_CASE("structure: no test's name reads as an option of the test program", "[structure]") {
    const std::regex option(R"re(TEST_CASE\("-)re");
    for (const std::string &file : sourcesBelow("tests")) {
        INFO(file);
        CHECK_FALSE(std::regex_search(sourceText("tests/" + file), option));
    }
}
