// taut view shows what taut render makes beside colour: the ground under a bare file, the denoised picture, layers, the scene's [image].

#include "view_server.h"

#include "taut/base/half.h"
#include "taut/base/vec.h"
#include "taut/images/view_transform.h"

#include <array>
#include <cmath>
#include <iostream>
#include <set>

using namespace taut;
using namespace taut::test;

namespace {

using Json = nlohmann::json;

const Arguments kSmall{"-D", "render.width=64", "-D", "render.height=36", "-D", "render.spp=4"};

Arguments joined(Arguments words, const Arguments &more) {
    words.insert(words.end(), more.begin(), more.end());
    return words;
}

/// What `taut render` writes; of its colours the halves.
Image rendered(const std::string &folder, const std::string &scene, const Arguments &arguments) {
    requireSuccess(runTaut(joined({"render", scene, "-q", "-o", folder + "/rendered.exr"}, arguments)));
    return readImage(folder + "/rendered.exr");
}
std::vector<std::uint16_t> halvesOf(const Image &image, const std::vector<std::string> &channels = {"R", "G", "B", "A"}) {
    std::vector<std::size_t> places;
    for (const std::string &name : channels)
        places.push_back(static_cast<std::size_t>(std::find(image.channels.begin(), image.channels.end(), name) - image.channels.begin()));
    std::vector<std::uint16_t> halves;
    for (std::size_t i = 0; i < image.values.size(); i += image.channels.size())
        for (const std::size_t place : places) halves.push_back(halfOf(image.values.at(i + place)));
    return halves;
}

std::uint32_t change(const ViewServer &server, const Json &request) {
    const HttpAnswer answer = server.post("change", request);
    INFO(answer.body);
    REQUIRE(answer.status == 200);
    return answer.json()["version"];
}

Json camera(double y) {
    return {{"changes", {{{"key", "camera"}, {"value", {{"position", {0.5, y, 1.5}}, {"look_at", {0, 0, 0.2}}}}}}}};
}

/// The page's overrides as words of the command.
Arguments overridesOf(const ViewServer &server) {
    Arguments words;
    const Json state = server.get("state").json();
    for (const Json &c : state["changes"]) words.insert(words.end(), {"-D", c["key"].get<std::string>() + "=" + c["text"].get<std::string>()});
    return words;
}

/// A table on four legs, y up: it would fall over with z up.
std::string tableObj() {
    std::ostringstream text;
    int first = 1;
    const auto box = [&](const DVec3 &a, const DVec3 &b) {
        for (int i = 0; i < 8; ++i)
            text << "v " << ((i & 1) ? b.x : a.x) << ' ' << ((i & 2) ? b.y : a.y) << ' ' << ((i & 4) ? b.z : a.z) << '\n';
        for (const std::array<int, 4> &f : {std::array{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}})
            text << "f " << first + f[0] << ' ' << first + f[1] << ' ' << first + f[2] << ' ' << first + f[3] << '\n';
        first += 8;
    };
    box({-1, 1, -0.8}, {1, 1.1, 0.6});
    for (const double x : {-0.9, 0.8})
        for (const double z : {-0.7, 0.4}) box({x, 0, z}, {x + 0.1, 1, z + 0.1});
    return text.str();
}

} // namespace

TEST_CASE("view: a bare file stands on the ground of taut render, wherever it is looked at from", "[view][cli]") {
    const std::string folder = freshFolder("view_ground");
    const std::string file = folder + "/body.obj";
    writeBytes(file, readBytes(TAUT_SOURCE_DIR "/meshes/body.obj"));
    const ViewServer server(joined({file}, kSmall));
    const SeenPicture first = wholePicture(server, 1);
    CHECK(first.halves == halvesOf(rendered(folder, file, kSmall)));
    CHECK(first.halves != halvesOf(rendered(folder, file, joined({"--no-ground"}, kSmall))));
    // Near, and so far that the ground has to grow.
    for (const double y : {-2.0, -80.0}) {
        const SeenPicture seen = wholePicture(server, change(server, camera(y)));
        CHECK(seen.halves == halvesOf(rendered(folder, file, joined(overridesOf(server), kSmall))));
    }
    // What is saved has it too.
    const SeenPicture near = wholePicture(server, change(server, camera(-2)));
    REQUIRE(server.post("save", {{"name", "saved.toml"}}).status == 200);
    CHECK(halvesOf(rendered(folder, folder + "/saved.toml", {})) == near.halves);
    const ViewServer alone(joined({file, "--no-ground"}, kSmall));
    CHECK(wholePicture(alone, 1).halves == halvesOf(rendered(folder, file, joined({"--no-ground"}, kSmall))));
}

TEST_CASE("view: a mesh that was stood up stays so when a camera is said", "[view][cli]") {
    const std::string folder = freshFolder("view_upright");
    const std::string file = folder + "/table.obj";
    writeBytes(file, tableObj());
    const ViewServer server(joined({file}, kSmall));
    CHECK(wholePicture(server, 1).halves == halvesOf(rendered(folder, file, kSmall)));
    CHECK(overridesOf(server) == Arguments{"-D", "mesh.0.up=\"y\""});
    CHECK(server.errors().find("y is taken for up") != std::string::npos);
    const SeenPicture seen = wholePicture(server, change(server, camera(-5)));
    CHECK(seen.halves == halvesOf(rendered(folder, file, joined(overridesOf(server), kSmall))));
    CHECK(seen.halves != halvesOf(rendered(folder, file, joined({"-D", "camera={ position = [0.5, -5, 1.5], look_at = [0, 0, 0.2] }"}, kSmall))));
}

TEST_CASE("view: the whole picture is denoised as taut render --denoise does it, where that is asked for", "[view][denoise][cli]") {
    const Workplace place("view_denoise");
    const ViewServer server({place.scene});
    const std::vector<std::uint16_t> noisy = wholePicture(server, 1).halves;
    const SeenPicture seen = wholePicture(server, change(server, {{"denoise", true}}));
    const Image expected = rendered(place.path(""), place.scene, {"--denoise"});
    CHECK(seen.halves == halvesOf(expected));
    CHECK(seen.halves != noisy);
    CHECK(server.get("state").json()["denoise"] == true);
    REQUIRE(server.post("save", {{"name", "seen.exr"}}).status == 200);
    const Image saved = readImage(place.path("seen.exr"));
    CHECK(saved.channels == expected.channels);
    CHECK(saved.values == expected.values);
    CHECK(wholePicture(server, change(server, {{"denoise", false}})).halves == noisy);
    CHECK(server.post("change", {{"denoise", "yes"}}).json()["error"].get<std::string>().find("true or false") != std::string::npos);
}

TEST_CASE("view: layers are those of taut render, mattes as colours", "[view][mattes][cli]") {
    const Workplace place("view_layers");
    const ViewServer server({place.scene});
    const Json lights = server.get("state").json()["lights"];
    const SeenPicture groups = wholePicture(server, change(server, {{"channel", "lights"}}));
    REQUIRE(groups.channels == 4 + 3 * lights.size());
    std::vector<std::string> names{"R", "G", "B", "A"};
    for (const Json &light : lights)
        for (const char *c : {".R", ".G", ".B"}) names.push_back("Light_" + light.get<std::string>() + c);
    CHECK(groups.halves == halvesOf(rendered(place.path(""), place.scene, {"--aov", "lights"}), names));
    // One object: its colour, by its cover; nothing elsewhere.
    const SeenPicture mattes = wholePicture(server, change(server, {{"channel", "crypto_object"}}));
    REQUIRE(mattes.channels == 7);
    const Image truth = rendered(place.path(""), place.scene, {"--aov", "crypto_object"});
    const std::vector<std::uint16_t> covers = halvesOf(truth, {"CryptoObject00.G"});
    std::set<std::vector<std::uint16_t>> whole, none;
    for (std::size_t i = 0; i < covers.size(); ++i) {
        const auto colour = mattes.halves.begin() + static_cast<std::ptrdiff_t>(7 * i + 4);
        if (covers[i] == halfOf(1)) whole.emplace(colour, colour + 3);
        if (covers[i] == 0) none.emplace(colour, colour + 3);
    }
    CHECK(whole.size() == 1);
    CHECK(none == std::set<std::vector<std::uint16_t>>{{0, 0, 0}});
    CHECK(whole != none);
    CHECK(server.post("change", {{"channel", "varience"}}).json()["error"].get<std::string>().find("'variance'") != std::string::npos);
}

TEST_CASE("view: exposure and view are the scene's, and its table is the view's transform", "[view][colour][cli]") {
    const Workplace place("view_image");
    const ViewServer server({place.scene, "--exposure", "1.5", "--view", "aces"});
    const auto image = [&] { return server.get("state").json()["image"]; };
    CHECK(image() == Json{{"exposure", 1.5}, {"view", "aces"}, {"own", false}});
    // Between its steps too, as the page interpolates.
    const std::string bytes = server.get("view").body;
    constexpr int kSteps = 65;
    REQUIRE(bytes.size() == std::size_t{kSteps} * kSteps * kSteps * 8);
    std::vector<std::uint16_t> halves(bytes.size() / 2);
    std::memcpy(halves.data(), bytes.data(), bytes.size());
    const auto valueAt = [&](const std::array<int, 3> &step, int c) {
        const std::uint16_t h = halves[4 * static_cast<std::size_t>((step[2] * kSteps + step[1]) * kSteps + step[0]) + static_cast<std::size_t>(c)];
        const int exponent = (h >> 10) & 31;
        return exponent == 0 ? std::ldexp(h & 1023, -24) : std::ldexp(1024 + (h & 1023), exponent - 25);
    };
    const auto looked = [&](const Vec3 &colour, int c) {
        std::array<int, 3> low{};
        std::array<double, 3> rest{};
        for (int k = 0; k < 3; ++k) {
            const double u = (std::log2(static_cast<double>(colour[k]) + 0x1p-10) + 10) / 19 * (kSteps - 1);
            low[static_cast<std::size_t>(k)] = std::min(static_cast<int>(u), kSteps - 2);
            rest[static_cast<std::size_t>(k)] = u - low[static_cast<std::size_t>(k)];
        }
        double sum = 0;
        for (int corner = 0; corner < 8; ++corner) {
            std::array<int, 3> step = low;
            double weight = 1;
            for (std::size_t k = 0; k < 3; ++k) {
                const bool upper = (corner >> k & 1) != 0;
                step[k] += upper ? 1 : 0;
                weight *= upper ? rest[k] : 1 - rest[k];
            }
            sum += weight * valueAt(step, c);
        }
        return sum;
    };
    ViewSettings settings;
    settings.view = "aces";
    const ViewTransform aces(settings);
    double worst = 0;
    double sum = 0;
    for (int i = 0; i < 4000; ++i) { // Halton
        const auto radical = [](int index, int base) {
            double value = 0, scale = 1.0 / base;
            for (; index > 0; index /= base, scale /= base) value += scale * (index % base);
            return value;
        };
        // Sixteen stops of light; of its colours each is down to a tenth of the brightest.
        Vec3 colour(static_cast<float>(std::exp2(16 * radical(i + 1, 7) - 10)));
        for (int k = 0; k < 3; ++k) colour[k] *= static_cast<float>(std::pow(10, -radical(i + 1, std::array{2, 3, 5}[static_cast<std::size_t>(k)])));
        Vec3 truth = colour;
        aces.apply(&truth[0], 1);
        for (int c = 0; c < 3; ++c) {
            const double apart = std::fabs(looked(colour, c) - static_cast<double>(truth[c]));
            worst = std::max(worst, apart);
            sum += apart / 12000;
        }
    }
    std::cout << "the page's table of a view, levels of 8 bits: " << 255 * worst << " at most, " << 255 * sum << " on average" << std::endl;
    CHECK(worst < 4.0 / 255);
    CHECK(sum < 0.1 / 255);
    // A change of it costs the render nothing, and is saved.
    const SeenPicture before = wholePicture(server, 1);
    const int built = server.get("state").json()["status"]["built"];
    change(server, {{"changes", {{{"key", "image.view"}, {"value", "filmic"}}, {{"key", "image.exposure"}, {"value", 0.5}}}}});
    CHECK(image() == Json{{"exposure", 0.5}, {"view", "filmic"}, {"own", true}});
    CHECK(server.get("state").json()["status"]["built"] == built);
    CHECK(server.get("state").json()["status"]["samples"] == before.samples);
    CHECK(server.post("change", {{"changes", {{{"key", "image.view"}, {"value", "filmik"}}}}}).json()["error"].get<std::string>().find("filmic") != std::string::npos);
    REQUIRE(server.post("save", {{"name", "seen.png"}}).status == 200);
    requireSuccess(runTaut({"render", place.scene, "-q", "--exposure", "0.5", "--view", "filmic", "-o", place.path("made.png")}));
    CHECK(readImage(place.path("seen.png")).values == readImage(place.path("made.png")).values);
    REQUIRE(server.post("save", {{"name", "seen.toml"}}).status == 200);
    requireSuccess(runTaut({"render", place.path("seen.toml"), "-q", "-o", place.path("again.png")}));
    CHECK(readImage(place.path("again.png")).values == readImage(place.path("made.png")).values);
    checkUsageError(runTaut({"view", place.scene, "--no-open", "--view", "filmik"}), "did you mean 'filmic'?");
}
