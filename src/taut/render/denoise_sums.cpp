#include "taut/render/denoise_sums.h"

#include "taut/base/error.h"

#include <algorithm>
#include <cmath>
#include <istream>
#include <ostream>

namespace taut {

namespace {

/// Beyond that a feature is held: 2^24 samples of it are far from the end of 64 bits.
constexpr double kMostFeature = 16384;
/// The most of a number that is packed: ten times seven bits.
constexpr unsigned kLongestShift = 70;
const char *const kEndsEarly = "film: found its end early, expected as many sums for denoising as it has pixels";

/// Rounded by itself, so that the order does not matter; what is not finite adds nothing.
std::int64_t fixed(double value) {
    if (!std::isfinite(value)) return 0;
    return std::llrint(std::clamp(value, -kMostFeature, kMostFeature) / DenoiseSums::kUnit);
}

/// Sums of a damaged file may be anything: they wrap.
void addTo(std::int64_t &sum, std::int64_t value) {
    sum = static_cast<std::int64_t>(static_cast<std::uint64_t>(sum) + static_cast<std::uint64_t>(value));
}

/// Seven bits a byte, the least first.
void put(std::string &out, std::uint64_t value) {
    for (; value >= 0x80U; value >>= 7U) out.push_back(static_cast<char>(value | 0x80U));
    out.push_back(static_cast<char>(value));
}
/// Small numbers of either sign are short.
void putSigned(std::string &out, std::int64_t value) {
    put(out, (static_cast<std::uint64_t>(value) << 1U) ^ static_cast<std::uint64_t>(value >> 63));
}

std::uint64_t get(std::streambuf &in) {
    std::uint64_t value = 0;
    for (unsigned shift = 0; shift < kLongestShift; shift += 7) {
        const auto c = in.sbumpc();
        if (c == std::istream::traits_type::eof()) throw InputError(kEndsEarly);
        const auto byte = static_cast<std::uint64_t>(static_cast<unsigned char>(c));
        if (shift < 64) value |= (byte & 0x7fU) << shift;
        if (byte < 0x80U) return value;
    }
    throw InputError("film: found a sum for denoising that is none");
}
std::int64_t getSigned(std::streambuf &in) {
    const std::uint64_t value = get(in);
    return static_cast<std::int64_t>(value >> 1U) ^ -static_cast<std::int64_t>(value & 1U);
}
std::uint32_t getCount(std::streambuf &in) {
    const std::uint64_t value = get(in);
    if (value > 0xffffffffU) throw InputError("film: found counts for denoising that are none");
    return static_cast<std::uint32_t>(value);
}

} // namespace

DenoiseSums::DenoiseSums(const Window &window, int block) : window_(window), block_(std::max(1, block)) {
    if (!window.empty()) pixels_.resize(static_cast<std::size_t>(window.width()) * static_cast<std::size_t>(window.height()));
}

void DenoiseSums::add(int x, int y, std::uint32_t sample, const Vec3 &radiance, const float *features, bool motionKnown) {
    Pixel &pixel = pixels_[pixelAt(x, y)];
    const bool second = inSecondHalf(x, y, sample);
    pixel.second += second ? 1 : 0;
    for (int c = 0; c < 3; ++c) {
        const auto i = static_cast<std::size_t>(c);
        if (second) pixel.half[i].add(radiance[c]);
        pixel.squares[i].add(radiance[c] * radiance[c]);
    }
    if (!tellsFeatures(sample)) return;
    ++pixel.told;
    if (features == nullptr) return;
    ++pixel.hits;
    pixel.moving += motionKnown ? 1 : 0;
    const std::size_t known = motionKnown ? kDenoiseFeatures : kMotion;
    for (std::size_t i = 0; i < known; ++i) {
        addTo(pixel.features[i], fixed(static_cast<double>(features[i])));
        if (i < kSquared) addTo(pixel.featureSquares[i], fixed(static_cast<double>(features[i]) * static_cast<double>(features[i])));
    }
}

void DenoiseSums::merge(const DenoiseSums &other) {
    if (other.block_ != block_)
        throw InputError("film: found sums for denoising in blocks of " + std::to_string(other.block_) + " samples, expected blocks of " +
                         std::to_string(block_));
    for (int y = other.window_.y0; y < other.window_.y1; ++y)
        for (int x = other.window_.x0; x < other.window_.x1; ++x) {
            const Pixel &from = other.at(x, y);
            Pixel &to = pixels_[pixelAt(x, y)];
            to.second += from.second;
            to.told += from.told;
            to.hits += from.hits;
            to.moving += from.moving;
            for (std::size_t c = 0; c < 3; ++c) {
                to.half[c].add(from.half[c]);
                to.squares[c].add(from.squares[c]);
            }
            for (std::size_t i = 0; i < kDenoiseFeatures; ++i) addTo(to.features[i], from.features[i]);
            for (std::size_t i = 0; i < kSquared; ++i) addTo(to.featureSquares[i], from.featureSquares[i]);
        }
}

void DenoiseSums::copy(const DenoiseSums &from, const Window &part) {
    for (int y = part.y0; y < part.y1; ++y)
        std::copy_n(&from.pixels_[from.pixelAt(part.x0, y)], part.width(), &pixels_[pixelAt(part.x0, y)]);
}

void DenoiseSums::save(std::ostream &out) const {
    std::string bytes;
    put(bytes, static_cast<std::uint64_t>(block_));
    for (const Pixel &pixel : pixels_) {
        for (const std::uint32_t count : {pixel.second, pixel.told, pixel.hits, pixel.moving}) put(bytes, count);
        for (const auto *sums : {&pixel.half, &pixel.squares})
            for (const ExactSum &sum : *sums) {
                put(bytes, sum.low());
                putSigned(bytes, sum.high());
            }
        for (const std::int64_t sum : pixel.features) putSigned(bytes, sum);
        for (const std::int64_t sum : pixel.featureSquares) putSigned(bytes, sum);
        if (bytes.size() < (1U << 16U) && &pixel != &pixels_.back()) continue;
        out.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
        bytes.clear();
    }
    out.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
}

DenoiseSums DenoiseSums::load(std::istream &in, const Window &window) {
    std::streambuf &buffer = *in.rdbuf();
    const std::uint64_t block = get(buffer);
    if (block < 1 || block > (1U << 30U)) throw InputError("film: found blocks for denoising that are none");
    DenoiseSums sums({}, static_cast<int>(block));
    sums.window_ = window;
    const auto pixels = static_cast<std::size_t>(std::max(0, window.width())) * static_cast<std::size_t>(std::max(0, window.height()));
    for (std::size_t i = 0; i < pixels; ++i) { // grows by what is read: no head asks for more memory than its file is worth
        Pixel &pixel = sums.pixels_.emplace_back();
        for (std::uint32_t *count : {&pixel.second, &pixel.told, &pixel.hits, &pixel.moving}) *count = getCount(buffer);
        for (auto *values : {&pixel.half, &pixel.squares})
            for (ExactSum &sum : *values) {
                const std::uint64_t low = get(buffer);
                sum = ExactSum(low, getSigned(buffer));
            }
        for (std::int64_t &sum : pixel.features) sum = getSigned(buffer);
        for (std::int64_t &sum : pixel.featureSquares) sum = getSigned(buffer);
    }
    return sums;
}

} // namespace taut
