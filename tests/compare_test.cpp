// How far pictures are from one another: FLIP against its closed form for even pictures, and the command.

#include "cli_fixtures.h"

#include "study/measures/flip.h"
#include "study/measures/image_error.h"
#include "study/measures/welch.h"

#include <nlohmann/json.hpp>

#include <cmath>
#include <iostream>

using namespace taut;
using namespace taut::test;

namespace {

std::vector<float> evenPicture(const std::array<float, 3> &rgb, int pixels) {
    std::vector<float> values;
    for (int i = 0; i < pixels; ++i) values.insert(values.end(), rgb.begin(), rgb.end());
    return values;
}

/// FLIP of two even greys: no colour, no features, so that it follows from the two lightnesses alone (the paper's equations 4 to 7).
double flipOfGreys(double a, double b) {
    const auto lightness = [](double y) { return 116 * (y > 216.0 / 24389 ? std::cbrt(y) : y * 841 / 108 + 4.0 / 29) - 16; };
    // Hunt-adjusted CIELAB of full green and full blue in Rec. 709, from the matrix of IEC 61966-2-1: 203.2 apart.
    const double greatest =
        std::pow(std::fabs(87.737 - 32.303) + std::hypot(0.87737 * -86.185 - 0.32303 * 79.197, 0.87737 * 83.181 + 0.32303 * 107.864), 0.7);
    const double power = std::pow(std::fabs(lightness(a) - lightness(b)), 0.7);
    const double knee = 0.4 * greatest;
    return power < knee ? 0.95 * power / knee : 0.95 + 0.05 * (power - knee) / (greatest - knee);
}

} // namespace

TEST_CASE("compare: FLIP of even pictures is its closed form", "[compare]") {
    for (const auto &[a, b] : {std::pair{0.0F, 1.0F}, {0.5F, 0.51F}, {0.02F, 0.5F}, {0.9F, 0.1F}}) {
        const std::vector<float> flip = chart::flip(evenPicture({a, a, a}, 20 * 9), evenPicture({b, b, b}, 20 * 9), 20, 9);
        CAPTURE(a, b);
        REQUIRE(flip.size() == 180);
        for (const float v : flip)
            CHECK(static_cast<double>(v) == Approx(flipOfGreys(static_cast<double>(a), static_cast<double>(b))).epsilon(1e-3));
    }
}

TEST_CASE("compare: FLIP is zero for the same, symmetric, at most one and greatest where pictures differ", "[compare]") {
    constexpr int kSize = 64;
    std::vector<float> a = evenPicture({0.3F, 0.4F, 0.2F}, kSize * kSize);
    std::vector<float> b = a;
    CHECK(chart::meanOf(chart::flip(a, b, kSize, kSize)) == 0);
    for (int y = 20; y < 24; ++y)
        for (int x = 40; x < 44; ++x) b[3 * static_cast<std::size_t>(y * kSize + x)] = 1;
    const std::vector<float> flip = chart::flip(b, a, kSize, kSize);
    CHECK(flip == chart::flip(a, b, kSize, kSize));
    const auto greatest = std::max_element(flip.begin(), flip.end()) - flip.begin();
    CHECK(std::abs(greatest % kSize - 42) <= 3);
    CHECK(std::abs(greatest / kSize - 22) <= 3);
    for (const float v : flip) CHECK((v >= 0 && v <= 1));
    CHECK(flip[0] == 0); // far from it
    // An edge that is only there in one of them looks worse than an even change of the same size.
    std::vector<float> even = evenPicture({0.35F, 0.45F, 0.25F}, kSize * kSize);
    std::vector<float> edge = a;
    for (std::size_t i = 0; i < edge.size(); ++i)
        if (i / 3 % kSize >= kSize / 2) edge[i] += 0.05F;
    const std::vector<float> ofEdge = chart::flip(edge, a, kSize, kSize);
    const std::vector<float> ofEven = chart::flip(even, a, kSize, kSize);
    CHECK(*std::max_element(ofEdge.begin(), ofEdge.end()) > *std::max_element(ofEven.begin(), ofEven.end()));
}

TEST_CASE("compare: the command", "[compare][cli]") {
    const Workplace place("compare");
    const Arguments base{"render", place.scene, "-q", "-o"};
    const auto render = [&](const std::string &name, const Arguments &more) {
        Arguments words = base;
        words.push_back(place.path(name));
        words.insert(words.end(), more.begin(), more.end());
        requireSuccess(runTaut(words));
    };
    render("a.exr", {"--spp", "4"});
    render("b.exr", {"--spp", "64", "--seed", "3"});
    render("b.png", {"--spp", "64", "--seed", "3"});
    const CommandResult same = runTaut({"compare", place.path("a.exr"), place.path("a.exr"), "--json", "--most", "0"});
    requireSuccess(same);
    CHECK(nlohmann::json::parse(same.out)["relmse"] == 0);
    CHECK(nlohmann::json::parse(same.out)["flip_mean"] == 0);
    const CommandResult noisy = runTaut({"compare", place.path("a.exr"), place.path("b.exr"), "--json", "-o", place.path("d.png")});
    requireSuccess(noisy);
    const nlohmann::json said = nlohmann::json::parse(noisy.out);
    const Image a = readImage(place.path("a.exr"));
    const Image b = readImage(place.path("b.exr"));
    std::vector<float> rgbA;
    std::vector<float> rgbB;
    for (std::size_t i = 0; i < a.values.size(); ++i)
        if (i % a.channels.size() < 3) {
            rgbA.push_back(a.values[i]);
            rgbB.push_back(b.values[i]);
        }
    CHECK(said["relmse"].get<double>() == Approx(chart::relativeMse(rgbA, rgbB)));
    CHECK(said["relmse"] > 0);
    // Means of 4 x 4 pixels have a sixteenth of the noise.
    const CommandResult boxed = runTaut({"compare", place.path("a.exr"), place.path("b.exr"), "--json", "--box", "4"});
    requireSuccess(boxed);
    const double ofMeans = nlohmann::json::parse(boxed.out)["boxed_relmse"];
    CHECK(ofMeans == Approx(chart::relativeMse(chart::boxed(rgbA, 24, 16, 4), chart::boxed(rgbB, 24, 16, 4))));
    CHECK(ofMeans < 0.5 * said["relmse"].get<double>());
    checkUsageError(runTaut({"compare", place.path("a.exr"), place.path("b.exr"), "--box", "17"}), "at most 16, the images' shorter side");
    CHECK(readImage(place.path("d.png")).width == 24);
    // A PNG is decoded: what eight bits leave of the picture.
    const CommandResult png = runTaut({"compare", place.path("b.png"), place.path("b.exr"), "--json"});
    requireSuccess(png);
    CHECK(nlohmann::json::parse(png.out)["flip_mean"] < 0.02);
    CHECK(runTaut({"compare", place.path("a.exr"), place.path("b.exr"), "--most", "1e-6"}).exitCode == 1);
    render("small.exr", {"--spp", "1", "--crop", "0,0,8,8"});
    checkUsageError(runTaut({"compare", place.path("small.exr"), place.path("b.exr")}),
                    "small.exr: found pixels 0,0 to 8,8, expected pixels 0,0 to 24,16");
    checkUsageError(runTaut({"compare", place.scene, place.path("b.exr")}), "plate.toml: found no readable image");
    checkUsageError(runTaut({"compare", place.path("a.exr"), place.path("none.exr")}), "none.exr");
    // Headers are measured before a decoder allocates by them.
    const std::string ihdr = std::string("IHDR\0\0\x40\0\0\0\x40\0\x10\6\0\0\1", 17);
    writeBytes(place.path("large.png"), std::string("\x89PNG\r\n\x1a\n\0\0\0\r", 12) + ihdr + std::string(64, '\1'));
    checkUsageError(runTaut({"compare", place.path("large.png"), place.path("b.exr")}), "large.png: found");
    writeBytes(place.path("long.exr"), std::string("\x76\x2f\x31\1\2\0\0\0a\0b\0\xff\xff\xff\x7f", 16));
    checkUsageError(runTaut({"compare", place.path("long.exr"), place.path("b.exr")}), "OpenEXR attribute of 2147483647 bytes");
}

TEST_CASE("t-test: Student's tables, Welch's degrees of freedom, and a count by chance", "[compare]") {
    for (const auto &[freedom, bound] :
         {std::pair{1.0, 12.7062047}, {2.0, 4.30265273}, {4.0, 2.77644511}, {10.0, 2.22813885}, {100.0, 1.98397152}})
        CHECK(chart::studentTail(bound, freedom) == Approx(0.05).epsilon(1e-6));
    CHECK(chart::studentTail(1.95996398, HUGE_VAL) == Approx(0.05).epsilon(1e-6));
    CHECK(chart::studentTail(-1, 1) == Approx(0.5));
    CHECK(chart::studentTail(1e6, 1e6) == Approx(0).margin(1e-12));
    // Variances of means 0.04 of 5 and 0.09 of 9 samples: t = 1 / sqrt(0.13); freedom 0.13^2 / (0.04^2 / 4 + 0.09^2 / 8) = 11.96.
    const std::vector<float> a{3};
    const std::vector<float> b{2};
    const std::vector<float> va{0.04F};
    const std::vector<float> vb{0.09F};
    const std::vector<float> na{5};
    const std::vector<float> nb{9};
    const double t = 1 / std::sqrt(0.13);
    const double tail = chart::studentTail(t, 0.0169 / (0.0016 / 4 + 0.0081 / 8));
    for (const double level : {tail * 0.999, tail * 1.001}) {
        const chart::WelchTest test = chart::welchTest({a, va, na}, {b, vb, nb}, level);
        CHECK(test.tested == 1);
        CHECK(test.greatest == Approx(t));
        CHECK(test.beyond == (level > tail ? 1U : 0U));
    }
    // Without a variance: the same is not tested, what differs is beyond.
    const std::vector<float> two{1, 2};
    const std::vector<float> other{1, 3};
    const std::vector<float> none{0, 0};
    const chart::WelchTest sure = chart::welchTest({two, none, {}}, {other, none, {}});
    CHECK(sure.tested == 1);
    CHECK(sure.beyond == 1);
}

TEST_CASE("compare: two seeds differ by chance, two scenes do not", "[compare][cli]") {
    const Workplace place("compare_t");
    const auto render = [&](const std::string &name, const Arguments &more) {
        Arguments words{"render", place.scene,        "-q", "--spp",         "32", "-D", "render.width=96", "-D", "render.height=64",
                        "--aov",  "samples,variance", "-o", place.path(name)};
        words.insert(words.end(), more.begin(), more.end());
        requireSuccess(runTaut(words));
    };
    render("a.exr", {"--independent"});
    render("b.exr", {"--independent", "--seed", "1"});
    render("c.exr", {"--independent", "--seed", "2", "-D", "light.0.radiance=15"});
    render("d.exr", {"--seed", "3"});
    render("e.exr", {"--seed", "4"});
    const auto test = [&](const std::string &x, const std::string &y) {
        const CommandResult said = runTaut({"compare", place.path(x), place.path(y), "--json"});
        requireSuccess(said);
        nlohmann::json result = nlohmann::json::parse(said.out)["t_test"];
        std::cout << x << " against " << y << ": " << result << std::endl;
        return result;
    };
    const nlohmann::json same = test("a.exr", "b.exr");
    CHECK(same["tested"] > 2000);
    CHECK(same["by_chance"] == Approx(0.05 * same["tested"].get<double>()));
    CHECK(same["share"].get<double>() == Approx(0.05).margin(0.02));
    CHECK(test("a.exr", "c.exr")["share"] > 0.5);
    CHECK(test("d.exr", "e.exr")["share"] < 0.05); // points that stratify one another are better than their variance says
    const std::string line = runTaut({"compare", place.path("a.exr"), place.path("b.exr"), "-o", place.path("t.exr")}).out;
    CHECK(line.find("values beyond the 5 % bound") != std::string::npos);
    const Image picture = readImage(place.path("t.exr"));
    CHECK(std::fabs(meanOf(picture, "T.G")) < 0.2);
    // Without variances there is no test.
    requireSuccess(runTaut({"render", place.scene, "-q", "--spp", "4", "-o", place.path("plain.exr")}));
    CHECK(runTaut({"compare", place.path("plain.exr"), place.path("plain.exr")}).out.find("t-test") == std::string::npos);
}
