/// A frame in steps: stopped, read, saved, restored and split, it stays the picture that it is.

#include "catch.h"
#include "command.h"
#include "render_fixtures.h"

#include "taut/base/error.h"

#include <tbb/global_control.h>

#include <atomic>
#include <cstdlib>
#include <random>
#include <thread>

using namespace taut;
using namespace taut::test;

namespace {

constexpr int kSamples = 24;

/// A sheared torus that moves while the shutter is open, over a floor, under lamp and sky: blur, AOVs, several events.
Scene steppedScene() {
    Scene scene = smallScene(shearedTorus(24, 12), ggxMaterial(0.1F, 0.3F), 72);
    scene.render.shutter = 0.5;
    scene.render.boxFilter = false;
    return scene;
}

FrameOptions steppedOptions(bool adaptive) {
    FrameOptions options;
    options.spp = adaptive ? 96 : kSamples;
    if (adaptive) options.noise = 0.05;
    options.seed = 77;
    const std::string_view names[] = {"m", "stretch", "depth"};
    options.aovs = aovsNamed(names, "test");
    return options;
}

/// A frame of it, made ready anew.
struct Stepped {
    explicit Stepped(bool adaptive, FrameOptions options) : scene(steppedScene(), false) {
        StageTimes times;
        scene.setFrame(2, times);
        if (!adaptive) options.noise.reset();
        render.emplace(scene, options);
    }
    explicit Stepped(bool adaptive) : Stepped(adaptive, steppedOptions(adaptive)) {}
    RenderScene scene;
    std::optional<FrameRender> render;
};

Film uninterrupted(bool adaptive) {
    Stepped s(adaptive);
    REQUIRE(s.render->advance() == FrameState::Done);
    return s.render->film();
}

/// Advances until somebody stops it after a random time of at most `longest` microseconds; restored from and saved to `path`.
void goOn(bool adaptive, const std::string &path, std::mt19937 &random, unsigned longest) {
    Stepped s(adaptive);
    if (fs::exists(path)) {
        std::ifstream in(path, std::ios::binary);
        s.render->restore(in);
    }
    const auto wait = std::chrono::microseconds(random() % longest);
    std::thread stopper([&] {
        std::this_thread::sleep_for(wait);
        s.render->stop();
    });
    s.render->advance();
    stopper.join();
    std::ofstream out(path + ".new", std::ios::binary);
    s.render->save(out);
    out.close();
    fs::rename(path + ".new", path);
}

const char *const kTask = "TAUT_TEST_FRAME_TASK";
const char *const kState = "TAUT_TEST_FRAME_STATE";

} // namespace

/// What a child process of the next test does: five stops.
TEST_CASE("frame: go on from a saved state, a child", "[.][frame-child]") {
    const char *task = std::getenv(kTask); // "even SEED THREADS MICROSECONDS"
    REQUIRE(task != nullptr);
    std::istringstream words(task);
    std::string kind;
    unsigned seed = 0;
    std::size_t threads = 1;
    unsigned longest = 1;
    words >> kind >> seed >> threads >> longest;
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    std::mt19937 random(seed);
    for (int i = 0; i < 5; ++i) goOn(kind == "adaptive", std::getenv(kState), random, longest);
}

TEST_CASE("frame: stopped a hundred times at random, saved, gone on with in other processes, the picture is the same", "[frame]") {
    for (const bool adaptive : {false, true}) {
        const std::string path = outputFolder("states") + (adaptive ? "/adaptive.state" : "/even.state");
        fs::remove(path);
        Stepped whole(adaptive);
        REQUIRE(whole.render->advance() == FrameState::Done);
        const Film expected = whole.render->film();
        // Fifty stops come to the time of one frame, however fast this program is.
        const auto longest = std::max(100U, static_cast<unsigned>(whole.render->seconds() * 1e6 / 25));
        for (unsigned child = 0; child < 10; ++child) {
            const std::string task = std::string(adaptive ? "adaptive " : "even ") + std::to_string(child) + ' ' +
                                     std::to_string(1 + child % 3) + ' ' + std::to_string(longest);
            const CommandResult result = runProgram({"/usr/bin/env", kTask + std::string("=") + task, kState + std::string("=") + path,
                                                     fs::read_symlink("/proc/self/exe").string(), "[frame-child]"},
                                                    300);
            INFO(result.out << result.err);
            REQUIRE(result.exitCode == 0);
        }
        Stepped last(adaptive);
        std::ifstream in(path, std::ios::binary);
        last.render->restore(in);
        CHECK(last.render->share() > 0);
        CHECK(last.render->advance() == FrameState::Done);
        CHECK(last.render->film() == expected);
    }
}

TEST_CASE("frame: any budgets, threads and order of passes give the same film", "[frame]") {
    const Film whole = uninterrupted(false);
    std::mt19937 random(4);
    for (const std::size_t threads : {1U, 2U, 5U}) {
        const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
        Stepped s(false);
        FrameState state = FrameState::Going;
        int steps = 0;
        while (state == FrameState::Going) {
            state = s.render->advance(random() % 2U != 0 ? FrameBudget{static_cast<int>(1 + random() % 5U), 0} : FrameBudget{0, 1e-4});
            ++steps;
        }
        CHECK(state == FrameState::Done);
        CHECK(steps > 3);
        CHECK(s.render->film() == whole);
    }
    // Passes in another order, and samples split over films: numbers 15 to 23, then 0 to 6, then the rest.
    Film merged(whole.window(), whole.aovs());
    for (const auto &[first, count] : {std::pair{15, 9}, {0, 7}, {7, 8}}) {
        FrameOptions options = steppedOptions(false);
        options.firstSample = first;
        options.spp = count;
        Stepped s(false, options);
        s.render->advance();
        merged.merge(s.render->film());
    }
    CHECK(merged == whole);
    // Pixels split, not along tiles; the whole grows from its parts.
    Film grown({}, whole.aovs());
    for (const Window &part : {Window{0, 0, 29, 72}, Window{29, 0, 72, 50}, Window{29, 50, 72, 72}}) {
        FrameOptions options = steppedOptions(false);
        options.window = part;
        Stepped s(false, options);
        s.render->advance();
        if (grown.window().empty())
            grown = s.render->film();
        else
            grown.merge(s.render->film());
    }
    CHECK(grown == whole);
}

TEST_CASE("frame: an adaptive frame in passes and under budgets is the same", "[frame][adaptive]") {
    const Film whole = uninterrupted(true);
    for (const FrameBudget &budget : {FrameBudget{1, 0}, FrameBudget{0, 1e-4}}) {
        Stepped s(true);
        while (s.render->advance(budget) == FrameState::Going) {}
        CHECK(s.render->film() == whole);
    }
}

TEST_CASE("frame: it is read while it goes on, and what is read is whole samples", "[frame]") {
    Stepped s(false);
    std::atomic<bool> over{false};
    std::size_t reads = 0;
    bool sane = true;
    std::thread reader([&] {
        while (!over) {
            const Film film = s.render->film();
            ++reads;
            const Window &w = film.window();
            for (int y = w.y0; y < w.y1; ++y)
                for (int x = w.x0; x < w.x1; ++x)
                    sane &= film.samplesAt(x, y) <= kSamples && film.samplesAt(x, y) == film.samplesAt(x / 16 * 16, y / 16 * 16);
        }
    });
    while (s.render->advance({1, 0}) == FrameState::Going) {}
    over = true;
    reader.join();
    CHECK(sane);
    CHECK(reads > 0);
    CHECK(s.render->film() == uninterrupted(false));
}

TEST_CASE("frame: stop and progress", "[frame]") {
    SECTION("a stop before the start ends the next advance, once") {
        Stepped s(false);
        s.render->stop();
        CHECK(s.render->advance() == FrameState::Stopped);
        CHECK(s.render->share() == 0);
        CHECK(s.render->film().samples() == 0);
        CHECK(s.render->advance() == FrameState::Done);
        CHECK(s.render->share() == 1);
        CHECK(s.render->advance() == FrameState::Done); // nothing left
    }
    SECTION("the progress function may stop, and is told by one thread at a time") {
        const RenderScene *scene = nullptr;
        Stepped s(false);
        scene = &s.scene;
        FrameOptions options = steppedOptions(false);
        std::atomic<int> inside{0};
        int calls = 0;
        bool alone = true;
        double last = 0;
        options.progress = [&](double share) {
            alone &= ++inside == 1;
            ++calls;
            last = share;
            --inside;
            return calls < 3;
        };
        const FrameResult result = renderFrame(*scene, options);
        CHECK_FALSE(result.complete);
        CHECK(alone);
        CHECK(last < 1);
        options.progress = [&](double share) {
            last = share;
            return true;
        };
        CHECK(renderFrame(*scene, options).complete);
        CHECK(last == 1);
    }
    SECTION("a small budget gets further at every call") {
        Stepped s(false);
        double before = 0;
        while (s.render->advance({0, 1e-9}) == FrameState::Going) {
            REQUIRE(s.render->share() > before);
            before = s.render->share();
        }
        CHECK(s.render->done());
    }
}

TEST_CASE("frame: a state of another frame or a damaged one is refused, and nothing changes", "[frame]") {
    Stepped saved(false);
    saved.render->advance({3, 0});
    std::ostringstream out;
    saved.render->save(out);
    const std::string bytes = out.str();
    const auto refused = [&](const FrameOptions &options, const std::string &text) -> std::string {
        Stepped s(options.noise.has_value(), options);
        std::istringstream in(text);
        try {
            s.render->restore(in);
        } catch (const InputError &error) {
            CHECK(s.render->share() == 0);
            return error.what();
        }
        return "";
    };
    const FrameOptions same = steppedOptions(false);
    CHECK(refused(same, bytes).empty());
    FrameOptions other = same;
    other.seed = 78;
    CHECK(refused(other, bytes) == "saved frame: found seed 77, expected 78");
    other = same;
    other.firstSample = 1;
    CHECK(refused(other, bytes) == "saved frame: found first sample 0, expected 1");
    other = same;
    other.window = {0, 0, 10, 10};
    CHECK_THAT(refused(other, bytes), Catch::Contains("found other pixels"));
    other = same;
    other.aovs.pop_back();
    CHECK_THAT(refused(other, bytes), Catch::Contains("found other AOVs"));
    other = same;
    other.spp = 2;
    CHECK_THAT(refused(other, bytes), Catch::Contains("found 3 samples in one pixel of a tile, expected at most 2"));
    CHECK_THAT(refused(steppedOptions(true), bytes), Catch::Contains("found adaptive 0, expected 1"));
    for (std::size_t length = 0; length < bytes.size(); length += 1 + bytes.size() / 40)
        CHECK_FALSE(refused(same, bytes.substr(0, length)).empty());
    // More samples than it was begun with are no other frame.
    other = same;
    other.spp = 2 * kSamples;
    CHECK(refused(other, bytes).empty());
}

TEST_CASE("frame: options that contradict each other are refused", "[frame]") {
    RenderScene scene(steppedScene(), false);
    StageTimes times;
    scene.setFrame(2, times);
    const auto refused = [&](const auto &change) -> std::string {
        FrameOptions options;
        change(options);
        try {
            const FrameRender render(scene, options);
        } catch (const InputError &error) {
            return error.what();
        }
        return "";
    };
    CHECK_THAT(refused([](FrameOptions &o) { o.spp = 0; }), Catch::Contains("found 0 samples"));
    CHECK_THAT(refused([](FrameOptions &o) { o.firstSample = -1; }), Catch::Contains("found first sample -1"));
    CHECK_THAT(refused([](FrameOptions &o) { o.window = {0, 0, 73, 10}; }), Catch::Contains("beyond the frame"));
    CHECK_THAT(refused([](FrameOptions &o) {
                   o.noise = 0.1;
                   o.firstSample = 4;
               }),
               Catch::Contains("adaptive"));
}
