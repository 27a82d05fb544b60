// Frames that are killed, stopped, gone on with, split and merged by the command.

#include "cli_fixtures.h"

#include "taut/base/content_hash.h"

#include <nlohmann/json.hpp>

#include <csignal>
#include <cstring>
#include <random>
#include <thread>

using namespace taut;
using namespace taut::test;

namespace {

/// A frame with motion blur and all AOVs, and samples that take a while.
const Arguments kLong{"-D", "render.shutter=0.8", "--aov", "all", "-D", "render.width=96", "-D", "render.height=64",
                      "-D", "render.frames=2"};
const Arguments kSamples{"--spp", "600"};

/// Without --spp among `more` the frame has its 600 samples.
Arguments renderOf(const Workplace &place, const std::string &output, const Arguments &more = {}) {
    Arguments words{"render", place.scene, "-o", place.path(output)};
    words.insert(words.end(), kLong.begin(), kLong.end());
    if (std::find(more.begin(), more.end(), "--spp") == more.end()) words.insert(words.end(), kSamples.begin(), kSamples.end());
    words.insert(words.end(), more.begin(), more.end());
    return words;
}

void renderWhole(const Workplace &place, const std::string &output, const Arguments &more = {}) {
    requireSuccess(runTaut(renderOf(place, output, more)));
}

bool isSame(const Workplace &place, const std::string &a, const std::string &b) {
    return readBytes(place.path(a)) == readBytes(place.path(b));
}

/// A command that goes on while the test does something.
class Process {
  public:
    Process(const Arguments &words, const std::string &errors) {
        Arguments all{TAUT_COMMAND};
        all.insert(all.end(), words.begin(), words.end());
        std::vector<char *> argv;
        for (std::string &word : all) argv.push_back(word.data());
        argv.push_back(nullptr);
        posix_spawn_file_actions_t actions;
        posix_spawn_file_actions_init(&actions);
        posix_spawn_file_actions_addopen(&actions, STDERR_FILENO, errors.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
        REQUIRE(posix_spawn(&pid_, argv.front(), &actions, nullptr, argv.data(), environ) == 0);
        posix_spawn_file_actions_destroy(&actions);
    }
    void signal(int number) const { kill(pid_, number); }
    [[nodiscard]] bool isRunning() {
        if (!ended_) ended_ = waitpid(pid_, &status_, WNOHANG) == pid_;
        return !ended_;
    }
    /// Its exit code, or minus the signal that ended it.
    int wait() {
        if (!ended_) waitpid(pid_, &status_, 0);
        ended_ = true;
        return WIFEXITED(status_) ? WEXITSTATUS(status_) : -WTERMSIG(status_);
    }

  private:
    pid_t pid_ = 0;
    int status_ = 0;
    bool ended_ = false;
};

bool hasPartial(const std::string &folder) {
    const std::vector<std::string> names = namesIn(folder);
    return std::any_of(names.begin(), names.end(), [](const std::string &name) { return name.ends_with(".partial"); });
}

/// Shares of the frame that were told with this event.
std::vector<double> sharesTold(const std::string &json, const std::string &event) {
    std::vector<double> shares;
    for (const std::string &line : linesOf(json)) {
        const nlohmann::json told = nlohmann::json::parse(line, nullptr, false); // the last may be cut off
        if (told.is_object() && told.value("event", "") == event) shares.push_back(told["share"]);
    }
    return shares;
}

/// Renders to the end, stopped again and again by --time-limit. A machine that is too slow to do anything within it is given longer.
int stopsOnTheWay(const Workplace &place, const std::string &output, const Arguments &more = {}) {
    double limit = 0.2;
    for (int stops = 0;; ++stops) {
        Arguments words = renderOf(place, output, more);
        words.insert(words.end(), {"--resume", "--time-limit", std::to_string(limit) + "s"});
        const CommandResult result = runTaut(words);
        INFO(result.err);
        if (result.exitCode == 0) return stops;
        REQUIRE(result.exitCode == 75);
        REQUIRE(stops < 1000);
        if (stops % 20 == 19) limit *= 2;
    }
}

} // namespace

TEST_CASE("Content hashes are XXH3's", "[checkpoint]") {
    CHECK(contentHash("") == "99aa06d3014798d86001c324468d497f"); // the value that its specification gives
    const std::string folder = freshFolder("hash");
    std::string bytes(1000003, 'a');
    for (std::size_t i = 0; i < bytes.size(); ++i) bytes[i] = static_cast<char>(i * i >> 7U);
    writeBytes(folder + "/a", bytes);
    CHECK(contentHashOfFile(folder + "/a") == contentHash(bytes));
    bytes[777777] ^= 1;
    CHECK(contentHashOfFile(folder + "/a") != contentHash(bytes));
}

TEST_CASE("checkpoint: killed a hundred times at random, every frame goes on and is the same", "[checkpoint]") {
    const Workplace place("kills");
    renderWhole(place, "whole.exr");
    const Arguments words = renderOf(place, "a.exr", {"--checkpoint", "0.05", "--resume", "--progress", "json", "-t", "2"});
    const std::string errors = place.path("said.txt");
    std::mt19937 random(3);
    int finished = 0;
    int whileWriting = 0;
    double kept = 0; // share of the frame that was last told to be safe
    for (int kills = 0; kills < 100; ++kills) {
        Process process(words, errors);
        const bool inWriting = kills % 3 == 0;
        const auto wait = std::chrono::microseconds(20000 + random() % 400000);
        const auto start = std::chrono::steady_clock::now();
        while (process.isRunning() && (inWriting ? !hasPartial(place.folder) : std::chrono::steady_clock::now() - start < wait))
            std::this_thread::sleep_for(std::chrono::microseconds(100));
        if (process.isRunning()) process.signal(SIGKILL);
        const int ended = process.wait();
        const std::string said = readBytes(errors);
        INFO(said);
        REQUIRE((ended == 0 || ended == -SIGKILL));
        if (ended != 0 && hasPartial(place.folder)) ++whileWriting;
        for (const double share : sharesTold(said, "resumed")) CHECK(share >= kept - 1e-12); // nothing that was safe is lost
        for (const double share : sharesTold(said, "checkpoint")) kept = share;
        if (ended != 0) continue;
        REQUIRE(isSame(place, "a.exr", "whole.exr"));
        CHECK(!fs::exists(place.path("a.exr.checkpoint")));
        fs::remove(place.path("a.exr"));
        kept = 0;
        ++finished;
    }
    CHECK(whileWriting > 0);
    requireSuccess(runTaut(words));
    CHECK(isSame(place, "a.exr", "whole.exr"));
    CHECK(namesIn(place.folder) == std::vector<std::string>{"a.exr", "plate.toml", "said.txt", "whole.exr"}); // not what the dead left
    UNSCOPED_INFO(finished << " frames, " << whileWriting << " kills while a file was written");
}

TEST_CASE("checkpoint: a signal leaves one, says so and exits with 75; a second signal ends at once", "[checkpoint]") {
    const Workplace place("signals");
    renderWhole(place, "whole.exr");
    for (const int number : {SIGINT, SIGTERM, SIGHUP}) {
        const std::string errors = place.path("said.txt");
        Process process(renderOf(place, "a.exr", {"--progress", "json"}), errors);
        while (process.isRunning() && readBytes(errors).find("\"progress\"") == std::string::npos)
            std::this_thread::sleep_for(std::chrono::milliseconds(1));
        process.signal(number);
        const int code = process.wait();
        INFO(readBytes(errors));
        if (code == 0) continue; // it had just come to its end
        CHECK(code == 75);
        CHECK(sharesTold(readBytes(errors), "stopped").size() == 1);
        const CommandResult rest = runTaut(renderOf(place, "a.exr", {"--resume", "--progress", "json"}));
        requireSuccess(rest);
        CHECK(sharesTold(rest.err, "resumed").size() == 1);
        CHECK(isSame(place, "a.exr", "whole.exr"));
        fs::remove(place.path("a.exr"));
    }
    Process process(renderOf(place, "b.exr", {"--spp", "1000000", "-q"}), place.path("said.txt"));
    std::this_thread::sleep_for(std::chrono::milliseconds(400));
    process.signal(SIGTERM);
    process.signal(SIGINT);
    CHECK(process.wait() == 75);
    CHECK(!hasPartial(place.folder));
    CHECK(!fs::exists(place.path("b.exr")));
}

TEST_CASE("checkpoint: a limit of time stops, and stops again, until it is done", "[checkpoint]") {
    const Workplace place("limit");
    for (const Arguments &more : {Arguments{}, Arguments{"--noise", "0.05", "--spp", "1024"}}) {
        renderWhole(place, "whole.exr", more);
        CHECK(stopsOnTheWay(place, "a.exr", more) > 0);
        CHECK(isSame(place, "a.exr", "whole.exr"));
        CHECK(!fs::exists(place.path("a.exr.checkpoint")));
    }
}

TEST_CASE("checkpoint: a limit of time that is over before the first sample is said, and the frame comes to its end all the same",
          "[checkpoint]") {
    const Workplace place("late");
    for (const Arguments &more : {Arguments{"--spp", "6"}, Arguments{"--noise", "0.3", "--spp", "64"}}) {
        renderWhole(place, "whole.exr", more);
        Arguments words = renderOf(place, "a.exr", more);
        words.insert(words.end(), {"--resume", "--time-limit", "0.000001s", "--progress", "json"});
        int stops = 0;
        double share = 0;
        for (CommandResult result = runTaut(words); result.exitCode != 0; result = runTaut(words)) {
            INFO(result.err);
            REQUIRE(result.exitCode == 75);
            CHECK(result.err.find("taut: warning: --time-limit 0.000001s was over ") != std::string::npos);
            const std::vector<double> stopped = sharesTold(result.err, "stopped");
            REQUIRE(stopped.size() == 1);
            REQUIRE((stopped[0] > share || more[0] == "--noise")); // whose share is that of whole passes
            share = stopped[0];
            REQUIRE(++stops < 10000);
        }
        CHECK(stops >= (more[0] == "--spp" ? 5 : 1)); // a sample a pixel at most
        CHECK(isSame(place, "a.exr", "whole.exr"));
    }
}

TEST_CASE("checkpoint: one of another scene, version or setting is refused, and stays", "[checkpoint]") {
    const Workplace place("refused");
    fs::copy_file(fs::path(TAUT_SOURCE_DIR) / "meshes/plate.obj", place.path("plate.obj"));
    std::string toml = plateScene();
    const std::string path = TAUT_SOURCE_DIR "/meshes/plate.obj";
    toml.replace(toml.find(path), path.size(), "plate.obj");
    writeBytes(place.scene, toml);
    const Arguments begin = renderOf(place, "a.exr", {"--time-limit", "0.1"});
    REQUIRE(runTaut(begin).exitCode == 75);
    const std::string checkpoint = readBytes(place.path("a.exr.checkpoint"));
    const auto refused = [&](const Arguments &more, const std::string &part) {
        checkUsageError(runTaut(renderOf(place, "a.exr", more)), part);
        CHECK(readBytes(place.path("a.exr.checkpoint")) == checkpoint);
        CHECK(!fs::exists(place.path("a.exr")));
    };
    refused({"--resume", "--spp", "601"}, "a.exr.checkpoint: found samples a pixel 600, expected 601");
    refused({"--resume", "--seed", "5"}, "found seed");
    refused({"--resume", "--frames", "2-3", "--only", "2"}, "#");
    refused({"--resume", "-D", "material.brushed.alpha=0.2"}, "found -D");
    refused({"--resume", "--crop", "0,0,10,10"}, "found pixels 0,0,96,64, expected 0,0,10,10");
    refused({"--resume", "--noise", "0.1"}, "found noise level none, expected 0.1");
    refused({"--resume", "--model", "full"}, "found model auto, expected full");
    refused({"--resume", "--tolerance", "0.5"}, "found tolerance by default, expected 0.5");
    // The mesh, by one byte; the scene file, by a blank.
    const std::string mesh = readBytes(place.path("plate.obj"));
    writeBytes(place.path("plate.obj"), mesh + "\n");
    refused({"--resume"}, "found contents of plate.obj ");
    writeBytes(place.path("plate.obj"), mesh);
    writeBytes(place.scene, toml + "\n");
    refused({"--resume"}, "found contents of plate.toml ");
    writeBytes(place.scene, toml);
    // Another version, as its file would say.
    const std::string version = linesOf(runTaut({"--version"}).out).at(0).substr(std::strlen("taut "));
    std::string other = checkpoint;
    other.replace(other.find("[\"version\",\"" + version), version.size() + 12, "[\"version\",\"9.9.9");
    other.resize(other.size() - 32);
    writeBytes(place.path("a.exr.checkpoint"), other + contentHash(other));
    checkUsageError(runTaut(renderOf(place, "a.exr", {"--resume"})), "found version 9.9.9, expected " + version);
    // Damaged: a bit, the end, everything.
    std::string turned = checkpoint;
    turned[turned.size() / 2] ^= 4;
    for (const std::string &damaged : {turned, checkpoint.substr(0, checkpoint.size() / 2), std::string("v 0 0 0\n"), std::string()}) {
        writeBytes(place.path("a.exr.checkpoint"), damaged);
        checkUsageError(runTaut(renderOf(place, "a.exr", {"--resume"})), "a.exr.checkpoint: found ");
        CHECK(readBytes(place.path("a.exr.checkpoint")) == damaged);
    }
    writeBytes(place.path("a.exr.checkpoint"), checkpoint);
    requireSuccess(runTaut(renderOf(place, "a.exr", {"--resume"})));
}

TEST_CASE("checkpoint: every file that decides the picture is in it", "[checkpoint]") {
    const Workplace place("inputs");
    const auto objOf = [](const std::string &z) { return "v 0 0 " + z + "\nv 1 0 0\nv 1 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nf 1/1 2/2 3/3\n"; };
    for (const std::string name : {"s.1.obj", "s.2.obj", "s.3.obj", "m.obj"}) writeBytes(place.path(name), objOf("0"));
    Image grey{{0, 0, 2, 2}, 2, 2, {"R", "G", "B"}, std::vector<float>(12, 0.5F)};
    writeImage(place.path("sky.exr"), grey);
    writeImage(place.path("skin.png"), grey);
    Arguments cached{"export", place.path("m.obj"), "--frames", "1-3", "-o", place.path("m.pc2"), "-q"};
    requireSuccess(runTaut(cached));
    writeBytes(place.scene, "[render]\nframes = \"2\"\nspp = 100000\n[environment]\nfile = \"sky.exr\"\n[material.a]\ntype = \"diffuse\"\n"
                            "color = { file = \"skin.png\" }\n[[mesh]]\nfile = \"s.#.obj\"\nmaterial = \"a\"\n"
                            "[[mesh]]\nfile = \"m.obj\"\ncache = \"m.pc2\"\nname = \"cached\"\n");
    const CommandResult begun = runTaut({"render", place.scene, "-o", place.path("a.exr"), "--time-limit", "0.1"});
    INFO(begun.err);
    REQUIRE(begun.exitCode == 75);
    for (const std::string name : {"s.1.obj", "s.2.obj", "s.3.obj", "m.obj", "m.pc2", "skin.png", "sky.exr", "plate.toml"}) {
        const std::string before = readBytes(place.path(name));
        std::string after = before;
        if (name == "m.pc2")
            after.back() ^= 1;
        else
            after += "\n";
        writeBytes(place.path(name), after);
        const CommandResult result = runTaut({"render", place.scene, "-o", place.path("a.exr"), "--resume", "--time-limit", "0.1"});
        checkUsageError(result, "found contents of " + name + " ");
        writeBytes(place.path(name), before);
    }
}

TEST_CASE("checkpoint: where none can be written it is said, and nothing whole is damaged", "[checkpoint]") {
    const Workplace place("nowhere");
    renderWhole(place, "whole.exr");
    // No room: files of at most 20 blocks of 512 bytes. The frame's image has none either, and what was there stays.
    writeBytes(place.path("a.exr"), "what was there before");
    const std::string line = "ulimit -f 20; exec \"$0\" render plate.toml -o a.exr --checkpoint 0.05 -q";
    std::string frame;
    for (const std::string &word : kLong) frame += " " + word;
    frame += " --spp 600";
    const CommandResult full = runShell(line + frame, place.folder);
    CHECK(full.exitCode == 1);
    CHECK(full.err.find("taut: warning: no checkpoint: ") == 0);
    CHECK(readBytes(place.path("a.exr")) == "what was there before");
    CHECK(!hasPartial(place.folder));
    // The folder vanishes on the way: it is made again.
    Process process(renderOf(place, "new/a.exr", {"--checkpoint", "0.05", "-q"}), place.path("said.txt"));
    while (process.isRunning() && !fs::exists(place.path("new/a.exr.checkpoint")))
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
    std::error_code error;
    fs::remove_all(place.path("new"), error);
    CHECK(process.wait() == 0);
    CHECK(isSame(place, "new/a.exr", "whole.exr"));
    // A folder that nobody may write into, for a user whom that stops.
    fs::create_directory(place.path("locked"));
    fs::permissions(place.path("locked"), fs::perms::owner_read | fs::perms::owner_exec | fs::perms::others_read | fs::perms::others_exec);
    const std::string nobody = geteuid() == 0 ? "exec setpriv --reuid=65534 --regid=65534 --clear-groups " : "exec ";
    const CommandResult probe = runShell(nobody + "\"$0\" --version", place.folder);
    if (probe.exitCode != 0)
        WARN("a read-only folder was not tried: no other user can run the command here");
    else {
        const CommandResult locked = runShell(nobody + "\"$0\" render plate.toml -o locked/a.exr --checkpoint 0.05 -q" + frame, place.folder);
        CHECK(locked.exitCode == 1);
        CHECK(errorLine(locked).find("locked/a.exr") != std::string::npos);
        CHECK(namesIn(place.path("locked")).empty());
    }
    fs::permissions(place.path("locked"), fs::perms::owner_all);
    // A folder that can't be made is known before the frame is rendered.
    const CommandResult nowhere = runTaut(renderOf(place, "plate.toml/a.exr", {"--spp", "1000000"}));
    CHECK(nowhere.exitCode == 1);
    CHECK(errorLine(nowhere).find("plate.toml/a.exr") != std::string::npos);
}
