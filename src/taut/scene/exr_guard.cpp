#include "taut/scene/exr_guard.h"

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
    std::int64_t preview = 0; ///< texels
};

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
        read(name, type, bytes_.substr(at_ + 4, static_cast<std::size_t>(size)), part);
        at_ += 4 + static_cast<std::size_t>(size);
        return true;
    }

    static std::int64_t wordOf(std::string_view value, std::size_t number) {
        return value.size() >= 4 * number + 4 ? rawNumber<std::int32_t>(value.data() + 4 * number) : 0;
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
        if (type == "preview") part.preview = static_cast<std::int64_t>(static_cast<std::uint32_t>(wordOf(value, 0))) * static_cast<std::uint32_t>(wordOf(value, 1));
        if (type != "chlist") return;
        // A name, a zero, 16 bytes; at the end a zero.
        for (std::size_t at = 0; at < value.size() && value[at] != '\0'; ++part.channels) {
            const std::size_t end = value.find('\0', at);
            if (end == std::string_view::npos) break;
            at = end + 1 + 16;
        }
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
        if (4 * part.preview > static_cast<std::int64_t>(bytes.size())) return "an OpenEXR preview that is larger than the file";
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
