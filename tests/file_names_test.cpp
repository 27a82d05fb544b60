/// Names of files: where a frame's number goes, what parts of a scene are called, bytes that are no text, and that nothing half written
/// stays behind however a run ends.

#include "assets.h"
#include "cli_fixtures.h"

#include "taut/base/distinct_names.h"
#include "taut/base/frame_set.h"
#include "taut/base/utf8.h"

#include <nlohmann/json.hpp>

#include <set>
#include <thread>

using namespace taut;
using namespace taut::test;

namespace {

const std::string kLatin1 = "caf\xe9"; // no UTF-8

const std::string kQuad = "v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nf 1 2 3 4\n";

/// A scene of one quad under each of these names.
std::string sceneOf(const std::vector<std::string> &names) {
    std::string toml = "[render]\nwidth = 8\nheight = 8\nspp = 1\nmax_events = 1\nframes = \"1\"\n";
    for (const std::string &name : names) toml += "[[mesh]]\nfile = \"quad.obj\"\nname = " + nlohmann::json(name).dump() + "\n";
    return toml;
}

/// A folder with quad.obj in it.
std::string folderOf(const std::string &name) {
    const std::string folder = freshFolder("names_" + name);
    writeBytes(folder + "/quad.obj", kQuad);
    return folder;
}

const Arguments kSmall{"--spp", "1", "-D", "render.width=8", "-D", "render.height=8", "-q"};

CommandResult renderQuad(const std::string &folder, Arguments more) {
    more.insert(more.begin(), {"render", "quad.obj"});
    more.insert(more.end(), kSmall.begin(), kSmall.end());
    return runTaut(more, folder);
}

/// Names in a folder but those of its input.
std::vector<std::string> newNamesIn(const std::string &folder) {
    std::vector<std::string> names = namesIn(folder);
    names.erase(
        std::remove_if(names.begin(), names.end(), [](const std::string &name) { return name == "quad.obj" || name == "scene.toml"; }),
        names.end());
    return names;
}

} // namespace

TEST_CASE("A frame's number goes into the file's own name", "[files][frames]") {
    const std::pair<const char *, const char *> paths[] = {
        {"a.####.exr", "a.0007.exr"},          {"a#.exr", "a7.exr"},
        {"##_###.exr", "##_007.exr"},          {"a.%04d.exr", "a.0007.exr"},
        {"a.%012d.exr", "a.000000000007.exr"}, {"C#/##.exr", "C#/07.exr"},
        {"a%03d/%02d.exr", "a%03d/07.exr"},    {"a######################.exr", "a0000000000000000000007.exr"},
    };
    for (const auto &[pattern, path] : paths) {
        CHECK(hasFramePattern(pattern));
        CHECK(pathOfFrame(pattern, 7) == path);
    }
    for (const auto &[pattern, path] : paths) CHECK(frameOfPath(pattern, path) == 7);
    CHECK(frameOfPath("s#1.obj", "s21.obj") == 2); // the digits of the pattern itself are no part of the number
    CHECK(frameOfPath("1##2.obj", "1032.obj") == 3);
    CHECK(frameOfPath("a.##.obj", "a.-3.obj") == -3);
    CHECK(frameOfPath("a.##.obj", "a.-03.obj") == std::nullopt);
    for (const char *path : {"a.3.obj", "a.003.obj", "a.0x.obj", "b.03.obj", "a.03.objx", "a..obj", "a.99999999999.obj", ""})
        CHECK(frameOfPath("a.##.obj", path) == std::nullopt);
    CHECK(pathOfFrame("a.###.exr", -7) == "a.-07.exr");
    CHECK(pathOfFrame("a.##.exr", 1234) == "a.1234.exr");
    for (const char *path : {"50%done.png", "C#/img.png", "take#2/img.png", "a%04d/img.png", "100%", "%d.png", "%4d.png", "%0d.png",
                             "%099d.png", "%0-3d.png", "#/", ""}) {
        CAPTURE(path);
        CHECK_FALSE(hasFramePattern(path));
        CHECK(pathOfFrame(path, 7) == path);
    }
}

TEST_CASE("Names with percent signs and hashes are those names", "[files][cases]") {
    const std::vector<std::string> names{"50%done.png", "C#/img.png", "take#2/img.png"};
    std::string folder = folderOf("percent");
    if (const auto path = caseFile("percent-in-name/q.obj"))
        fs::copy_file(*path, folder + "/quad.obj", fs::copy_options::overwrite_existing);
    for (const std::string &name : names) {
        requireSuccess(renderQuad(folder, {"-o", name}));
        CHECK(fs::is_regular_file(folder + "/" + name));
    }
    CHECK(newNamesIn(folder) == std::vector<std::string>{"50%done.png", "C#", "take#2"});
    // Exports and inputs alike; where a file has the very name of a pattern, it is meant.
    requireSuccess(runTaut({"export", "quad.obj", "-o", "C#/100%0d.npz", "-q"}, folder));
    CHECK(fs::is_regular_file(folder + "/C#/100%0d.npz"));
    writeBytes(folder + "/take#2/shot#1.obj", kQuad);
    writeBytes(folder + "/scene.toml", "[[mesh]]\nfile = \"take#2/shot#1.obj\"\n");
    const CommandResult one = runTaut({"info", "scene.toml", "--json"}, folder);
    requireSuccess(one);
    CHECK(nlohmann::json::parse(one.out).dump().find("shot#1") != std::string::npos);
    fs::rename(folder + "/take#2/shot#1.obj", folder + "/take#2/shot21.obj");
    requireSuccess(runTaut({"info", "scene.toml", "--json"}, folder)); // a sequence of one
    fs::remove(folder + "/take#2/shot21.obj");
    checkUsageError(runTaut({"info", "scene.toml"}, folder), "no such file");
}

TEST_CASE("Backslashes in paths of scene files", "[files][scene]") {
    const std::string folder = folderOf("backslash");
    fs::create_directories(folder + "/parts/more");
    writeBytes(folder + "/parts/more/q.obj", kQuad);
    for (const char *number : {"01", "02"}) writeBytes(folder + "/parts/s" + number + ".obj", kQuad);
    writeBytes(folder + "/scene.toml", "[[mesh]]\nfile = 'parts\\more\\q.obj'\n[[mesh]]\nfile = 'parts\\s##.obj'\n");
    const CommandResult found = runTaut({"info", "scene.toml", "--json"}, folder);
    requireSuccess(found);
    CHECK(nlohmann::json::parse(found.out).dump().find("\"q\"") != std::string::npos);
    // A file of that very name comes first.
    writeBytes(folder + "/parts\\more\\q.obj", "v 0 0 0\n");
    checkUsageError(runTaut({"info", "scene.toml"}, folder), "found no face");
}

TEST_CASE("Exports of several objects never write over each other", "[files][export][cases]") {
    if (const auto path = caseFile("export-names/cjk.glb")) {
        const std::string folder = freshFolder("names_cjk");
        requireSuccess(runTaut({"export", *path, "-o", folder + "/e.npz", "-q"}));
        CHECK(namesIn(folder).size() == 3);
    }
    const std::string folder = folderOf("export");
    const std::string kanji = "\xe4\xba\xba\xe7\x89\xa9";
    const std::string upper = "\xc3\x84rger";
    const std::string lower = "\xc3\xa4RGER";
    const std::string longName(400, 'n');
    std::string longScript;
    for (int i = 0; i < 120; ++i) longScript += kanji;
    writeBytes(folder + "/scene.toml", sceneOf({kanji, "Body", "body", "BODY_2", "a/b", "a\\b", "../up", upper, lower, longName,
                                                longName + "x", longScript, longScript + "x", "..", "a\tb"}));
    for (const std::string format : {"npz", "ply", "csv", "pc2"}) {
        const CommandResult result = runTaut({"export", "scene.toml", "-o", "out/e." + format, "--json"}, folder);
        requireSuccess(result);
        const std::vector<std::string> names = namesIn(folder + "/out");
        CHECK(names.size() == 15);
        std::set<std::string> folded;
        for (const std::string &name : names) {
            CHECK(name.size() <= 255);
            CHECK(validUtf8(name) == name);
            folded.insert(foldedCase(name));
        }
        CHECK(folded.size() == 15);
        CHECK(std::count(names.begin(), names.end(), "e." + kanji + "." + format) == 1);
        CHECK(std::count(names.begin(), names.end(), "e.Body." + format) == 1);
        CHECK(std::count(names.begin(), names.end(), "e.body_2." + format) == 1);
        CHECK(std::count(names.begin(), names.end(), "e." + upper + "." + format) == 1);
        std::set<std::string> listed;
        const nlohmann::json report = nlohmann::json::parse(result.out);
        for (const auto &file : report["files"]) listed.insert(file.get<std::string>());
        CHECK(listed.size() == 15);
        fs::remove_all(folder + "/out");
    }
    checkUsageError(runTaut({"export", "scene.toml", "-o", "a.npz", "-o", "./b/../a.npz"}, folder), "write over each other");
    checkUsageError(runTaut({"export", "scene.toml", "-o", "##.npz", "-o", "01.npz"}, folder), "write over each other");
    checkUsageError(runTaut({"export", "quad.obj", "-o", "a.npz", "-o", "../" + fs::path(folder).filename().string() + "/a.npz"}, folder),
                    "write over each other");
    writeBytes(folder + "/body.ply",
               "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nelement "
               "face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n");
    checkUsageError(runTaut({"export", "body.ply", "-o", "body.ply"}, folder), "which is the scene itself");
    CHECK(newNamesIn(folder) == std::vector<std::string>{"body.ply"});
}

TEST_CASE("Names are made unique in time that grows with their number", "[files]") {
    DistinctNames unique;
    std::set<std::string> all;
    constexpr int kMany = 200000; // of one name: a search from 2 on for each would take minutes
    for (int i = 0; i < kMany; ++i) all.insert(unique.add("a"));
    CHECK(all.size() == kMany);
    CHECK(unique.add("a_2") == "a_2_2");
    CHECK(utf8Front("\xe4\xba\xba\xe7\x89\xa9", 5) == "\xe4\xba\xba");
    CHECK(validUtf8("a\xe9z\xed\xa0\x80\xc0\x80") == "a\xef\xbf\xbdz\xef\xbf\xbd\xef\xbf\xbd\xef\xbf\xbd\xef\xbf\xbd\xef\xbf\xbd");
    CHECK(foldedCase("A\xc3\x84\xce\xa3\xd0\x96") == foldedCase("a\xc3\xa4\xcf\x82\xd0\xb6"));
}

TEST_CASE("File names that are not UTF-8 work", "[files][cases]") {
    const std::string folder = folderOf("latin1");
    fs::rename(folder + "/quad.obj", folder + "/" + kLatin1 + ".obj");
    const CommandResult info = runTaut({"info", kLatin1 + ".obj", "--json"}, folder);
    requireSuccess(info);
    CHECK(nlohmann::json::parse(info.out).is_object());
    Arguments render{"render", kLatin1 + ".obj", "-o", kLatin1 + ".png", "-o", kLatin1 + ".exr", "--stats", kLatin1 + ".json"};
    render.insert(render.end(), kSmall.begin(), kSmall.end() - 1);
    render.insert(render.end(), {"--progress", "json"});
    const CommandResult rendered = runTaut(render, folder);
    requireSuccess(rendered);
    for (const std::string &line : linesOf(rendered.err)) CHECK(nlohmann::json::accept(line));
    CHECK(nlohmann::json::accept(readBytes(folder + "/" + kLatin1 + ".json")));
    CHECK(readImage(folder + "/" + kLatin1 + ".exr").width == 8);
    for (const std::string format : {"npz", "ply", "csv", "glb", "gltf", "usda", "mdd"}) {
        CAPTURE(format);
        const std::string name = kLatin1 + "." + format;
        const CommandResult result = runTaut({"export", kLatin1 + ".obj", "-o", name, "--json"}, folder);
        requireSuccess(result);
        CHECK(nlohmann::json::parse(result.out)["files"].size() == 1);
        CHECK(fs::is_regular_file(folder + "/" + name));
        if (format == "glb" || format == "gltf") requireSuccess(runTaut({"info", name, "--json"}, folder));
    }
    writeBytes(folder + "/quad.obj", kQuad);
    writeBytes(folder + "/" + kLatin1 + ".toml", sceneOf({"a", "b"}));
    const CommandResult scene = runTaut({"export", kLatin1 + ".toml", "-o", kLatin1 + ".csv", "--json"}, folder);
    requireSuccess(scene);
    CHECK(fs::is_regular_file(folder + "/" + kLatin1 + ".a.csv"));
    fs::copy_file(folder + "/" + kLatin1 + ".glb", folder + "/100%41.glb");
    requireSuccess(runTaut({"export", "100%41.glb", "-o", "100%41.gltf", "-q"}, folder));
    requireSuccess(runTaut({"info", "100%41.gltf"}, folder)); // its .bin is found under a name with a percent sign
}

TEST_CASE("Two processes may write the same frame", "[files]") {
    const std::string folder = folderOf("race");
    std::vector<std::thread> threads;
    std::vector<CommandResult> results(4);
    for (std::size_t i = 0; i < results.size(); ++i)
        threads.emplace_back([&, i] { results[i] = renderQuad(folder, {"--frames", "1-8", "-o", "####.png", "-o", "####.exr"}); });
    for (std::thread &thread : threads) thread.join();
    for (const CommandResult &result : results) requireSuccess(result);
    CHECK(newNamesIn(folder).size() == 16);
    for (const std::string &name : newNamesIn(folder)) CHECK(readImage(folder + "/" + name).width == 8);
}

TEST_CASE("A signal leaves nothing half written", "[files]") {
    const std::string folder = folderOf("signal");
    for (const std::string signal : {"INT", "TERM", "HUP"}) {
        // A million frames: it is writing its caches and spools when the signal comes, or has not begun.
        const CommandResult result = runProgram({"timeout", "--preserve-status", "--signal=" + signal, "1.5", TAUT_COMMAND, "export",
                                                 "quad.obj", "--frames", "1-1000000", "-o", "a.mdd", "-o", "a.usda", "-q"},
                                                300, folder);
        CHECK(result.exitCode == 1);
        CHECK(result.err == "taut: error: stopped by SIG" + signal + "; what was not finished is removed\n");
        CHECK(newNamesIn(folder).empty());
    }
    // What is ignored from the start, as under nohup, does not stop it.
    const CommandResult ignored =
        runShell("trap '' HUP; \"$0\" export quad.obj --frames 1-20000 -o b.mdd -q & sleep 0.2; kill -HUP $!; wait $!", folder);
    requireSuccess(ignored);
    CHECK(newNamesIn(folder) == std::vector<std::string>{"b.mdd"});
}

TEST_CASE("A full disk leaves nothing half written", "[files]") {
    const std::string folder = folderOf("full");
    const std::string options = " -D render.width=256 -D render.height=256 --spp 1 -q";
    const std::vector<std::string> runs{"render quad.obj -o a.exr" + options,
                                        "render quad.obj -o a.png" + options,
                                        "export quad.obj -o a.npz -q",
                                        "export quad.obj -o a.glb -q",
                                        "export quad.obj -o a.gltf -q",
                                        "export quad.obj --frames 1-100 -o a.usda -q",
                                        "export quad.obj --frames 1-100 -o a.mdd -q"};
    for (const std::string &run : runs) {
        CAPTURE(run);
        const CommandResult result = runShell("ulimit -f 1; exec \"$0\" " + run, folder); // 1024 bytes a file
        CHECK(result.exitCode == 1);
        CHECK_THAT(errorLine(result), Catch::Contains("a.") && Catch::Contains("File too large"));
        CHECK(newNamesIn(folder).empty());
    }
    const CommandResult device = runShell("exec \"$0\" render quad.obj -o a.png --stats /dev/full" + options, folder);
    CHECK(device.exitCode == 1);
    CHECK_THAT(errorLine(device), Catch::Contains("/dev/full: could not be written: No space left"));
    for (const std::string run : {"info quad.obj --json", "info quad.obj", "export quad.obj -o b.npz --json"}) {
        CAPTURE(run);
        const CommandResult result = runShell("exec \"$0\" " + run + " > /dev/full", folder);
        CHECK(result.exitCode == 1);
        CHECK_THAT(errorLine(result), Catch::Contains("standard output could not be written"));
    }
    CHECK(newNamesIn(folder) == std::vector<std::string>{"a.png", "b.npz"});
}

TEST_CASE("The cases of TOML keys and of frames", "[toml][cases]") {
    if (const auto deep = caseFile("toml-keys/deep.toml")) checkUsageError(runTaut({"info", *deep}), "nested more than 64 deep");
    if (const auto comment = caseFile("toml-keys/comment.toml")) {
        const std::string folder = freshFolder("toml_comment");
        fs::copy_file(*comment, folder + "/comment.toml");
        writeBytes(folder + "/q.obj", kQuad);
        requireSuccess(runTaut({"info", folder + "/comment.toml"}));
    }
    if (const auto frames = caseFile("frame-total/frames.toml"))
        checkUsageError(runTaut({"info", *frames}), "million frames in all ranges");
}
