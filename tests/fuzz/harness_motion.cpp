/// Point caches by way of a file, frame sets and numbered paths.

#include "harness.h"
#include "harness_list.h"

#include "mesh_samples.h"

#include "taut/base/frame_set.h"
#include "taut/formats/point_cache.h"
#include "taut/formats/point_files.h"

#include <set>

namespace taut::fuzz {

namespace {

void readCache(const std::string &name, std::string_view bytes) {
    const std::string path = scratchFile(name, bytes);
    survive([&] {
        PointCacheReader reader(path);
        const PointCacheInfo &info = reader.info();
        std::vector<Vec3> points;
        for (const std::uint32_t sample : {0U, info.samples - 1}) {
            reader.read(sample, points);
            require(points.size() == info.points, "a sample has the header's points");
        }
        for (const double frame : {-1e9, 1.0, 2.5, 1e9}) {
            const double at = info.sampleAtFrame(frame, 24);
            require(at >= 0 && at <= info.samples - 1.0, "a frame is held within the samples");
        }
        const auto source = cachePoints(path);
        const auto open = source->open();
        for (const double frame : {1.0, 2.5}) require(open->at(frame, 24).size() == info.points, "a frame has the header's points");
    });
}

std::string cache(PointCacheFormat format) {
    PointCacheInfo info;
    info.format = format;
    info.points = 4;
    info.samples = 3;
    info.seconds = {0, 0.5F, 1};
    const std::string path = scratchFolder() + (format == PointCacheFormat::Pc2 ? "/seed.pc2" : "/seed.mdd");
    PointCacheWriter writer(path, info);
    for (int sample = 0; sample < 3; ++sample) {
        const Vec3 points[4] = {Vec3(0), Vec3(1, 0, 0), Vec3(1, 1, 0), Vec3(0, 1, static_cast<float>(sample))};
        writer.write(points);
    }
    writer.finish();
    return readFileBytes(path);
}

} // namespace

void runPc2(std::string_view bytes) {
    readCache("fuzz.pc2", bytes);
}
void runMdd(std::string_view bytes) {
    readCache("fuzz.mdd", bytes);
}

/// The first line is a set of frames, the second a path with a pattern.
void runFrames(std::string_view bytes) {
    const std::size_t line = bytes.find('\n');
    const std::string_view text = bytes.substr(0, line);
    const std::string_view pattern = line == std::string_view::npos ? "out/####.exr" : bytes.substr(line + 1);
    survive([&] {
        const std::vector<int> frames = parseFrameSet(text, {"--frames"});
        require(!frames.empty() && frames.size() <= 1'000'000, "a set has one frame to a million");
        const bool numbered = hasFramePattern(pattern);
        std::set<std::string> paths;
        constexpr std::size_t kLooked = 16;
        for (std::size_t i = 0; i < std::min(kLooked, frames.size()); ++i) {
            const std::string path = pathOfFrame(pattern, frames[i]);
            require(paths.insert(path).second || !numbered, "every frame has a path of its own");
            require(!numbered || frameOfPath(pattern, path) == frames[i], "a path leads back to its frame");
        }
    });
}

std::vector<std::string> pc2Seeds() {
    return {cache(PointCacheFormat::Pc2)};
}
std::vector<std::string> mddSeeds() {
    return {cache(PointCacheFormat::Mdd)};
}
std::vector<std::string> frameSeeds() {
    return {"1-48", "1-5,9", "1-100x5", "-3--1", "5-1\nmesh.%04d.obj", "1,2\nC#/img.###.png", "7\nout/################################.exr"};
}

} // namespace taut::fuzz
