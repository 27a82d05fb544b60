#include "taut/render/denoise_sums.h"

#include "taut/base/error.h"

#include <algorithm>
#include <cmath>
#include <istream>
#include <limits>
#include <ostream>

namespace taut {

namespace {

/// The most of a number that is packed: ten times seven bits.
constexpr unsigned kLongestShift = 70;
const char *const kEndsEarly = "film: found its end early, expected as many sums for denoising as it has pixels";

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
template <class T> T getCount(std::streambuf &in) {
    const std::uint64_t value = get(in);
    if (value > std::numeric_limits<T>::max()) throw InputError("film: found numbers for denoising that are none");
    return static_cast<T>(value);
}

void putFeatures(std::string &out, const PixelFeatures &features) {
    put(out, features.probes);
    if (features.probes == 0) return;
    for (const std::uint16_t value : {features.edge, features.covered, features.met, features.moving, features.noise[0], features.noise[1]})
        put(out, value);
    for (const std::uint16_t value : features.channels) put(out, value);
    for (const std::int32_t value : features.motion) putSigned(out, value);
}
void getFeatures(std::streambuf &in, PixelFeatures &features) {
    features.probes = getCount<std::uint16_t>(in);
    if (features.probes == 0) return;
    for (std::uint16_t *value :
         {&features.edge, &features.covered, &features.met, &features.moving, &features.noise[0], &features.noise[1]})
        *value = getCount<std::uint16_t>(in);
    for (std::uint16_t &value : features.channels) value = getCount<std::uint16_t>(in);
    for (std::int32_t &value : features.motion) value = static_cast<std::int32_t>(getSigned(in));
}

} // namespace

DenoiseSums::DenoiseSums(const Window &window, int block) : window_(window), block_(std::max(1, block)) {
    if (window.empty()) return;
    const std::size_t pixels = static_cast<std::size_t>(window.width()) * static_cast<std::size_t>(window.height());
    pixels_.resize(pixels);
    features_.resize(pixels);
}

void DenoiseSums::add(int x, int y, std::uint32_t sample, const Vec3 &radiance, bool covered) {
    Pixel &pixel = pixels_[pixelAt(x, y)];
    const bool isDark = radiance == Vec3(0); // nothing to add: most samples before nothing
    if (!isDark) pixel.squares.add(glm::dot(radiance, radiance));
    if (!inSecondHalf(x, y, sample)) return;
    ++pixel.second;
    pixel.covered += covered ? 1 : 0;
    if (isDark) return;
    for (int c = 0; c < 3; ++c) pixel.half[static_cast<std::size_t>(c)].add(radiance[c]);
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
            to.covered += from.covered;
            for (std::size_t c = 0; c < 3; ++c) to.half[c].add(from.half[c]);
            to.squares.add(from.squares);
            if (featuresAt(x, y).probes == 0) tell(x, y, other.featuresAt(x, y));
        }
}

void DenoiseSums::copy(const DenoiseSums &from, const Window &part) {
    for (int y = part.y0; y < part.y1; ++y) {
        const std::size_t source = from.pixelAt(part.x0, y);
        const std::size_t target = pixelAt(part.x0, y);
        std::copy_n(&from.pixels_[source], part.width(), &pixels_[target]);
        std::copy_n(&from.features_[source], part.width(), &features_[target]);
    }
}

void DenoiseSums::save(std::ostream &out) const {
    std::string bytes;
    put(bytes, static_cast<std::uint64_t>(block_));
    for (std::size_t i = 0; i < pixels_.size(); ++i) {
        const Pixel &pixel = pixels_[i];
        put(bytes, pixel.second);
        put(bytes, pixel.covered);
        for (const ExactSum &sum : {pixel.half[0], pixel.half[1], pixel.half[2], pixel.squares}) {
            put(bytes, sum.low());
            putSigned(bytes, sum.high());
        }
        putFeatures(bytes, features_[i]);
        if (bytes.size() < (1U << 16U) && i + 1 < pixels_.size()) continue;
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
        pixel.second = getCount<std::uint32_t>(buffer);
        pixel.covered = getCount<std::uint32_t>(buffer);
        for (ExactSum *sum : {&pixel.half[0], &pixel.half[1], &pixel.half[2], &pixel.squares}) {
            const std::uint64_t low = get(buffer);
            *sum = ExactSum(low, getSigned(buffer));
        }
        getFeatures(buffer, sums.features_.emplace_back());
    }
    return sums;
}

} // namespace taut
