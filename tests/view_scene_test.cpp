// taut view: its pictures are those of taut render, for what was changed too; what it says of a point is what taut probe says.

#include "view_server.h"

#include "taut/base/half.h"

#include <cmath>

using namespace taut;
using namespace taut::test;

namespace {

using Json = nlohmann::json;

/// The scene of the other tests at its three frames, smooth enough to be quick.
struct ViewPlace : Workplace {
    explicit ViewPlace(const std::string &name) : Workplace(name) {
        std::string text = plateScene();
        text.replace(text.find("frames = \"1\""), 12, "frames = \"1-3\"");
        writeBytes(scene, text);
    }
};

/// The halves of what `taut render` writes with these arguments.
std::vector<std::uint16_t> rendered(const Workplace &place, const std::string &scene, Arguments arguments, const std::string &only = "1") {
    const std::string output = place.path("rendered.####.exr");
    Arguments words{"render", scene, "-q", "--only", only, "-o", output};
    words.insert(words.end(), arguments.begin(), arguments.end());
    requireSuccess(runTaut(words));
    const Image image = readImage(place.path("rendered.000" + only + ".exr"));
    REQUIRE(image.channels == std::vector<std::string>{"R", "G", "B", "A"});
    std::vector<std::uint16_t> halves;
    for (const float v : image.values) halves.push_back(halfOf(v));
    return halves;
}

Json changeOf(const std::string &key, const Json &value, bool atFrame = false) {
    return {{"key", key}, {"value", value}, {"atFrame", atFrame}};
}

std::uint32_t change(const ViewServer &server, const Json &request) {
    const HttpAnswer answer = server.post("change", request);
    INFO(answer.body);
    REQUIRE(answer.status == 200);
    return answer.json()["version"];
}

int builtScenes(const ViewServer &server) {
    return server.get("state").json()["status"]["built"];
}

/// Resident memory of a process, megabytes.
double residentMegabytes(pid_t process) {
    std::ifstream status("/proc/" + std::to_string(process) + "/status");
    for (std::string line; std::getline(status, line);)
        if (line.rfind("VmRSS:", 0) == 0) return std::stod(line.substr(6)) / 1024;
    return 0;
}

} // namespace

TEST_CASE("view: half floats are rounded to nearest, ties to even", "[view]") {
    const auto value = [](std::uint16_t h) {
        const int exponent = (h >> 10) & 31;
        const int fraction = h & 1023;
        const double size = exponent == 0 ? std::ldexp(fraction, -24) : std::ldexp(1024 + fraction, exponent - 25);
        return (h & 0x8000) != 0 ? -size : size;
    };
    for (std::uint32_t h = 0; h < 0x7c00; ++h) {
        const auto half = static_cast<std::uint16_t>(h);
        REQUIRE(halfOf(static_cast<float>(value(half))) == half);
        REQUIRE(halfOf(static_cast<float>(-value(half))) == (half | 0x8000U));
        if (h == 0x7bff) break;
        const auto next = static_cast<std::uint16_t>(h + 1);
        const auto middle = static_cast<float>(0.5 * (value(half) + value(next)));
        REQUIRE(halfOf(middle) == (h % 2 == 0 ? half : next));
        REQUIRE(halfOf(std::nextafter(middle, 1e9F)) == next);
        REQUIRE(halfOf(std::nextafter(middle, 0.0F)) == half);
    }
    CHECK(halfOf(65519.0F) == 0x7bff);
    CHECK(halfOf(65520.0F) == 0x7c00);
    CHECK(halfOf(std::nanf("")) == 0x7e00);
}

TEST_CASE("view: the picture is that of taut render, after every kind of change", "[view][cli]") {
    const ViewPlace place("view_same");
    const ViewServer server({place.scene});
    CHECK(wholePicture(server, 1).halves == rendered(place, place.scene, {}));
    const int built = builtScenes(server);

    const auto holds = [&](const Json &edit, Arguments overrides) {
        INFO(edit.dump());
        const SeenPicture seen = wholePicture(server, change(server, {{"changes", Json::array({edit})}}));
        CHECK(seen.samples == 4);
        CHECK(seen.halves == rendered(place, place.scene, std::move(overrides)));
    };
    const Arguments camera{"-D", "camera={ position = [0.4, -1.4, 1.5], look_at = [0, 0, 0.1], fov_deg = 40 }"};
    Arguments all = camera;
    holds(changeOf("camera", {{"position", {0.4, -1.4, 1.5}}, {"look_at", {0, 0, 0.1}}, {"fov_deg", 40}}), all);
    all.insert(all.end(), {"-D", "material.brushed.alpha=[0.3, 0.05]"});
    holds(changeOf("material.brushed.alpha", {0.3, 0.05}), all);
    all.insert(all.end(), {"-D", "light.0.radiance=[1, 9, 2]"});
    holds(changeOf("light.0.radiance", {1, 9, 2}), all);
    all.insert(all.end(), {"-D", "environment.radiance=[0.1, 0.2, 0.9]"});
    holds(changeOf("environment.radiance", {0.1, 0.2, 0.9}), all);
    all.insert(all.end(), {"-D", "mesh.0.deform.0.amount=[[1, 0.7], [3, 1.2]]"});
    holds(changeOf("mesh.0.deform.0.amount", 0.7, true), all);
    CHECK(builtScenes(server) == built);
    // What a scene is built from is built.
    all.insert(all.end(), {"-D", "render.max_events=1"});
    holds(changeOf("render.max_events", 1), all);
    CHECK(builtScenes(server) > built);
    // Taken back, one by one and all.
    const Json undo = server.post("change", {{"changes", {changeOf("material.brushed.alpha", 0.9)}}}).json()["undo"];
    CHECK(undo == Json::array({{{"key", "material.brushed.alpha"}, {"text", "[0.3, 0.05]"}}}));
    CHECK(wholePicture(server, change(server, {{"changes", undo}})).halves == rendered(place, place.scene, all));
}

TEST_CASE("view: frames, and gloss held fixed beside gloss that follows", "[view][cli]") {
    const ViewPlace place("view_frames");
    const ViewServer server({place.scene});
    const std::uint32_t version = change(server, {{"frame", 3}, {"wipe", true}});
    CHECK(wholePicture(server, version).halves == rendered(place, place.scene, {}, "3"));
    const SeenPicture fixed = wholePicture(server, version, false);
    CHECK_FALSE(fixed.follows);
    CHECK(fixed.halves == rendered(place, place.scene, {"-D", "mesh.0.follow=false"}, "3"));
    const SeenPicture stretched = wholePicture(server, change(server, {{"channel", "stretch"}}));
    CHECK(stretched.channels == 6);
    CHECK(server.post("change", {{"frame", 4}}).json()["error"].get<std::string>().find("one of the scene's, 1 to 3") != std::string::npos);
    CHECK(server.post("change", {{"channel", "strech"}}).json()["error"].get<std::string>().find("did you mean 'stretch'?") != std::string::npos);
}

TEST_CASE("view: what is saved renders the picture that was seen", "[view][cli]") {
    const ViewPlace place("view_save");
    const ViewServer server({place.scene, "-D", "render.spp=3"});
    const Json changes{changeOf("material.brushed.alpha", {0.31, 0.07}), changeOf("mesh.0.deform.0.amount", -0.4, true),
                       changeOf("camera", {{"position", {0.5, -1.4, 1.5}}, {"look_at", {0, 0, 0}}})};
    const SeenPicture seen = wholePicture(server, change(server, {{"changes", changes}}));
    const Json saved = server.post("save", {{"name", "turned.toml"}}).json();
    CHECK(saved["path"] == place.path("turned.toml"));
    CHECK(rendered(place, place.path("turned.toml"), {}) == seen.halves);
    // The overrides say it as well.
    Arguments overrides{"-D", "render.spp=3"};
    const Json state = server.get("state").json();
    for (const Json &c : state["changes"])
        overrides.insert(overrides.end(), {"-D", c["key"].get<std::string>() + "=" + c["text"].get<std::string>()});
    CHECK(rendered(place, place.scene, overrides) == seen.halves);
    // A saved scene can be opened again.
    const ViewServer again({place.path("turned.toml")});
    CHECK(wholePicture(again, 1).halves == seen.halves);
    // So is the picture, in float.
    REQUIRE(server.post("save", {{"name", "seen.exr"}}).status == 200);
    std::vector<std::uint16_t> halves;
    for (const float v : readImage(place.path("seen.exr")).values) halves.push_back(halfOf(v));
    CHECK(halves == seen.halves);
    // What others wrote is not replaced, and nothing is written elsewhere.
    for (const char *name : {"plate.toml", "../x.toml", ".hidden.toml", "x.sh", "", "a/b.png"}) {
        INFO(name);
        CHECK(server.post("save", {{"name", name}}).status == 400);
    }
    CHECK(server.post("save", {{"name", "seen.exr"}}).status == 200);
    CHECK(readBytes(place.scene).find("[1, 0.0], [3, 1.2]") != std::string::npos);
}

TEST_CASE("view: a change that makes no scene is refused in one line, and changes nothing", "[view][cli]") {
    const ViewPlace place("view_refused");
    const ViewServer server({place.scene});
    const Json before = server.get("state").json();
    const auto refused = [&](const Json &request, const std::string &part) {
        const HttpAnswer answer = server.post("change", request);
        INFO(request.dump() << answer.body);
        CHECK(answer.status == 400);
        CHECK(answer.json()["error"].get<std::string>().find(part) != std::string::npos);
    };
    refused({{"changes", {changeOf("material.brushed.alpah", 0.1)}}}, "did you mean 'alpha'?");
    refused({{"changes", {changeOf("material.brushed.alpha", 20)}}}, "found 20");
    refused({{"changes", {changeOf("material.brushed.poisson", 0.2), changeOf("render.width", "wide")}}}, "found 'wide'");
    refused({{"changes", {changeOf("mesh.0.file", "/etc/passwd")}}}, "expected");
    refused({{"changes", {{{"key", "a b"}, {"value", 1}}}}}, "a dotted key");
    refused({{"changes", {{{"key", "render.spp"}, {"text", "4\n[mesh]"}}}}}, "found");
    refused({{"changes", 3}}, "an array");
    refused({{"changes", {{{"key", "render.spp"}, {"value", 4}, {"atFrame", "yes"}}}}}, "true or false");
    refused({{"frame", "x"}}, "a whole number");
    const Json after = server.get("state").json();
    CHECK(after["changes"] == before["changes"]);
    CHECK(after["panel"] == before["panel"]);
    CHECK(after["version"] == before["version"]);
}

TEST_CASE("view: what is said of a point is what taut probe says", "[view][cli]") {
    const ViewPlace place("view_probe");
    const ViewServer server({place.scene});
    wholePicture(server, change(server, {{"frame", 3}}));
    const Json found = server.get("inspect?x=12.5&y=8").json();
    CHECK(found["object"] == "plate");
    CHECK(found["material"] == "brushed");
    CHECK(found["plan"]["stretch"].is_string());
    CHECK(found["plan"]["questions"].size() > 0);
    // A shear of 1.2: singular values of [1 1.2; 0 1].
    const double mean = std::sqrt(1 + 0.36);
    CHECK(found["stretch"]["max"].get<double>() == Approx(mean + 0.6).epsilon(1e-4));
    CHECK(found["stretch"]["min"].get<double>() == Approx(mean - 0.6).epsilon(1e-4));
    const Json &gloss = found["gloss"];
    std::istringstream words(gloss["probe"].get<std::string>());
    Arguments arguments;
    for (std::string word; words >> word;) arguments.push_back(word);
    REQUIRE(arguments.at(0) == "taut");
    arguments.erase(arguments.begin());
    arguments.insert(arguments.end(), {"-o", place.path("lobe.exr")});
    const CommandResult probed = runTaut(arguments);
    requireSuccess(probed);
    const Json said = Json::parse(probed.out);
    CHECK(said["m"] == gloss["m"]);
    CHECK(said["alpha_max"].get<double>() == Approx(gloss["alpha_max"].get<double>()).epsilon(1e-5));
    CHECK(said["alpha_min"].get<double>() == Approx(gloss["alpha_min"].get<double>()).epsilon(1e-5));
    CHECK(said["max"] == gloss["lobe"]["max"]);
    const Image lobe = readImage(place.path("lobe.exr"));
    const std::vector<float> values = gloss["lobe"]["values"];
    REQUIRE(lobe.values.size() == 3 * values.size());
    for (std::size_t i = 0; i < values.size(); ++i) REQUIRE(lobe.values[3 * i] == values[i]);
    // M takes unit slopes from those of the surface; a shear leaves its determinant.
    const double a = gloss["m"][0], b = gloss["m"][1], d = gloss["m"][3];
    CHECK(std::fabs(a * d) == Approx(1 / (0.1 * 0.4)).epsilon(1e-4));
    CHECK(b != 0.0);
    CHECK(server.get("inspect?x=0&y=0").json().is_null());
    CHECK(server.get("inspect?x=a&y=0").status == 400);
}

TEST_CASE("view: a thousand edits in a row leave memory flat and show no older picture after a newer one", "[view][cli]") {
    const ViewPlace place("view_thousand");
    setenv("ASAN_OPTIONS", "quarantine_size_mb=16", 0); // what a sanitizer keeps of freed memory is no growth
    const ViewServer server({place.scene});
    wholePicture(server, 1);
    std::uint32_t number = 0;
    std::uint32_t version = 0;
    std::uint32_t last = 0;
    double early = 0;
    bool ordered = true;
    for (int i = 0; i < 1000; ++i) {
        const double u = i / 1000.0;
        const Json key = i % 3 == 0   ? changeOf("material.brushed.alpha", 0.05 + 0.5 * u)
                         : i % 3 == 1 ? changeOf("mesh.0.deform.0.amount", u, true)
                                      : changeOf("camera", {{"position", {u, -1.5, 1.5}}, {"look_at", {0, 0, 0}}});
        last = change(server, {{"changes", {key}}});
        if (i == 200) early = residentMegabytes(server.process());
        if (i % 10 != 0) continue;
        const HttpAnswer answer = server.get("picture?follows=1&after=" + std::to_string(number));
        if (answer.status != 200) continue;
        const SeenPicture seen = seenPicture(answer.body);
        ordered &= seen.number > number && seen.version >= version && seen.version <= last;
        number = seen.number;
        version = seen.version;
    }
    CHECK(ordered);
    CHECK(wholePicture(server, last).version == last);
    CHECK(residentMegabytes(server.process()) < 1.2 * early + 16);
}

TEST_CASE("view: what a scene may ask for is what it was when it was first read, however often it changes", "[view][cli]") {
    const Arguments small{"-D", "render.width=48", "-D", "render.height=32", "-D", "render.spp=1", "--max-memory", "64m"};
    Arguments arguments{std::string(TAUT_SOURCE_DIR) + "/apps/demo/rubber.toml"};
    arguments.insert(arguments.end(), small.begin(), small.end());
    const ViewServer server(arguments);
    for (int i = 0; i < 60; ++i) change(server, {{"changes", Json::array({changeOf("render.max_events", i % 2), changeOf("camera", nullptr)})}});
    const std::uint32_t last = change(server, {{"changes", Json::array({changeOf("render.max_events", 2)})}});
    CHECK(wholePicture(server, last).version == last);
}
