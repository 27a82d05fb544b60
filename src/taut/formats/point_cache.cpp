#include "taut/formats/point_cache.h"

#include "taut/base/error.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <filesystem>
#include <limits>

namespace taut {

namespace {

constexpr std::string_view kMagic("POINTCACHE2\0", 12);
constexpr std::uint64_t kPc2Header = 32;
constexpr std::size_t kBlockFloats = 1 << 16;

static_assert(std::endian::native == std::endian::little);

std::uint32_t swapped(std::uint32_t x) {
    return x >> 24 | (x >> 8 & 0xff00U) | (x << 8 & 0xff0000U) | x << 24;
}

void append(std::string &out, std::uint32_t word) {
    char raw[4];
    std::memcpy(raw, &word, 4);
    out.append(raw, 4);
}

PointCacheFormat formatOf(const std::string &path) {
    return lowerExtension(path) == "mdd" ? PointCacheFormat::Mdd : PointCacheFormat::Pc2;
}

/// A count stored as int32.
std::uint32_t checkedCount(const std::string &path, std::uint64_t offset, std::uint32_t stored, const char *what) {
    if (stored == 0 || stored > 0x7fffffffU)
        failInput({path, 0, 0, static_cast<std::int64_t>(offset)}, std::to_string(static_cast<std::int32_t>(stored)) + " " + what,
                  "a count of at least 1");
    return stored;
}

} // namespace

bool isPointCachePath(const std::string &path) {
    const std::string extension = lowerExtension(path);
    return extension == "pc2" || extension == "mdd";
}

double PointCacheInfo::sampleAtFrame(double frame, double fps) const {
    const double last = samples - 1.0;
    if (format == PointCacheFormat::Pc2)
        return std::clamp((frame - static_cast<double>(firstFrame)) / static_cast<double>(frameStep), 0.0, last);
    const double time = (frame - 1) / fps;
    const auto next = std::upper_bound(seconds.begin(), seconds.end(), time, [](double t, float s) { return t < static_cast<double>(s); });
    if (next == seconds.begin()) return 0;
    if (next == seconds.end()) return last;
    const double t0 = static_cast<double>(*(next - 1));
    const double t1 = static_cast<double>(*next);
    return static_cast<double>(next - seconds.begin() - 1) + (time - t0) / (t1 - t0);
}

PointCacheReader::PointCacheReader(const std::string &path) : path_(path) {
    std::error_code error;
    const auto status = std::filesystem::status(path, error);
    if (!std::filesystem::exists(status)) throw InputError(path + ": found no such file, expected a point cache");
    if (!std::filesystem::is_regular_file(status)) throw InputError(path + ": found something that is not a file, expected a point cache");
    size_ = std::filesystem::file_size(path, error);
    file_.open(path, std::ios::binary);
    if (error || !file_) throw InputError(path + ": found a file that cannot be opened, expected a point cache");
    info_.format = formatOf(path);
    if (info_.format == PointCacheFormat::Pc2)
        readPc2Header();
    else
        readMddHeader();
}

std::uint32_t PointCacheReader::word(std::uint64_t offset) {
    std::uint32_t value = 0;
    file_.seekg(static_cast<std::streamoff>(offset));
    file_.read(reinterpret_cast<char *>(&value), sizeof value);
    if (!file_)
        failInput({path_, 0, 0, static_cast<std::int64_t>(std::min(offset, size_))}, "the end of the file", "a point cache's header");
    return info_.format == PointCacheFormat::Mdd ? swapped(value) : value;
}

void PointCacheReader::readPc2Header() {
    char magic[12] = {};
    file_.read(magic, sizeof magic);
    if (!file_ || std::string_view(magic, sizeof magic) != kMagic)
        failInput({path_, 0, 0, 0}, "a file that does not start with POINTCACHE2", "a PC2 point cache");
    if (const std::uint32_t version = word(12); version != 1)
        failInput({path_, 0, 0, 12}, "version " + std::to_string(version), "version 1");
    info_.points = checkedCount(path_, 16, word(16), "points");
    info_.firstFrame = std::bit_cast<float>(word(20));
    info_.frameStep = std::bit_cast<float>(word(24));
    info_.samples = checkedCount(path_, 28, word(28), "samples");
    if (!std::isfinite(info_.firstFrame)) failInput({path_, 0, 0, 20}, "a first frame that is not finite", "a frame number");
    if (!(info_.frameStep > 0) || !std::isfinite(info_.frameStep))
        failInput({path_, 0, 0, 24}, "a sample rate of " + std::to_string(info_.frameStep), "frames between samples, more than 0");
    checkSize(kPc2Header);
}

void PointCacheReader::readMddHeader() {
    info_.samples = checkedCount(path_, 0, word(0), "samples");
    info_.points = checkedCount(path_, 4, word(4), "points");
    checkSize(8 + 4 * std::uint64_t{info_.samples});
    for (std::uint32_t i = 0; i < info_.samples; ++i) {
        const std::uint64_t offset = 8 + 4 * std::uint64_t{i};
        const float time = std::bit_cast<float>(word(offset));
        if (!std::isfinite(time) || (i > 0 && !(time > info_.seconds.back())))
            failInput({path_, 0, 0, static_cast<std::int64_t>(offset)}, "time " + std::to_string(time), "finite times that increase");
        info_.seconds.push_back(time);
    }
}

void PointCacheReader::checkSize(std::uint64_t headerBytes) {
    const std::string counts = std::to_string(info_.points) + " points and " + std::to_string(info_.samples) + " samples";
    const std::uint64_t positions = std::uint64_t{info_.points} * info_.samples; // both below 2^31
    if (positions > (std::numeric_limits<std::uint64_t>::max() - headerBytes) / 12)
        failInput({path_, 0, 0, 0}, counts, "fewer points and samples, as many as a file can hold");
    const std::uint64_t expected = headerBytes + 12 * positions;
    if (size_ != expected)
        failInput({path_, 0, 0, static_cast<std::int64_t>(std::min(size_, expected))},
                  "a file of " + std::to_string(size_) + " bytes with " + counts,
                  std::to_string(expected) + " bytes");
    dataStart_ = headerBytes;
}

void PointCacheReader::read(std::uint32_t sample, std::vector<Vec3> &out) {
    out.resize(info_.points);
    const std::uint64_t start = dataStart_ + 12 * std::uint64_t{info_.points} * sample;
    file_.clear();
    file_.seekg(static_cast<std::streamoff>(start));
    file_.read(reinterpret_cast<char *>(out.data()), static_cast<std::streamsize>(out.size() * sizeof(Vec3)));
    if (!file_) failInput({path_, 0, 0, static_cast<std::int64_t>(start)}, "the end of the file", "sample " + std::to_string(sample));
    for (std::size_t i = 0; i < out.size(); ++i) {
        if (info_.format == PointCacheFormat::Mdd)
            for (int c = 0; c < 3; ++c) out[i][c] = std::bit_cast<float>(swapped(std::bit_cast<std::uint32_t>(out[i][c])));
        if (!isFinite(out[i]))
            failInput({path_, 0, 0, static_cast<std::int64_t>(start + 12 * i)}, "a position that is not finite", "finite coordinates");
    }
}

PointCacheWriter::PointCacheWriter(const std::string &path, PointCacheInfo info) : out_(path), info_(std::move(info)) {
    std::string header;
    if (info_.format == PointCacheFormat::Pc2) {
        header = kMagic;
        for (const std::uint32_t field : {std::uint32_t{1}, info_.points, std::bit_cast<std::uint32_t>(info_.firstFrame),
                                          std::bit_cast<std::uint32_t>(info_.frameStep), info_.samples})
            append(header, field);
    } else {
        if (info_.seconds.size() != info_.samples) throw RunError(path + ": an MDD cache needs the time of every sample");
        append(header, swapped(info_.samples));
        append(header, swapped(info_.points));
        for (const float time : info_.seconds) append(header, swapped(std::bit_cast<std::uint32_t>(time)));
    }
    out_.write(header);
}

void PointCacheWriter::write(std::span<const Vec3> positions) {
    if (positions.size() != info_.points || written_ == info_.samples)
        throw RunError("a point cache of " + std::to_string(info_.samples) + " samples of " + std::to_string(info_.points) +
                       " points was given another");
    ++written_;
    if (info_.format == PointCacheFormat::Pc2) {
        out_.write(positions.data(), positions.size_bytes());
        return;
    }
    const auto *floats = reinterpret_cast<const float *>(positions.data());
    for (std::size_t i = 0; i < 3 * positions.size(); i += kBlockFloats) {
        const std::size_t count = std::min(kBlockFloats, 3 * positions.size() - i);
        block_.resize(4 * count);
        for (std::size_t k = 0; k < count; ++k) {
            const std::uint32_t big = swapped(std::bit_cast<std::uint32_t>(floats[i + k]));
            std::memcpy(block_.data() + 4 * k, &big, 4);
        }
        out_.write(block_);
    }
}

void PointCacheWriter::finish() {
    if (written_ != info_.samples)
        throw RunError("a point cache of " + std::to_string(info_.samples) + " samples was given " + std::to_string(written_));
    out_.finish();
}

} // namespace taut
