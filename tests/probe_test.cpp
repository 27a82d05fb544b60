/// taut probe against closed values and quadrature in double, its manual's examples, its images, and what it says to bad options.

#include "cli_fixtures.h"

#include <nlohmann/json.hpp>

#include <cmath>
#include <sstream>

using namespace taut;
using namespace taut::test;

namespace {

nlohmann::json probe(const std::string &line, const std::string &folder = "") {
    Arguments arguments{"probe"};
    std::istringstream words(line);
    for (std::string word; words >> word;) arguments.push_back(word);
    const CommandResult result = runTaut(arguments, folder);
    INFO(line);
    requireSuccess(result);
    CHECK(result.err.empty());
    return nlohmann::json::parse(result.out);
}

/// Every member of `part` is in `whole`, numbers to a relative `tolerance`.
void checkWithin(const nlohmann::json &part, const nlohmann::json &whole, double tolerance) {
    INFO(part.dump() << " in " << whole.dump());
    if (part.is_object()) {
        for (const auto &[key, value] : part.items()) {
            REQUIRE(whole.contains(key));
            checkWithin(value, whole[key], tolerance);
        }
    } else if (part.is_array()) {
        REQUIRE(whole.size() == part.size());
        for (std::size_t i = 0; i < part.size(); ++i) checkWithin(part[i], whole[i], tolerance);
    } else if (part.is_number()) {
        CHECK(whole.get<double>() == Approx(part.get<double>()).epsilon(tolerance).margin(1e-6));
    } else {
        CHECK(part == whole);
    }
}

std::string angleOf(double slope) {
    std::ostringstream text;
    text.precision(17);
    text << std::atan(slope) * 180 / std::acos(-1.0);
    return text.str();
}

} // namespace

TEST_CASE("probe pdf: closed values of D, G1 and the stretched cosine", "[probe]") {
    const auto normal = [](const std::string &m, double slope, int phi) {
        return probe("pdf --m " + m + " --theta " + angleOf(slope) + " --phi " + std::to_string(phi) + " --theta-in " + angleOf(slope) +
                     " --phi-in " + std::to_string(phi));
    };
    CHECK(normal("10,20,0,10", 0.1, 0)["D"].get<double>() == Approx(0.9019664).epsilon(2e-6));
    CHECK(normal("10,20,0,10", 0.1, 90)["D"].get<double>() == Approx(8.1176979).epsilon(2e-6));
    CHECK(normal("10,20,0,10", std::hypot(0.1, 0.1), -45)["D"].get<double>() == Approx(3.6796623).epsilon(2e-6));
    CHECK(normal("10,0,0,30", 0, 0)["D"].get<double>() == Approx(95.4930).epsilon(1e-6));
    CHECK(normal("10,20,0,10", 0, 0)["D"].get<double>() == Approx(31.8310).epsilon(1e-6));
    CHECK(normal("30,0,0,10", 0, 0)["D"].get<double>() == Approx(95.4930).epsilon(1e-6));
    CHECK(normal("10,20,0,10", 0.75, 0)["G1"].get<double>() == Approx(0.9985977).epsilon(1e-6));
    CHECK(normal("10,20,0,10", 0.75, 90)["G1"].get<double>() == Approx(0.9930659).epsilon(1e-6));
    // G1 = 2 c / (1 + c) of the cosine c in standard space.
    const auto leaning = probe("pdf --m 2,.5,0,1.5,.8,-.4 --theta " + angleOf(0.75) + " --theta-in " + angleOf(0.75) + " --phi-in 180");
    CHECK(leaning["G1"].get<double>() == Approx(2 * 0.9624671 / 1.9624671).epsilon(1e-6));
    CHECK(leaning["G1_in"].get<double>() == Approx(2 * 0.7496341 / 1.7496341).epsilon(1e-6));
}

TEST_CASE("probe pdf: the members agree with each other", "[probe]") {
    for (const char *mode : {"separable", "correlated"})
        for (const char *m : {"--m 1,2,0,1", "--alpha .3,.6 --rotation 20", "--m 1,2,1.5,-.5"}) {
            const auto j = probe(std::string("pdf ") + m + " --theta 40 --phi 15 --theta-in 55 --phi-in 170 --f0 0.7 --mode " + mode);
            const double cosO = j["wo"][2];
            const double cosI = j["wi"][2];
            const double half = j["wo"][0].get<double>() * j["wm"][0].get<double>() + j["wo"][1].get<double>() * j["wm"][1].get<double>() +
                                cosO * j["wm"][2].get<double>();
            const double fresnel = 0.7 + 0.3 * std::pow(1 - half, 5);
            const double d = j["D"];
            const double g1 = j["G1"];
            const double g2 = j["G2"];
            CHECK(j["f"].get<double>() == Approx(fresnel * d * g2 / (4 * cosO * cosI)).epsilon(1e-5));
            CHECK(j["pdf"].get<double>() == Approx(g1 * d / (4 * cosO)).epsilon(1e-5)); // D_vis / (4 wo.wm)
            CHECK(j["weight"].get<double>() == Approx(fresnel * g2 / g1).epsilon(1e-5));
            const double apart = g1 * j["G1_in"].get<double>();
            if (std::string(mode) == "separable")
                CHECK(g2 == Approx(apart).epsilon(1e-5));
            else
                CHECK(g2 == Approx(1 / (1 / g1 + 1 / j["G1_in"].get<double>() - 1)).epsilon(1e-5));
        }
}

TEST_CASE("probe albedo: closed values within three standard errors, and the walk's", "[probe]") {
    const auto check = [](const std::string &line, const char *key, double truth, double leastError) {
        const auto j = probe("albedo " + line);
        const std::string error = std::string(key) == "albedo" ? "standard_error" : "mean_bounces_standard_error";
        INFO(line << ": " << j[key] << " +- " << j[error]);
        CHECK(std::fabs(j[key].get<double>() - truth) <= 3 * j[error].get<double>() + leastError);
        CHECK(j[error].get<double>() < 4e-3 * truth);
    };
    // The values are given to as many digits as stand here.
    check("--alpha 1", "albedo", 1 - std::log(2.0), 5e-7);
    check("--alpha .5", "albedo", 0.6878485, 5e-7);
    check("--alpha .25", "albedo", 0.9158124, 5e-7);
    check("--alpha .1", "albedo", 0.9883041, 1e-6);
    check("--alpha 1 --mode walk", "mean_bounces", 2.302, 5e-4);
    check("--m 1,2,0,1 --mode walk", "mean_bounces", 3.263, 5e-4);
    check("--alpha 2 --mode walk --samples 262144", "mean_bounces", 4.383, 5e-4);
    check("--m 10,20,0,10 --mode walk --samples 262144", "mean_bounces", 1.046, 5e-4);
    // White furnace, seen askew too.
    CHECK(probe("albedo --m 1,2,0,1,.3,-.2 --theta 60 --phi 70 --mode walk --samples 65536")["albedo"].get<double>() ==
          Approx(1).epsilon(1e-4));
    // One seed gives one answer, whatever the words.
    CHECK(probe("albedo --alpha .5 --samples 4096 --seed 3") == probe("albedo --m 2,0,0,2 --spp 4096 --seed 3 --json"));
    CHECK(probe("albedo --alpha .5 --samples 4096 --seed 3") != probe("albedo --alpha .5 --samples 4096 --seed 4"));
}

TEST_CASE("probe sample: directions are reflections with the density and weight that pdf tells", "[probe]") {
    const auto samples = probe("sample --m 1,2,0,1 --theta 50 --phi 20 --samples 64")["samples"];
    REQUIRE(samples.size() == 64);
    int checked = 0;
    for (const auto &s : samples) {
        REQUIRE(!s["wi"].is_null());
        const double x = s["wi"][0];
        const double y = s["wi"][1];
        const double z = s["wi"][2];
        CHECK(x * x + y * y + z * z == Approx(1).epsilon(1e-5));
        CHECK(s["weight"].get<double>() <= 1);
        if (++checked > 4) continue; // each is a run of the command
        std::ostringstream line;
        line.precision(17);
        line << "pdf --m 1,2,0,1 --theta 50 --phi 20 --theta-in " << std::acos(z) * 180 / std::acos(-1.0) << " --phi-in "
             << std::atan2(y, x) * 180 / std::acos(-1.0);
        const auto j = probe(line.str());
        CHECK(s["pdf"].get<double>() == Approx(j["sampler_pdf"].get<double>()).epsilon(1e-4));
        CHECK(s["weight"].get<double>() == Approx(j["f"].get<double>() * z / j["sampler_pdf"].get<double>()).epsilon(1e-4));
    }
}

TEST_CASE("probe lobe: the image's mapping, integral and metadata", "[probe]") {
    const std::string folder = freshFolder("probe_lobe");
    const auto j = probe("lobe --m 2,1,0,2 --theta 45 --phi 30 --width 360 -o lobe.exr", folder);
    const auto albedo = probe("albedo --m 2,1,0,2 --theta 45 --phi 30");
    CHECK(j["integral"].get<double>() == Approx(albedo["albedo"].get<double>()).epsilon(2e-3));
    CHECK(metadata(folder + "/lobe.exr", "taut:mapping").find("latlong") == 0);
    CHECK(metadata(folder + "/lobe.exr", "taut:quantity") == "fcos");
    const Image image = readImage(folder + "/lobe.exr");
    REQUIRE(image.width == 360);
    REQUIRE(image.height == 180);
    // The pixel whose centre is theta 60.5, phi 200.5 holds f cos there.
    const auto at = probe("pdf --m 2,1,0,2 --theta 45 --phi 30 --theta-in 60.5 --phi-in 200.5");
    const double expected = at["f"].get<double>() * at["wi"][2].get<double>();
    CHECK(valueAt(image, 200, 60, "R") == Approx(expected).epsilon(2e-2));
    for (int x = 0; x < 360; x += 7) CHECK(valueAt(image, x, 100, "G") == 0); // below the horizon
    // The density of a sampler that rejects nothing.
    CHECK(probe("lobe --m 1,2,0,1 --theta 45 --quantity pdf --width 200")["integral"].get<double>() == Approx(1).epsilon(1e-3));
    // A PNG is white at its maximum.
    const auto png = probe("lobe --m 1,2,0,1 --width 64 -o lobe.png", folder);
    CHECK(png["scale"].get<double>() == Approx(1 / png["max"].get<double>()).epsilon(1e-6));
    CHECK(fs::exists(folder + "/lobe.png"));
    // The walk is noisy, not biased: all of the light.
    CHECK(probe("lobe --alpha 1 --theta 30 --mode walk --width 128 --samples 8")["integral"].get<double>() == Approx(1).epsilon(2e-2));
}

TEST_CASE("probe: bad options end with one line, exit 2, the nearest name, and no output", "[probe]") {
    const std::string folder = freshFolder("probe_errors");
    const auto fails = [&](const Arguments &words, const std::string &part) {
        Arguments arguments{"probe"};
        arguments.insert(arguments.end(), words.begin(), words.end());
        const CommandResult result = runTaut(arguments, folder);
        INFO(part);
        checkUsageError(result, part);
    };
    fails({}, "expected albedo, pdf, sample, lobe or microgeometry");
    fails({"albdo"}, "did you mean 'albedo'?");
    fails({"albedo", "--m", "1,0,0,1", "--tehta", "3"}, "did you mean '--theta'?");
    fails({"albedo", "--m", "1,0,0,1", "--mode", "wlak"}, "did you mean 'walk'?");
    fails({"lobe", "--m", "1,0,0,1", "--quantity", "pdff"}, "did you mean 'pdf'?");
    fails({"albedo"}, "neither --m nor --alpha");
    fails({"albedo", "--m", "1,0,0,1", "--alpha", "1"}, "both --m and --alpha");
    fails({"albedo", "--m", "1,2,3"}, "3 numbers");
    fails({"albedo", "--m", "1,2,2,4"}, "singular");
    fails({"albedo", "--m", "1,nan,2,4"}, "finite");
    fails({"albedo", "--m", "1,x,2,4"}, "--m");
    fails({"albedo", "--alpha", "0"}, "more than 0");
    fails({"albedo", "--alpha", "1,1,1"}, "--alpha");
    fails({"albedo", "--alpha", "1", "--theta", "200"}, "[0, 180]");
    fails({"albedo", "--alpha", "1", "--phi", "inf"}, "finite");
    fails({"albedo", "--alpha", "1", "--f0", "2"}, "[0, 1]");
    fails({"albedo", "--alpha", "1", "--samples", "0"}, "--samples");
    fails({"lobe", "--alpha", "1", "-o", "lobe.jpg"}, ".exr or .png");
    fails({"microgeometry", "--alpha", "1", "--facets", "10"}, "--facets");
    CHECK(namesIn(folder).empty());
}

TEST_CASE("probe: extreme microsurfaces and views give finite numbers", "[probe]") {
    for (const char *m : {"--m 1e8,0,0,1e8", "--m 1e-9,0,0,1", "--m 1,1000,0,1", "--m 1,0,0,1,5,5"})
        for (const char *theta : {"89.999", "90", "130"}) {
            const auto j = probe(std::string("pdf ") + m + " --theta " + theta + " --phi 10 --theta-in 60");
            INFO(j.dump());
            for (const char *key : {"D", "G1", "G1_in", "G2", "f", "pdf", "weight", "sampler_pdf"}) CHECK(j[key].is_number());
        }
    CHECK(probe("albedo --m 1,1000,0,1 --theta 89.99 --samples 1024")["albedo"].get<double>() <= 1.001);
    // From straight below nothing is visible: 0 / 0.
    CHECK(probe("pdf --alpha 0.5 --theta 180 --theta-in 60")["pdf"].is_null());
}

TEST_CASE("the manual of probe: its examples give what it prints", "[probe][docs]") {
    const std::string folder = freshFolder("probe_docs");
    const std::string manual = readBytes(TAUT_SOURCE_DIR "/docs/probe.md");
    int examples = 0;
    for (std::size_t at = manual.find("```sh\n"); at != std::string::npos; at = manual.find("```sh\n", at)) {
        at += 6;
        const std::string line = manual.substr(at, manual.find('\n', at) - at);
        REQUIRE(line.rfind("taut probe ", 0) == 0);
        const std::size_t begin = manual.find("```json\n", at) + 8;
        const auto printed = nlohmann::json::parse(manual.substr(begin, manual.find("```", begin) - begin));
        // Digits are as printed; a walk may turn another way where another machine rounds a logarithm otherwise.
        checkWithin(printed, probe(line.substr(11), folder), line.find("walk") == std::string::npos ? 1e-5 : 2e-3);
        ++examples;
    }
    CHECK(examples >= 8);
}
