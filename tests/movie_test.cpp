// Movies of frames, opened by ffprobe and decoded by ffmpeg.

#include "cli_fixtures.h"

#include "taut/base/srgb.h"

#include <nlohmann/json.hpp>

#include <cmath>
#include <iostream>

using namespace taut;
using namespace taut::test;

namespace {

bool hasFfmpeg() {
    const bool found = runProgram({"sh", "-c", "command -v ffmpeg && command -v ffprobe"}, 10).exitCode == 0;
    if (!found) std::cout << "SKIPPED: there is no ffmpeg on this machine" << std::endl;
    return found;
}

CommandResult renderMovie(const Workplace &place, const Arguments &outputs, const Arguments &more = {}) {
    Arguments words{"render", place.scene, "--frames", "1-5x2,6", "--spp", "2", "-q", "-D", "render.width=33", "-D", "render.fps=12"};
    for (const std::string &output : outputs) words.insert(words.end(), {"-o", place.path(output)});
    words.insert(words.end(), more.begin(), more.end());
    return runTaut(words);
}

} // namespace

TEST_CASE("movie: mp4, webm and gif hold every frame, at the scene's rate and in its colours", "[movie]") {
    if (!hasFfmpeg()) return;
    const Workplace place("movie it's 100%");
    requireSuccess(renderMovie(place, {"a.mp4", "a.webm", "a.gif", "f.####.png"}));
    for (const std::string name : {"a.mp4", "a.webm", "a.gif"}) {
        CAPTURE(name);
        CHECK(!fs::exists(place.path(name + ".frames")));
        const CommandResult probed = runProgram(
            {"ffprobe", "-v", "error", "-count_frames", "-select_streams", "v", "-show_streams", "-of", "json", place.path(name)}, 60);
        requireSuccess(probed);
        const nlohmann::json stream = nlohmann::json::parse(probed.out)["streams"][0];
        CHECK(stream["nb_read_frames"] == "4"); // 1, 3, 5 and 6
        if (name != "a.gif") CHECK(stream["r_frame_rate"] == "12/1"); // a GIF counts hundredths of seconds
        CHECK(stream["width"] == (name == "a.gif" ? 33 : 34)); // chroma of half the size wants even sides
        // The last picture comes back.
        requireSuccess(runProgram({"ffmpeg", "-v", "error", "-y", "-i", place.path(name), "-vf", "select=eq(n\\,3),format=rgb24,crop=33:16:0:0",
                                   "-frames:v", "1", place.path("back.png")},
                                  60));
        const Image back = readImage(place.path("back.png"));
        const Image frame = readImage(place.path("f.0006.png"));
        REQUIRE(back.width == 33);
        double sum = 0;
        for (std::size_t i = 0; i < back.values.size(); i += back.channels.size())
            for (std::size_t c = 0; c < 3; ++c)
                sum +=
                    std::fabs(static_cast<double>(back.values[i + c] - frame.values[i / back.channels.size() * frame.channels.size() + c]));
        CHECK(sum / (33 * 16 * 3) < 0.03); // what the codecs lose; the wrong matrix or range loses more
    }
}

TEST_CASE("movie: its pictures are kept until it is made, and what is there is left out", "[movie]") {
    if (!hasFfmpeg()) return;
    const Workplace place("movie_kept");
    // ffmpeg fails, for the name is taken by a folder: the pictures stay.
    fs::create_directories(place.path("a.gif"));
    const CommandResult failed = renderMovie(place, {"a.gif"});
    CHECK(failed.exitCode == 1);
    CHECK(errorLine(failed).find("a.gif: could not be written") != std::string::npos);
    CHECK(fs::exists(place.path("a.gif.frames/000003.png")));
    fs::remove(place.path("a.gif"));
    const std::string picture = readBytes(place.path("a.gif.frames/000003.png"));
    writeBytes(place.path("a.gif.frames/000002.png"), picture); // left as it is
    requireSuccess(renderMovie(place, {"a.gif"}, {"--skip-existing"}));
    CHECK(fs::is_regular_file(place.path("a.gif")));
    const std::string movie = readBytes(place.path("a.gif"));
    requireSuccess(renderMovie(place, {"a.gif"}, {"--skip-existing", "--seed", "9"}));
    CHECK(readBytes(place.path("a.gif")) == movie);
    CHECK(namesIn(place.folder) == std::vector<std::string>{"a.gif", "plate.toml"});
}

TEST_CASE("movie: of a part of the frames there is none", "[movie]") {
    if (!hasFfmpeg()) return;
    const Workplace place("movie_part");
    checkUsageError(renderMovie(place, {"a.mp4"}, {"--shard", "1/2"}), "a.mp4' for a part of the frames");
    checkUsageError(renderMovie(place, {"a.mp4"}, {"--only", "3"}), "for a part of the frames");
    Arguments words{TAUT_COMMAND, "render", place.scene, "-o", place.path("a.mp4"), "-q"};
    words.insert(words.begin(), {"/usr/bin/env", "PATH=/nowhere"});
    const CommandResult without = runProgram(words, 60);
    CHECK(without.exitCode == 2);
    CHECK(without.err.find("no ffmpeg on this machine, expected ffmpeg") != std::string::npos);
}
