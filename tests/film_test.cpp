/// Exact sums, and films that are split, merged, saved and restored.

#include "catch.h"

#include "taut/base/error.h"
#include "taut/render/film.h"

#include <cmath>
#include <cstring>
#include <random>
#include <sstream>

using namespace taut;

namespace {

/// Numbers of every size that light has, of both signs.
std::vector<float> numbers(std::size_t count, unsigned seed) {
    std::mt19937 random(seed);
    std::vector<float> out;
    for (std::size_t i = 0; i < count; ++i) {
        const auto bits = random();
        out.push_back(std::ldexp(static_cast<float>(bits & 0xffffffU), static_cast<int>(random() % 60U) - 45) *
                      ((bits >> 31U) != 0 ? -1.0F : 1.0F));
    }
    return out;
}

struct Sample {
    int x, y;
    Vec3 radiance;
    float alpha;
    std::vector<float> aovs;
};

std::vector<Sample> samplesOf(const Window &window, int spp, unsigned seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<float> uniform(0, 3);
    std::vector<Sample> samples;
    for (int s = 0; s < spp; ++s)
        for (int y = window.y0; y < window.y1; ++y)
            for (int x = window.x0; x < window.x1; ++x) {
                Sample sample{x, y, {uniform(random), uniform(random) * 1e-6F, uniform(random) * 1e5F}, uniform(random) / 3, {}};
                if (random() % 3U != 0) sample.aovs = {uniform(random), -uniform(random), uniform(random)};
                samples.push_back(sample);
            }
    return samples;
}

const std::string_view kNames[] = {"depth", "uv"};

void add(Film &film, const Sample &s) {
    film.add(s.x, s.y, s.radiance, s.alpha, s.aovs.empty() ? nullptr : s.aovs.data());
}

} // namespace

TEST_CASE("exact sums: against long double, in any order, to the last bit", "[film]") {
    for (const unsigned seed : {1U, 2U, 3U}) {
        std::vector<float> values = numbers(1000, seed);
        ExactSum sum;
        long double reference = 0; // 64 bits of significand: all of these sums are exact in it but for what is below 2^-41
        for (const float v : values) {
            sum.add(v);
            reference += static_cast<long double>(v);
        }
        CHECK(sum.value() == Approx(static_cast<double>(reference)).epsilon(1e-15));
        std::mt19937 random(seed + 100);
        for (int round = 0; round < 20; ++round) {
            std::shuffle(values.begin(), values.end(), random);
            ExactSum parts[3];
            for (std::size_t i = 0; i < values.size(); ++i) parts[random() % 3U].add(values[i]);
            parts[2].add(parts[0]);
            parts[2].add(parts[1]);
            REQUIRE(parts[2] == sum);
        }
    }
}

TEST_CASE("exact sums: what one float gives, at the ends of the range", "[film]") {
    const auto one = [](float x) {
        ExactSum sum;
        sum.add(x);
        return sum.value();
    };
    for (const float x : {1.0F, -1.0F, 0.1F, 1.5e-12F, -4.6e-13F, 65504.0F, 1e18F, 0.0F, -0.0F}) CHECK(one(x) == static_cast<double>(x));
    CHECK(one(0x1p-64F) == 0x1p-64);
    CHECK(one(0x1.8p-64F) == 0x1p-63); // halves go up, for either sign
    CHECK(one(-0x1.8p-64F) == -0x1p-63);
    CHECK(one(0x1p-66F) == 0);
    CHECK(one(1e-40F) == 0); // subnormal
    CHECK(one(std::numeric_limits<float>::quiet_NaN()) == 0);
    for (const float x : {1e19F, 3e38F, kInfinity}) {
        CHECK(one(x) == 0x1p63);
        CHECK(one(-x) == -0x1p63);
    }
    ExactSum held;
    for (int i = 0; i < 5; ++i) held.add(4e18F);
    CHECK(held.value() == 0x1p63);
    const ExactSum again(held.low(), held.high());
    CHECK(again == held);
}

TEST_CASE("exact sums: a million dim samples beside a bright one are all there", "[film]") {
    ExactSum sum;
    float naive = 0;
    for (int i = 0; i < 1'000'000; ++i) {
        sum.add(0x1p-40F);
        naive += 0x1p-40F;
        if (i == 1000) {
            sum.add(0x1p30F);
            naive += 0x1p30F;
        }
    }
    CHECK(sum.value() == 0x1p30 + 1e6 * 0x1p-40);
    CHECK(naive == 0x1p30F);
}

TEST_CASE("film: any order and any split over films gives the same film", "[film]") {
    const Window window{3, 5, 20, 17};
    const std::vector<Aov> aovs = aovsNamed(kNames, "test");
    std::vector<Sample> samples = samplesOf(window, 6, 5);
    Film whole(window, aovs);
    for (const Sample &s : samples) add(whole, s);
    CHECK(whole.samples() == 6);
    CHECK(whole.meanSamples() == 6);
    std::mt19937 random(9);
    for (int round = 0; round < 8; ++round) {
        std::shuffle(samples.begin(), samples.end(), random);
        std::vector<Film> parts(5, Film(window, aovs));
        for (const Sample &s : samples) add(parts[random() % parts.size()], s);
        for (std::size_t i = 1; i < parts.size(); ++i) parts[0].merge(parts[i]);
        REQUIRE(parts[0] == whole);
    }
    // By pixels: stripes that grow into the whole.
    Film grown(Window{3, 5, 20, 9}, aovs);
    Film below(Window{3, 9, 20, 17}, aovs);
    for (const Sample &s : samples) add(s.y < 9 ? grown : below, s);
    grown.merge(below);
    CHECK(grown == whole);
    CHECK(grown.resolve() == whole.resolve());
    CHECK_THROWS_WITH(grown.merge(Film(window, {})), Catch::Contains("other AOVs"));
}

TEST_CASE("film: saved and restored it is the same; damaged it is refused", "[film]") {
    const Window window{0, 0, 33, 9};
    Film film(window, aovsNamed(kNames, "test"));
    for (const Sample &s : samplesOf(window, 3, 1)) add(film, s);
    std::ostringstream out;
    film.save(out);
    const std::string bytes = out.str();
    std::istringstream in(bytes);
    CHECK(Film::load(in) == film);
    const auto load = [](const std::string &text) {
        std::istringstream damaged(text);
        return Film::load(damaged);
    };
    for (const std::size_t length : {std::size_t{0}, std::size_t{5}, std::size_t{14}, std::size_t{30}, bytes.size() / 2, bytes.size() - 1})
        CHECK_THROWS_AS(load(bytes.substr(0, length)), InputError);
    std::string other = bytes;
    other[0] = 'T';
    CHECK_THROWS_WITH(load(other), Catch::Contains("found other bytes"));
    other = bytes;
    other.replace(other.find("depth"), 5, "dopth");
    CHECK_THROWS_WITH(load(other), Catch::Contains("did you mean 'depth'"));
    // A head that claims a million by a million pixels costs no memory before the bytes are missing.
    other = bytes;
    const std::size_t head = other.find("\n", 12) + 1;
    const std::int32_t huge = 1 << 20;
    for (const std::size_t at : {head + 8, head + 12}) std::memcpy(&other[at], &huge, 4);
    CHECK_THROWS_WITH(load(other), Catch::Contains("end early"));
}

TEST_CASE("film: a pixel that nothing reached is black, AOVs are means over hits", "[film]") {
    Film film(Window{0, 0, 2, 1}, aovsNamed(kNames, "test"));
    const float values[3] = {2, 4, 8};
    film.add(0, 0, Vec3(1, 2, 3), 1, values);
    film.add(0, 0, Vec3(0), 0, nullptr);
    CHECK(film.channelNames() == std::vector<std::string>{"R", "G", "B", "A", "Z", "u", "v"});
    CHECK(film.resolve() == std::vector<float>{0.5F, 1, 1.5F, 0.5F, 2, 4, 8, 0, 0, 0, 0, 0, 0, 0});
}

TEST_CASE("exact sums: one that was restored beyond half the limit goes on", "[film]") {
    ExactSum sum(0, 0x6666666666666666);
    sum.add(1.0F);
    CHECK(sum == ExactSum(0, 0x6666666666666667));
    ExactSum negative(0, -0x6666666666666666);
    negative.add(-1.0F);
    CHECK(negative == ExactSum(0, -0x6666666666666667));
}
