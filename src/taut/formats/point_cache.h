#pragma once
/// Point caches: the positions of one mesh at many times, in the order of its points, streamed time by time.
///
/// PC2 (3ds Max): little-endian; a header of 32 bytes ("POINTCACHE2\0", int32 version 1, int32 points, float32 first frame,
/// float32 frames between samples, int32 samples), then per sample points x 3 float32.
/// MDD (LightWave): big-endian; int32 samples, int32 points, float32 time of each sample in seconds, then as above.
///
/// Neither names a unit or an axis: Taut writes metres, and the space is the caller's.

#include "taut/base/vec.h"
#include "taut/base/file_bytes.h"

#include <cstdint>
#include <fstream>
#include <span>
#include <string>
#include <vector>

namespace taut {

enum class PointCacheFormat { Pc2, Mdd };

struct PointCacheInfo {
    PointCacheFormat format = PointCacheFormat::Pc2;
    std::uint32_t points = 0;
    std::uint32_t samples = 0;
    float firstFrame = 1;         ///< PC2: the frame of sample 0
    float frameStep = 1;          ///< PC2: frames from a sample to the next, > 0
    std::vector<float> seconds{}; ///< MDD: [samples], increasing

    /// Where on the samples a frame lies: 0 at the first, samples - 1 at the last, fractional between, held outside.
    /// MDD: frame f is at (f - 1) / fps seconds.
    [[nodiscard]] double sampleAtFrame(double frame, double fps) const;
};

/// True for .pc2 and .mdd, in any case.
bool isPointCachePath(const std::string &path);

/// Reads one sample at a time; holds no more than the header.
class PointCacheReader {
  public:
    /// Reads and checks the header against the file's length. Throws InputError (byte offset) where it is malformed.
    explicit PointCacheReader(const std::string &path);

    [[nodiscard]] const PointCacheInfo &info() const { return info_; }
    /// Positions of one sample, [points]. Throws InputError where a coordinate is not finite or the file has become shorter.
    void read(std::uint32_t sample, std::vector<Vec3> &out);

  private:
    void readPc2Header();
    void readMddHeader();
    [[nodiscard]] std::uint32_t word(std::uint64_t offset);
    void checkSize(std::uint64_t headerBytes);

    std::string path_;
    std::ifstream file_;
    std::uint64_t size_ = 0;
    std::uint64_t dataStart_ = 0;
    PointCacheInfo info_;
};

/// Writes beside `path` and renames at finish(). Throws RunError.
class PointCacheWriter {
  public:
    /// `info.samples` is how many write() calls follow; MDD needs `info.seconds`.
    PointCacheWriter(const std::string &path, PointCacheInfo info);
    /// The next sample; [info.points].
    void write(std::span<const Vec3> positions);
    void finish();

  private:
    OutputFile out_;
    PointCacheInfo info_;
    std::uint32_t written_ = 0;
    std::string block_;
};

} // namespace taut
