#include "taut/scene/tiff_guard.h"

#include <cstdint>
#include <optional>

namespace taut {

namespace {

constexpr std::uint64_t kStripOffsets = 273;
constexpr std::uint64_t kStripByteCounts = 279;
constexpr std::uint64_t kTileOffsets = 324;
constexpr std::uint64_t kTileByteCounts = 325;
constexpr std::uint64_t kShort = 3;
constexpr std::uint64_t kLong = 4;

class TiffBytes {
  public:
    explicit TiffBytes(std::string_view bytes) : bytes_(bytes), bigEndian_(bytes[0] == 'M') {}

    /// An unsigned number of `size` bytes; nothing where it lies outside the file.
    [[nodiscard]] std::optional<std::uint64_t> number(std::uint64_t at, std::uint64_t size) const {
        if (at > bytes_.size() || size > bytes_.size() - at) return std::nullopt;
        std::uint64_t value = 0;
        for (std::uint64_t i = 0; i < size; ++i)
            value = value << 8U | static_cast<unsigned char>(bytes_[at + (bigEndian_ ? i : size - 1 - i)]);
        return value;
    }
    [[nodiscard]] std::uint64_t size() const { return bytes_.size(); }

  private:
    std::string_view bytes_;
    bool bigEndian_;
};

/// The numbers of one entry of a directory: in place where they fit into four bytes.
struct Field {
    std::uint64_t size = 0; ///< of one number; 0: no such entry
    std::uint64_t count = 0;
    std::uint64_t at = 0;
    [[nodiscard]] std::optional<std::uint64_t> value(const TiffBytes &tiff, std::uint64_t i) const {
        return tiff.number(at + i * size, size);
    }
};

} // namespace

std::string damageOfTiff(std::string_view bytes) {
    if (bytes.size() < 8) return "the file ends within the TIFF header";
    const TiffBytes tiff(bytes);
    const std::uint64_t directory = *tiff.number(4, 4);
    const auto entries = tiff.number(directory, 2);
    Field offsets;
    Field lengths;
    for (std::uint64_t i = 0; entries && i < *entries; ++i) {
        const std::uint64_t entry = directory + 2 + 12 * i;
        const auto tag = tiff.number(entry, 2);
        const auto type = tiff.number(entry + 2, 2);
        const auto count = tiff.number(entry + 4, 4);
        const auto place = tiff.number(entry + 8, 4);
        if (!place) return "the file ends within its TIFF directory";
        if (*type != kShort && *type != kLong) continue;
        const std::uint64_t size = *type == kShort ? 2 : 4;
        const Field field{size, *count, *count * size <= 4 ? entry + 8 : *place};
        if (*tag == kStripOffsets || *tag == kTileOffsets) offsets = field;
        if (*tag == kStripByteCounts || *tag == kTileByteCounts) lengths = field;
    }
    if (!entries) return "the TIFF directory lies outside the file";
    for (std::uint64_t i = 0; i < offsets.count && i < lengths.count; ++i) {
        const auto offset = offsets.value(tiff, i);
        const auto length = lengths.value(tiff, i);
        if (!offset || !length) return "the file ends within the table of TIFF strips";
        if (*offset > tiff.size() || *length > tiff.size() - *offset)
            return "the file ends before TIFF strip or tile " + std::to_string(i) + " of " + std::to_string(offsets.count);
    }
    return {};
}

} // namespace taut
