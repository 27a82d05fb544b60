#include "scene_fixtures.h"
#include "statistics.h"

#include "taut/scene/environment.h"

#include <random>

using namespace taut;
using namespace taut::test;

namespace {

/// A map with everything that makes sampling hard: one texel a thousand times brighter, black columns and rows, a bright pole.
Environment harshEnvironment(int width = 16, int height = 8, double rotation = 0.7) {
    std::mt19937 random(5);
    std::uniform_real_distribution<float> uniform(0.01F, 1);
    Environment e;
    e.width = width;
    e.height = height;
    e.rotation = rotation;
    e.constant = false;
    e.texels.clear();
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            const bool black = x > width / 2 && x < width - 2;
            e.texels.emplace_back(black || y == height / 2 ? Vec3(0) : Vec3(uniform(random), uniform(random), uniform(random)));
        }
    e.texels[static_cast<std::size_t>((height - 1) / 2 * width + 2)] = Vec3(800, 900, 1000);
    e.texels[1] = Vec3(30);
    buildSampling(e);
    return e;
}

Vec3 directionAt(double z, double azimuth) {
    const double r = std::sqrt(std::max(0.0, 1 - z * z));
    return {static_cast<float>(r * std::cos(azimuth)), static_cast<float>(r * std::sin(azimuth)), static_cast<float>(z)};
}

/// Midpoint rule over the sphere on a grid that knows nothing of the map's texels.
template <class F> DVec3 overSphere(int rings, const F &f) {
    const int steps = 2 * rings;
    DVec3 sum(0);
    for (int i = 0; i < rings; ++i)
        for (int j = 0; j < steps; ++j) sum += DVec3(f(directionAt(1 - 2 * (i + 0.5) / rings, kTwoPi * (j + 0.5) / steps)));
    return sum * (2 * kTwoPi / rings / steps);
}

double cosAtRow(int row, int height) {
    return std::cos(kTwoPi / 2 * row / height);
}

} // namespace

TEST_CASE("the environment's density integrates to one", "[environment]") {
    for (const Environment &e : {harshEnvironment(), harshEnvironment(7, 5), constantEnvironment(Vec3(2))}) {
        const DVec3 mass = overSphere(1200, [&](const Vec3 &w) { return Vec3(lookUpEnvironment(e, w).pdf); });
        CHECK(mass.x == Approx(1).epsilon(2e-3)); // the grid cuts through texels
    }
    const Environment e = harshEnvironment(); // exact: constant over each texel
    double mass = 0;
    for (int y = 0; y < e.height; ++y)
        for (int x = 0; x < e.width; ++x) {
            const double z = 0.5 * (cosAtRow(y, e.height) + cosAtRow(y + 1, e.height));
            const double azimuth = e.rotation + kTwoPi * (0.5 - (x + 0.5) / e.width);
            mass +=
                lookUpEnvironment(e, directionAt(z, azimuth)).pdf * (cosAtRow(y, e.height) - cosAtRow(y + 1, e.height)) * kTwoPi / e.width;
        }
    CHECK(mass == Approx(1).epsilon(1e-5));
}

TEST_CASE("environment samples follow the density", "[environment]") {
    constexpr int kSamples = 400000;
    const std::vector<Environment> environments{harshEnvironment(), harshEnvironment(5, 3, -2), constantEnvironment(Vec3(1))};
    for (const Environment &e : environments) {
        // Bins: quarters of texels, over which the density is constant; a constant map is cut as if it had texels.
        const int rows = e.constant ? 6 : e.height;
        const int columns = e.constant ? 12 : e.width;
        const auto edge = [&](int half) { // z at half rows: halfway in z between row edges
            return half % 2 == 0 ? cosAtRow(half / 2, rows) : 0.5 * (cosAtRow(half / 2, rows) + cosAtRow(half / 2 + 1, rows));
        };
        std::vector<double> observed(static_cast<std::size_t>(4 * rows * columns));
        std::vector<double> expected(observed.size());
        for (int y = 0; y < 2 * rows; ++y)
            for (int x = 0; x < 2 * columns; ++x) {
                const Vec3 w = directionAt(0.5 * (edge(y) + edge(y + 1)), e.rotation + kTwoPi * (0.5 - (x + 0.5) / (2 * columns)));
                expected[static_cast<std::size_t>(y * 2 * columns + x)] =
                    kSamples * lookUpEnvironment(e, w).pdf * (edge(y) - edge(y + 1)) * kTwoPi / (2 * columns);
            }
        std::mt19937 random(17);
        std::uniform_real_distribution<float> uniform(0, 1);
        for (int i = 0; i < kSamples; ++i) {
            const float u = std::min(uniform(random), kOneMinusEpsilon);
            const EnvironmentSample s = sampleEnvironment(e, {u, std::min(uniform(random), kOneMinusEpsilon)});
            int y = 0;
            while (y + 1 < 2 * rows && s.direction.z < edge(y + 1)) ++y;
            double turn = 0.5 - (std::atan2(s.direction.y, s.direction.x) - e.rotation) / kTwoPi;
            turn -= std::floor(turn);
            const int x = std::min(2 * columns - 1, static_cast<int>(turn * 2 * columns));
            observed[static_cast<std::size_t>(y * 2 * columns + x)] += 1;
        }
        CHECK(chiSquaredP(observed, expected) > sidak(0.01, static_cast<int>(environments.size())));
    }
}

TEST_CASE("an environment sample agrees with what is looked up", "[environment]") {
    const Environment e = harshEnvironment();
    std::mt19937 random(23);
    std::uniform_real_distribution<float> uniform(0, kOneMinusEpsilon);
    DVec3 estimate(0);
    constexpr int kSamples = 400000;
    int acrossAnEdge = 0; // of a texel, by the rounding of the direction
    float brightest = 0;
    for (const Vec3 &texel : e.texels) brightest = std::max(brightest, maxComponent(texel));
    for (int i = 0; i < kSamples; ++i) {
        const EnvironmentSample s = sampleEnvironment(e, {uniform(random), uniform(random)});
        REQUIRE(s.pdf > 0);
        REQUIRE(glm::length(s.direction) == Approx(1).epsilon(1e-6));
        const float pdf = lookUpEnvironment(e, s.direction).pdf;
        if (s.pdf != pdf && pdf != 0) ++acrossAnEdge;
        // Where the point was drawn in the map against where its rounded direction leads back to: 1e-6 of the map's width.
        REQUIRE(glm::distance(s.radiance, lookUpEnvironment(e, s.direction).radiance) < 1e-3F * brightest);
        estimate += DVec3(s.radiance / s.pdf);
    }
    CHECK(acrossAnEdge < kSamples / 1000);
    estimate /= kSamples;
    const DVec3 truth = overSphere(1500, [&](const Vec3 &w) { return lookUpEnvironment(e, w).radiance; });
    for (int c = 0; c < 3; ++c) CHECK(estimate[c] == Approx(truth[c]).epsilon(0.01));
    // The blurred texels' mean differs from the truth only by the cosine's curve within a row.
    const DVec3 mean = DVec3(harshEnvironment(64, 32).mean) * 2.0 * kTwoPi;
    const Environment fine = harshEnvironment(64, 32);
    const DVec3 fineTruth = overSphere(1500, [&](const Vec3 &w) { return lookUpEnvironment(fine, w).radiance; });
    for (int c = 0; c < 3; ++c) CHECK(mean[c] == Approx(fineTruth[c]).epsilon(0.01));
    // The corners of the unit square of random numbers.
    for (const float x : {0.0F, kOneMinusEpsilon})
        for (const float y : {0.0F, kOneMinusEpsilon}) {
            const EnvironmentSample s = sampleEnvironment(e, {x, y});
            CHECK(s.pdf > 0);
            CHECK(isFinite(s.direction));
        }
}

TEST_CASE("the density is positive wherever the radiance is", "[environment]") {
    Environment e; // a single lit texel: bilinear radiance reaches into its neighbours
    e.width = 16;
    e.height = 8;
    e.constant = false;
    e.texels.assign(128, Vec3(0));
    e.texels[3 * 16 + 15] = Vec3(1); // at the seam
    buildSampling(e);
    std::mt19937 random(3);
    std::uniform_real_distribution<double> uniform(0, 1);
    int lit = 0;
    for (int i = 0; i < 200000; ++i) {
        const Vec3 w = directionAt(1 - 2 * uniform(random), kTwoPi * uniform(random));
        if (lookUpEnvironment(e, w).radiance == Vec3(0)) continue;
        ++lit;
        REQUIRE(lookUpEnvironment(e, w).pdf > 0);
    }
    CHECK(lit > 1000);
}

TEST_CASE("a black environment samples as a constant", "[environment]") {
    Environment e;
    e.width = 4;
    e.height = 2;
    e.constant = false;
    e.texels.assign(8, Vec3(0));
    buildSampling(e);
    CHECK(e.constant);
    CHECK(sampleEnvironment(e, {0.3F, 0.6F}).pdf == Approx(1 / (2 * kTwoPi)));
    CHECK(lookUpEnvironment(e, Vec3(0, 0, 1)).radiance == Vec3(0));
}

TEST_CASE("environment map directions", "[environment]") {
    Warnings warnings;
    const std::string folder = outputFolder("environment");
    std::vector<float> texels(8 * 4 * 3, 0.0F);
    const auto set = [&](int x, int y, float value) { texels[static_cast<std::size_t>((y * 8 + x) * 3)] = value; };
    set(3, 1, 4); // centre columns: +x
    set(4, 1, 4);
    set(1, 1, 5); // a quarter from the left: +y
    set(2, 1, 5);
    for (int x = 0; x < 8; ++x) set(x, 0, 7); // top: +z
    const std::string path = writeImage(folder, "directions.exr", 8, 4, 3, texels, SampleType::Float);
    const float z = std::cos(kPi * 1.5F / 4); // the second row's centre
    const float r = std::sqrt(1 - z * z);
    const Environment e = readEnvironment(path, 0, Vec3(1), warnings);
    CHECK(lookUpEnvironment(e, {r, 0, z}).radiance.x == Approx(4));
    CHECK(lookUpEnvironment(e, {0, r, z}).radiance.x == Approx(5));
    CHECK(lookUpEnvironment(e, {-r, 0, z}).radiance.x == Approx(0).margin(1e-5));
    CHECK(lookUpEnvironment(e, {0, 0, 1}).radiance.x == Approx(7));
    CHECK(lookUpEnvironment(e, {0, 0, -1}).radiance.x == Approx(0));
    // Turned a quarter about z: what was seen along +x is seen along +y.
    const Environment turned = readEnvironment(path, radians(90), Vec3(2, 1, 1), warnings);
    CHECK(lookUpEnvironment(turned, {0, r, z}).radiance.x == Approx(8));
    CHECK(lookUpEnvironment(turned, {-r, 0, z}).radiance.x == Approx(10));
}

TEST_CASE("Single texels that are no radiance are held and counted", "[environment]") {
    Warnings warnings;
    const std::string folder = outputFolder("environment");
    std::vector<float> texels(4 * 2 * 3, 1.0F);
    texels[3 * (4 + 2) + 1] = -1;
    const std::string negative = writeImage(folder, "negative.exr", 4, 2, 3, texels, SampleType::Float);
    CHECK(readEnvironment(negative, 0, Vec3(1), warnings).texels[6] == Vec3(1, 0, 1));
    REQUIRE(warnings.lines.size() == 1);
    CHECK(says(warnings.lines[0], "negative.exr: of 8 texels: 1 negative, held at 0", {"column 2, row 1"}));
    texels[3 * (4 + 2) + 1] = NAN;
    const std::string nan = writeImage(folder, "nan.exr", 4, 2, 3, texels, SampleType::Float);
    CHECK(readEnvironment(nan, 0, Vec3(1), warnings).texels[6] == Vec3(1, 0, 1));
    REQUIRE(warnings.lines.size() == 2);
    CHECK(says(warnings.lines[1], "nan.exr: of 8 texels: 1 not a number, held at 0", {"column 2, row 1"}));
    texels[3 * (4 + 2) + 1] = INFINITY;
    texels[0] = 9;
    texels[5] = -1;
    const std::string both = writeImage(folder, "both.exr", 4, 2, 3, texels, SampleType::Float);
    const Environment held = readEnvironment(both, 0, Vec3(2), warnings);
    CHECK(held.texels[6] == Vec3(2, 18, 2));
    CHECK(held.texels[1] == Vec3(2, 2, 0));
    REQUIRE(warnings.lines.size() == 3);
    CHECK(says(warnings.lines[2], "both.exr: of 8 texels: 1 infinite, held at 9, 1 negative, held at 0", {"column 1, row 0"}));
    texels[8] = texels[11] = NAN; // with those, more than a quarter
    const std::string many = writeImage(folder, "many.exr", 4, 2, 3, texels, SampleType::Float);
    CHECK(says(errorOf([&] { readEnvironment(many, 0, Vec3(1), warnings); }), "many.exr: found 4 of 8 texels", {"at most a quarter"}));
    texels = std::vector<float>(4 * 2 * 3, 1.0F);
    texels[3 * (4 + 2) + 1] = 1e30F;
    const std::string large = writeImage(folder, "large.exr", 4, 2, 3, texels, SampleType::Float);
    CHECK(says(errorOf([&] { readEnvironment(large, 0, Vec3(1e20F), warnings); }),
               "large.exr: found a radiance that is not finite when scaled", {}));
    CHECK(says(errorOf([&] { readEnvironment(folder + "/none.exr", 0, Vec3(1), warnings); }), "none.exr", {}));
}

TEST_CASE("a Radiance HDR file is read", "[environment]") {
    Warnings warnings;
    const std::string folder = outputFolder("environment");
    const std::string path = writeImage(folder, "half.hdr", 16, 8, 3, std::vector<float>(16 * 8 * 3, 0.5F), SampleType::Float);
    const Environment e = readEnvironment(path, 0, Vec3(1), warnings);
    CHECK(e.width == 16);
    CHECK(e.mean.y == Approx(0.5).epsilon(0.01));
    if (const auto real = asset("hdr/studio_small_03_1k.hdr")) {
        const Environment studio = readEnvironment(*real, 0, Vec3(1), warnings);
        CHECK(studio.width == 1024);
        CHECK(maxComponent(studio.mean) > 0);
    }
}

TEST_CASE("the built-in studio", "[environment]") {
    const Environment e = studioEnvironment();
    CHECK(e.width == 512);
    CHECK(e.height == 256);
    float least = kInfinity;
    float most = 0;
    for (const Vec3 &texel : e.texels) {
        least = std::min({least, texel.x, texel.y, texel.z});
        most = std::max(most, maxComponent(texel));
    }
    CHECK(least >= 0.0499F);
    CHECK(most <= 12);
    CHECK(most > 5);
    CHECK(luminance(e.mean) > 0.2F);
    CHECK(luminance(e.mean) < 2);
}

TEST_CASE("environments give many lanes what they give one", "[environment][batch]") {
    for (const Environment &e : {harshEnvironment(), harshEnvironment(7, 5, -9.1), constantEnvironment(Vec3(2)), studioEnvironment()})
        for (const Instructions set : {Instructions::Sse2, Instructions::Avx2, Instructions::Avx512}) {
            EnvironmentLanes drawn;
            EnvironmentLanes met;
            drawn.count = met.count = 61;
            for (std::size_t i = 0; i < 61; ++i) {
                drawn.u[i] = i == 0 ? 0.0F : i == 1 ? kOneMinusEpsilon : static_cast<float>(i * 37 % 61) / 61;
                drawn.v[i] = i == 2 ? 0.0F : i == 3 ? kOneMinusEpsilon : static_cast<float>(i) / 61;
                const double azimuth = 0.1 * static_cast<double>(i);
                met.direction.set(i, i == 0   ? Vec3(0, 0, 1)
                                     : i == 1 ? Vec3(-1, 0, 0)
                                              : directionAt(1 - static_cast<double>(i) / 30, azimuth));
            }
            sampleEnvironment(e, drawn, set);
            lookUpEnvironment(e, met, set);
            for (std::size_t i = 0; i < 61; ++i) {
                const EnvironmentSample one = sampleEnvironment(e, {drawn.u[i], drawn.v[i]});
                CHECK(drawn.direction.at(i) == one.direction);
                CHECK(drawn.radiance.at(i) == one.radiance);
                CHECK(drawn.pdf[i] == one.pdf);
                const EnvironmentLookup seen = lookUpEnvironment(e, met.direction.at(i));
                CHECK(met.radiance.at(i) == seen.radiance);
                CHECK(met.pdf[i] == seen.pdf);
            }
        }
}
