/// taut render --denoise: what is in the files, and that shards and checkpoints end in the same.

#include "cli_fixtures.h"

using namespace taut;
using namespace taut::test;

namespace {

CommandResult render(const Workplace &place, const std::string &output, const Arguments &more) {
    Arguments words{"render", place.scene, "-q", "-o", place.path(output)};
    words.insert(words.end(), more.begin(), more.end());
    return runTaut(words);
}

} // namespace

TEST_CASE("denoise: the unfiltered picture and the error are in the EXR, the PNG is filtered", "[denoise]") {
    const Workplace place("denoise");
    requireSuccess(render(place, "plain.exr", {"--frames", "2"}));
    requireSuccess(render(place, "clean.exr", {"--frames", "2", "--denoise", "--aov", "depth", "-o", place.path("clean.png")}));
    const Image plain = readImage(place.path("plain.exr"));
    const Image clean = readImage(place.path("clean.exr"));
    const std::size_t error = channelOf(clean, "DenoiseError");
    const std::size_t step = clean.channels.size();
    CHECK(step == 9);
    bool changed = false;
    for (std::size_t p = 0; p < plain.values.size() / plain.channels.size(); ++p) {
        for (const char *name : {"R", "G", "B"}) {
            const float before = plain.values[p * plain.channels.size() + channelOf(plain, name)];
            CHECK(clean.values[p * step + channelOf(clean, std::string("Noisy.") + name)] == before);
            changed |= clean.values[p * step + channelOf(clean, name)] != before;
        }
        CHECK(clean.values[p * step + channelOf(clean, "A")] == plain.values[p * plain.channels.size() + channelOf(plain, "A")]);
        CHECK(clean.values[p * step + error] >= 0);
    }
    CHECK(changed);
    CHECK(metadata(place.path("plain.exr"), "taut:denoised") == "absent");
    CHECK(metadata(place.path("clean.exr"), "taut:denoised") == "by itself");
    CHECK(fs::exists(place.path("clean.png")));
}

TEST_CASE("denoise: shards merge into the very files of the whole, over frames too", "[denoise]") {
    const Workplace place("denoise_shards");
    for (const std::string option : {"--denoise", "--denoise-frames"}) {
        requireSuccess(render(place, "whole#.exr", {"--frames", "1-3", option}));
        for (const std::string by : {"samples", "rows"}) {
            const std::string name = by + "#.exr";
            for (const std::string shard : {"1/2", "2/2"})
                requireSuccess(render(place, name, {"--frames", "1-3", option, "--shard", shard, "--shard-by", by}));
            requireSuccess(runTaut({"merge", "--frames", "1-3", "-q", "-o", place.path(name), "--remove-shards"}));
            for (const std::string frame : {"1", "2", "3"})
                CHECK(readBytes(place.path(by + frame + ".exr")) == readBytes(place.path("whole" + frame + ".exr")));
        }
    }
    // A crop is denoised by what it holds.
    requireSuccess(render(place, "crop.exr", {"--denoise", "--crop", "5,3,14,10"}));
    CHECK(readImage(place.path("crop.exr")).window == Window{5, 3, 14, 10});
    requireSuccess(render(place, "noise.exr", {"--denoise", "--noise", "0.2", "--spp", "32"}));
}

TEST_CASE("denoise: over frames is refused where frames are left out", "[denoise]") {
    const Workplace place("denoise_refused");
    checkUsageError(render(place, "a#.exr", {"--frames", "1-2", "--denoise-frames", "--skip-existing"}),
                    "--denoise-frames: found --skip-existing");
    checkUsageError(render(place, "a#.exr", {"--frames", "1-2", "--denoise-frames", "--only", "2"}), "--only");
    checkUsageError(render(place, "a#.exr", {"--frames", "1-4", "--denoise-frames", "--shard", "1/2"}), "shards of frames");
    checkUsageError(render(place, "a#.exr", {"--frames", "1-2", "--denoise-frames", "--fixed-seed"}), "a fixed seed");
    CHECK(!fs::exists(place.path("a1.exr")));
}
