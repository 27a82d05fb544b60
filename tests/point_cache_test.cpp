/// PC2 and MDD: bytes as their formats ask, values back as they were, malformed files named.

#include "assets.h"
#include "command.h"

#include "taut/base/error.h"
#include "taut/formats/point_cache.h"

#include <cstring>

using namespace taut;
using namespace taut::test;

namespace {

/// Awkward floats, other ones at each sample.
std::vector<Vec3> pointsOfSample(std::uint32_t points, std::uint32_t sample) {
    std::vector<Vec3> out;
    for (std::uint32_t i = 0; i < points; ++i) {
        const float f = static_cast<float>(i) + 0.1F * static_cast<float>(sample);
        out.emplace_back(f, -f / 3, 1e-30F * f);
    }
    return out;
}

std::string writeCache(const std::string &path, PointCacheInfo info) {
    PointCacheWriter writer(path, info);
    for (std::uint32_t s = 0; s < info.samples; ++s) writer.write(pointsOfSample(info.points, s));
    writer.finish();
    return readBytes(path);
}

PointCacheInfo pc2Info() {
    return {PointCacheFormat::Pc2, 5, 3, 10, 2, {}};
}
PointCacheInfo mddInfo() {
    return {PointCacheFormat::Mdd, 5, 3, 1, 1, {0.0F, 0.25F, 1.0F}};
}

/// The one line that reading all of a file gives; empty where it is fine.
std::string complaint(const std::string &path, const std::string &bytes) {
    std::ofstream(path, std::ios::binary) << bytes;
    try {
        PointCacheReader reader(path);
        std::vector<Vec3> points;
        for (std::uint32_t s = 0; s < reader.info().samples; ++s) reader.read(s, points);
        return "";
    } catch (const InputError &error) {
        return error.what();
    }
}

std::string with(std::string bytes, std::size_t offset, const std::string &replacement) {
    return bytes.replace(offset, replacement.size(), replacement);
}

} // namespace

TEST_CASE("point caches: the bytes are those of the formats", "[point_cache]") {
    const std::string folder = outputFolder("point_cache");
    const std::string pc2 = writeCache(folder + "/bytes.pc2", {PointCacheFormat::Pc2, 1, 1, 1, 0.5F, {}});
    // f = 0 at point 0 of sample 0: x = 0, y = -0, z = 0.
    const std::string expected("POINTCACHE2\0\1\0\0\0\1\0\0\0\0\0\x80\x3f\0\0\0\x3f\1\0\0\0\0\0\0\0\0\0\0\x80\0\0\0\0", 44);
    CHECK(pc2 == expected);
    const std::string mdd = writeCache(folder + "/bytes.mdd", {PointCacheFormat::Mdd, 1, 2, 1, 1, {0, 0.5F}});
    CHECK(mdd.substr(0, 28) == std::string("\0\0\0\2\0\0\0\1\0\0\0\0\x3f\0\0\0\0\0\0\0\x80\0\0\0\0\0\0\0", 28));
    CHECK(mdd.substr(28, 4) == "\x3d\xcc\xcc\xcd"); // 0.1
    CHECK(mdd.size() == 40);
}

TEST_CASE("point caches: every value comes back as it was, in any order of samples", "[point_cache]") {
    const std::string folder = outputFolder("point_cache");
    for (const PointCacheInfo &info : {pc2Info(), mddInfo()}) {
        const std::string path = folder + (info.format == PointCacheFormat::Pc2 ? "/trip.pc2" : "/trip.MDD");
        writeCache(path, info);
        PointCacheReader reader(path);
        CHECK(isPointCachePath(path));
        CHECK(reader.info().points == 5);
        CHECK(reader.info().samples == 3);
        CHECK(reader.info().firstFrame == info.firstFrame);
        CHECK(reader.info().frameStep == info.frameStep);
        CHECK(reader.info().seconds == info.seconds);
        std::vector<Vec3> points;
        for (const std::uint32_t s : {2U, 0U, 1U, 2U}) {
            reader.read(s, points);
            CHECK(points == pointsOfSample(5, s));
        }
    }
    CHECK_FALSE(isPointCachePath("a.obj"));
}

TEST_CASE("point caches: frames lie on samples", "[point_cache]") {
    CHECK(pc2Info().sampleAtFrame(10, 24) == 0);
    CHECK(pc2Info().sampleAtFrame(13, 24) == 1.5);
    CHECK(pc2Info().sampleAtFrame(-3, 24) == 0);
    CHECK(pc2Info().sampleAtFrame(99, 24) == 2);
    CHECK(mddInfo().sampleAtFrame(1, 24) == 0);
    CHECK(mddInfo().sampleAtFrame(7, 24) == 1);    // 0.25 s
    CHECK(mddInfo().sampleAtFrame(16, 24) == 1.5); // 0.625 s, half way from 0.25 to 1
    CHECK(mddInfo().sampleAtFrame(0, 24) == 0);
    CHECK(mddInfo().sampleAtFrame(25, 24) == 2);
}

TEST_CASE("point caches: a malformed file is one line with its byte", "[point_cache]") {
    const std::string folder = outputFolder("point_cache");
    const std::string nan("\0\0\xc0\x7f", 4);
    const std::string zero(4, '\0');
    const std::string minus(4, '\xff');
    const std::string bad = folder + "/bad.pc2";
    const std::string good = writeCache(folder + "/good.pc2", pc2Info());
    CHECK(complaint(bad, good).empty());
    const std::vector<std::pair<std::string, std::string>> pc2{{"", "POINTCACHE2"},
                                                               {with(good, 0, "POINTCACHE3"), "byte 0"},
                                                               {with(good, 12, "\2"), "version 2"},
                                                               {with(good, 16, zero), "0 points"},
                                                               {with(good, 16, minus), "-1 points"},
                                                               {with(good, 20, nan), "first frame"},
                                                               {with(good, 24, zero), "sample rate"},
                                                               {with(good, 24, nan), "sample rate"},
                                                               {with(good, 28, minus), "-1 samples"},
                                                               {with(good, 28, "\4"), "4 samples"},
                                                               {good.substr(0, good.size() - 1), "bytes"},
                                                               {good + "x", "bytes"},
                                                               {good.substr(0, 30), "header"},
                                                               {with(good, 32 + 12, nan), "byte 44"}};
    for (const auto &[bytes, says] : pc2) {
        const std::string line = complaint(bad, bytes);
        INFO(line);
        CHECK(line.find(bad) == 0);
        CHECK(line.find(says) != std::string::npos);
        CHECK(line.find('\n') == std::string::npos);
    }
    const std::string badMdd = folder + "/bad.mdd";
    const std::string goodMdd = writeCache(folder + "/good.mdd", mddInfo());
    CHECK(complaint(badMdd, goodMdd).empty());
    const std::vector<std::pair<std::string, std::string>> mdd{{"", "header"},
                                                               {with(goodMdd, 0, zero), "0 samples"},
                                                               {with(goodMdd, 4, minus), "-1 points"},
                                                               {with(goodMdd, 8 + 4, zero), "byte 12"}, // time 0 again
                                                               {with(goodMdd, 8 + 8, std::string("\x7f\xc0\0\0", 4)), "byte 16"}, // nan
                                                               {goodMdd.substr(0, 40), "bytes"},
                                                               {with(goodMdd, 20, std::string("\x7f\x80\0\0", 4)), "byte 20"}}; // inf
    for (const auto &[bytes, says] : mdd) {
        const std::string line = complaint(badMdd, bytes);
        INFO(line);
        CHECK(line.find(badMdd) == 0);
        CHECK(line.find(says) != std::string::npos);
    }
    CHECK_THROWS_AS(PointCacheReader(folder + "/missing.pc2"), InputError);
    CHECK_THROWS_AS(PointCacheReader(folder), InputError);
}

TEST_CASE("point caches: every cut of a file is refused, nothing crashes on flipped bits", "[point_cache]") {
    const std::string folder = outputFolder("point_cache");
    for (const PointCacheInfo &info : {pc2Info(), mddInfo()}) {
        const std::string path = folder + (info.format == PointCacheFormat::Pc2 ? "/cut.pc2" : "/cut.mdd");
        const std::string good = writeCache(path, info);
        for (std::size_t size = 0; size < good.size(); ++size) CHECK_FALSE(complaint(path, good.substr(0, size)).empty());
        for (std::size_t i = 0; i < good.size(); ++i) {
            std::string bytes = good;
            bytes[i] = static_cast<char>(bytes[i] ^ 0x80);
            complaint(path, bytes);
        }
    }
}

TEST_CASE("point caches: a writer that is not finished leaves nothing", "[point_cache]") {
    const std::string folder = outputFolder("point_cache_unfinished");
    const std::string path = folder + "/unfinished.pc2";
    {
        PointCacheWriter writer(path, pc2Info());
        writer.write(pointsOfSample(5, 0));
        CHECK_FALSE(fs::is_empty(folder));
        CHECK_FALSE(fs::exists(path));
        CHECK_THROWS_AS(writer.write(pointsOfSample(4, 0)), RunError);
        CHECK_THROWS_AS(writer.finish(), RunError);
    }
    CHECK(fs::is_empty(folder));
    CHECK_THROWS_AS(PointCacheWriter("/proc/nowhere/a.pc2", pc2Info()), RunError);
}
