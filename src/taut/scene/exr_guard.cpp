#include "taut/scene/exr_guard.h"

#include "taut/base/error.h"
#include "taut/formats/raw_number.h"

#include <algorithm>
#include <vector>

namespace taut {

namespace {

constexpr std::size_t kHeaderStart = 8; ///< behind magic and version
constexpr std::uint32_t kTiled = 1U << 9U;
constexpr std::uint32_t kMultiPart = 1U << 12U;
constexpr std::size_t kLongestName = 255;

struct Box {
    std::int64_t x0 = 0, y0 = 0, x1 = -1, y1 = -1;
    [[nodiscard]] std::int64_t width() const { return x1 - x0 + 1; }
    [[nodiscard]] std::int64_t height() const { return y1 - y0 + 1; }
};

struct ExrPart {
    Box data, display;
    std::int64_t channels = 0;
    std::int64_t tileWidth = 0, tileHeight = 0; ///< 0: scan lines
    std::int64_t chunks = 0;
};

struct TypeSize {
    std::string_view type;
    std::size_t bytes;
};
/// Types that the library reads by their own size, whatever an attribute says.
constexpr TypeSize kTypeSizes[] = {{"box2i", 16}, {"box2f", 16}, {"chromaticities", 32}, {"compression", 1}, {"deepImageState", 1}, {"double", 8},
                                   {"envmap", 1}, {"float", 4},  {"int", 4},             {"keycode", 28},    {"lineOrder", 1},      {"m33f", 36},
                                   {"m33d", 72},  {"m44f", 64},  {"m44d", 128},          {"rational", 8},    {"tiledesc", 9},       {"timecode", 8},
                                   {"v2i", 8},    {"v2f", 8},    {"v2d", 16},            {"v3i", 12},        {"v3f", 12},           {"v3d", 24}};

std::int64_t wordOf(std::string_view value, std::size_t number) {
    return value.size() >= 4 * number + 4 ? rawNumber<std::int32_t>(value.data() + 4 * number) : 0;
}

/// Channels of a list, each a name, a zero and 16 bytes, to the zero at its end; -1 where that is not the value's end.
std::int64_t channelsOf(std::string_view value) {
    std::int64_t channels = 0;
    std::size_t at = 0;
    for (; at < value.size() && value[at] != '\0'; ++channels) {
        const std::size_t end = value.find('\0', at);
        if (end == std::string_view::npos) return -1;
        at = end + 1 + 16;
    }
    return at + 1 == value.size() ? channels : -1;
}

/// Whether a value ends where the library, which reads it by its type, will end.
bool hasItsSize(std::string_view type, std::string_view value) {
    for (const TypeSize &known : kTypeSizes)
        if (known.type == type) return value.size() == known.bytes;
    if (type == "chlist") return channelsOf(value) >= 0;
    if (type == "preview") {
        const double texels = static_cast<double>(static_cast<std::uint32_t>(wordOf(value, 0))) * static_cast<std::uint32_t>(wordOf(value, 1));
        return value.size() >= 8 && 8 + 4 * texels == static_cast<double>(value.size());
    }
    if (type == "stringvector")
        for (std::size_t at = 0; at < value.size();) {
            const std::int64_t length = wordOf(value.substr(at), 0);
            if (value.size() - at < 4 || length < 0 || static_cast<std::uint64_t>(length) > value.size() - at - 4) return false;
            at += 4 + static_cast<std::size_t>(length);
        }
    return true;
}

class HeaderWalk {
  public:
    explicit HeaderWalk(std::string_view bytes) : bytes_(bytes) {}

    std::vector<ExrPart> run() {
        if (bytes_.size() < kHeaderStart) return fail("the file ends within the OpenEXR header");
        const auto version = rawNumber<std::uint32_t>(bytes_.data() + 4);
        std::vector<ExrPart> parts;
        do {
            ExrPart part;
            bool any = false;
            while (damage.empty() && attribute(part)) any = true;
            if (!damage.empty()) return {};
            if (any) parts.push_back(part);
            if (!any || (version & kMultiPart) == 0) break;
        } while (at_ < bytes_.size());
        return parts;
    }

    std::string damage;

  private:
    std::vector<ExrPart> fail(const std::string &what) {
        damage = what;
        return {};
    }

    /// A name that ends in a zero; empty where there is none.
    std::string_view name() {
        const std::size_t end = bytes_.find('\0', at_);
        if (end == std::string_view::npos || end - at_ > kLongestName) {
            damage = "an OpenEXR header that ends within a name, or has one that is too long, at byte " + std::to_string(at_);
            return {};
        }
        const std::string_view text = bytes_.substr(at_, end - at_);
        at_ = end + 1;
        return text;
    }

    /// The next attribute; false at the end of a header.
    bool attribute(ExrPart &part) {
        const std::size_t start = at_;
        const std::string_view name = this->name();
        if (name.empty()) return false;
        const std::string_view type = this->name();
        if (!damage.empty()) return false;
        const std::int64_t size = bytes_.size() - at_ >= 4 ? rawNumber<std::int32_t>(bytes_.data() + at_) : -1;
        if (size < 0 || static_cast<std::uint64_t>(size) > bytes_.size() - at_ - 4) {
            damage = "an OpenEXR attribute of " + std::to_string(size) + " bytes at byte " + std::to_string(start) + ", which the file has not";
            return false;
        }
        const std::string_view value = bytes_.substr(at_ + 4, static_cast<std::size_t>(size));
        if (!hasItsSize(type, value)) {
            damage = "an OpenEXR attribute of type " + quoted(type) + " at byte " + std::to_string(start) + " that is not as long as its type";
            return false;
        }
        read(name, type, value, part);
        at_ += 4 + static_cast<std::size_t>(size);
        return true;
    }

    static void read(std::string_view name, std::string_view type, std::string_view value, ExrPart &part) {
        if (type == "box2i" && (name == "dataWindow" || name == "displayWindow")) {
            Box &box = name == "dataWindow" ? part.data : part.display;
            box = {wordOf(value, 0), wordOf(value, 1), wordOf(value, 2), wordOf(value, 3)};
        }
        if (type == "tiledesc") {
            part.tileWidth = static_cast<std::uint32_t>(wordOf(value, 0));
            part.tileHeight = static_cast<std::uint32_t>(wordOf(value, 1));
        }
        if (name == "chunkCount") part.chunks = wordOf(value, 0);
        if (type == "chlist") part.channels = channelsOf(value);
    }

    std::string_view bytes_;
    std::size_t at_ = kHeaderStart;
};

double product(std::int64_t a, std::int64_t b) {
    return static_cast<double>(a) * static_cast<double>(b);
}

} // namespace

std::string damageOfExr(std::string_view bytes) {
    HeaderWalk walk(bytes);
    const std::vector<ExrPart> parts = walk.run();
    if (!walk.damage.empty()) return walk.damage;
    for (const ExrPart &part : parts) {
        for (const Box &box : {part.data, part.display})
            if (box.width() < 1 || box.height() < 1) return "an OpenEXR window without a texel";
        // Every chunk takes eight bytes in the file's table of them.
        if (part.chunks < 0 || part.chunks > static_cast<std::int64_t>(bytes.size() / 8))
            return "an OpenEXR part of " + std::to_string(part.chunks) + " chunks, for which the file is too short";
    }
    return {};
}

AnnouncedSize sizeOfExr(std::string_view bytes) {
    constexpr double kBlockRows = 256; // of the compressions that pack most lines together
    constexpr double kBuffers = 3;     // of one block: packed, unpacked, as it is handed on
    AnnouncedSize size;
    HeaderWalk walk(bytes);
    for (const ExrPart &part : walk.run()) {
        if (product(part.data.width(), part.data.height()) >= static_cast<double>(size.width) * static_cast<double>(size.height)) {
            size.width = part.data.width();
            size.height = part.data.height();
        }
        size.channels = std::max(size.channels, std::min<std::int64_t>(part.channels, 4));
        const auto rows = std::min(kBlockRows, static_cast<double>(part.data.height()));
        const double tile = product(part.tileWidth, part.tileHeight);
        const double tiles = tile > 0 ? product(part.data.width(), part.data.height()) / tile : 0;
        const double block = tile > 0 ? std::max(tile, static_cast<double>(part.data.width()) * static_cast<double>(part.tileHeight))
                                      : static_cast<double>(part.data.width()) * rows;
        const double pyramid = 8 * (tiles + static_cast<double>(part.data.height())); // tables of chunks
        size.decoder += 4 * kBuffers * block * static_cast<double>(part.channels) + pyramid;
    }
    return size;
}

} // namespace taut
