/// Textures and radiance maps from image files, through OpenImageIO.

#include "taut/base/file_bytes.h"
#include "taut/base/parallel.h"
#include "taut/base/srgb.h"
#include "taut/formats/raw_number.h"
#include "taut/images/image_codec.h"
#include "taut/scene/exr_guard.h"
#include "taut/scene/image_channels.h"
#include "taut/scene/jpeg_guard.h"
#include "taut/scene/png_guard.h"
#include "taut/scene/texture.h"
#include "taut/scene/tiff_guard.h"
#include "taut/scene/webp_alpha.h"

#include <algorithm>
#include <limits>
#include <memory>
#include <optional>

namespace taut {

namespace {

using namespace std::string_view_literals;

constexpr int kMostTexelsPerSide = 32768;
constexpr std::int64_t kMostTexels = std::int64_t{1} << 28;
/// Floats below this many bytes are allocated on the header's word alone; above it the file must be long enough to hold the
/// image at this ratio, which no compression of these formats exceeds on pictures.
constexpr std::int64_t kTrustedBytes = std::int64_t{64} << 20;
constexpr std::int64_t kMostCompression = 65536;
constexpr std::string_view kFormatNames = "PNG, JPEG, OpenEXR, HDR, TIFF, WebP, TGA or BMP image";

enum class Encoding { Linear, Srgb, SrgbOfEightBits }; ///< of colours, where the file does not say

/// OpenImageIO 2.4 multiplies the sides of a BMP image as 32-bit integers before we see them (CVE-2023-42295): they are looked at here.
std::string damageOfBmp(std::string_view bytes) {
    constexpr std::size_t kCoreHeader = 12; // its sides have 16 bits
    if (bytes.size() < 26) return "the file ends within the BMP header";
    if (rawNumber<std::uint32_t>(bytes.data() + 14) == kCoreHeader) return {};
    const std::int64_t width = rawNumber<std::int32_t>(bytes.data() + 18);
    const std::int64_t height = rawNumber<std::int32_t>(bytes.data() + 22); // negative: rows from the top
    const bool fits = width >= 1 && width <= kMostTexelsPerSide && std::abs(height) >= 1 && std::abs(height) <= kMostTexelsPerSide &&
                      width * std::abs(height) <= kMostTexels;
    return fits ? "" : "a BMP image of " + std::to_string(width) + " x " + std::to_string(height) + " texels";
}

struct Format {
    std::string_view magic;
    const char *plugin; ///< OpenImageIO's name
    Encoding encoding;
    AnnouncedSize (*size)(std::string_view);           ///< what its header says
    std::string (*damage)(std::string_view) = nullptr; ///< what its decoder does not tell us
};
/// Told apart by their first bytes, never by trying one decoder after the other.
constexpr Format kFormats[] = {
    {"\x89PNG"sv, "png", Encoding::Srgb, sizeOfPng, damageOfPng},
    {"\xff\xd8\xff"sv, "jpeg", Encoding::Srgb, sizeOfJpeg, damageOfJpeg},
    {"\x76\x2f\x31\x01"sv, "openexr", Encoding::Linear, sizeOfExr, damageOfExr},
    {"#?"sv, "hdr", Encoding::Linear, sizeOfHdr},
    {"II*\0"sv, "tiff", Encoding::SrgbOfEightBits, sizeOfTiff, damageOfTiff},
    {"MM\0*"sv, "tiff", Encoding::SrgbOfEightBits, sizeOfTiff, damageOfTiff},
    {"RIFF"sv, "webp", Encoding::Srgb, sizeOfWebp},
    {"BM"sv, "bmp", Encoding::Srgb, sizeOfBmp, damageOfBmp},
};
/// Begins with no signature; its name, or the end of the file in version 2 (Truevision TGA, appendix C), says what it is.
constexpr Format kTga{""sv, "targa", Encoding::Srgb, sizeOfTga};
constexpr std::string_view kTgaEnd = "TRUEVISION-XFILE.\0"sv;

const Format *formatOf(const std::string &name, std::string_view bytes) {
    for (const Format &format : kFormats) {
        if (bytes.substr(0, format.magic.size()) != format.magic) continue;
        if (format.plugin == "webp"sv && bytes.substr(std::min<std::size_t>(8, bytes.size()), 4) != "WEBP") continue;
        return &format;
    }
    const std::string extension = lowerExtension(name);
    const bool ends = bytes.size() > kTgaEnd.size() && bytes.substr(bytes.size() - kTgaEnd.size()) == kTgaEnd;
    return !bytes.empty() && (ends || extension == "tga" || extension == "targa") ? &kTga : nullptr;
}

[[noreturn]] void failDecoding(const Location &where, std::string reason) {
    constexpr std::size_t kLongest = 200;
    while (!reason.empty() && std::isspace(static_cast<unsigned char>(reason.back())) != 0) reason.pop_back();
    if (reason.empty()) reason = "no reason given";
    failInput(where, "an image that can't be decoded (" + reason.substr(0, kLongest) + ")", "a complete " + std::string(kFormatNames));
}

/// `channels`: how many of them are held in memory.
void checkSize(std::int64_t width, std::int64_t height, std::int64_t channels, std::size_t fileBytes, const Location &where) {
    const std::string found =
        std::to_string(width) + " x " + std::to_string(height) + " texels of " + std::to_string(channels) + " channels";
    if (width < 1 || height < 1 || channels < 1) failInput(where, found, "a flat image with texels");
    const std::int64_t texels = std::max(width, height) > kMostTexelsPerSide ? kMostTexels + 1 : width * height;
    if (texels > kMostTexels || channels > 1024)
        failInput(where, found, "at most 32768 texels a side and 2^28 in all");
    const std::int64_t bytes = texels * channels * static_cast<std::int64_t>(sizeof(float));
    if (bytes > kTrustedBytes && bytes / kMostCompression > static_cast<std::int64_t>(fileBytes))
        failInput(where, found + " in " + std::to_string(fileBytes) + " bytes", "a file long enough to hold them");
}

/// Before a decoder looks: what the header says must be a size that we take, and fit into the budget with what the decoder needs. While
/// a picture is read there are two copies of its values.
void checkAnnounced(const Format &format, std::string_view bytes, const Location &where, const Budget &budget) {
    const AnnouncedSize size = format.size(bytes);
    if (size.width == 0 && size.height == 0) return;
    checkSize(size.width, size.height, std::clamp<std::int64_t>(size.channels, 1, 4), bytes.size(), where);
    const double values = static_cast<double>(size.width * size.height * std::clamp<std::int64_t>(size.channels, 3, 4));
    budget.require(2 * sizeof(float) * values + size.decoder, where.text(),
                   "an image of " + std::to_string(size.width) + " x " + std::to_string(size.height) + " texels");
}

/// A texture that is still being made.
struct Pixels {
    int width = 0, height = 0, channels = 0;
    std::vector<float> texels;
};

void decodeSrgb(Pixels &texture) {
    const int channels = texture.channels;
    const int colors = std::min(channels, 3); // the fourth is alpha, which is linear in every format
    parallelFor(texture.texels.size() / static_cast<std::size_t>(channels), 65536, [&](std::size_t i) {
        float *texel = &texture.texels[i * static_cast<std::size_t>(channels)];
        for (int c = 0; c < colors; ++c) texel[c] = linearFromSrgb(texel[c]);
    });
}

bool isSrgb(const ImagePart &part, const Format &format, const Location &where, Warnings &warnings) {
    if (format.plugin == "png"sv) { // its gAMA chunk, as OpenImageIO tells it
        const bool linear = part.isLinear || std::fabs(part.gamma - 1) < 0.01F;
        if (!linear && part.gamma > 0 && std::fabs(part.gamma - 2.2F) > 0.05F)
            warnings.add(where.text() + ": its gamma of " + formatNumber(static_cast<double>(part.gamma)) + " is taken as sRGB");
        return !linear;
    }
    return format.encoding == Encoding::Srgb || (format.encoding == Encoding::SrgbOfEightBits && part.isEightBits);
}

/// A rectangle of texels, x1 and y1 excluded.
struct Rectangle {
    int x0, y0, x1, y1;
    [[nodiscard]] int width() const { return x1 - x0; }
    [[nodiscard]] int height() const { return y1 - y0; }
    [[nodiscard]] bool empty() const { return x0 >= x1 || y0 >= y1; }
};

Rectangle intersection(const Rectangle &a, const Rectangle &b) {
    return {std::max(a.x0, b.x0), std::max(a.y0, b.y0), std::min(a.x1, b.x1), std::min(a.y1, b.y1)};
}

/// The picture of an OpenEXR file is its display window (Technical Introduction to OpenEXR, "Display Window and Data Window"): data
/// outside it are not seen, and where it has no data it is black. Other formats have no such windows.
Rectangle displayWindow(const ImagePart &part, const Rectangle &data, bool isExr, const Location &where, Warnings &warnings) {
    if (!isExr) return data;
    const Rectangle display{part.fullX, part.fullY, part.fullX + part.fullWidth, part.fullY + part.fullHeight};
    const Rectangle seen = intersection(display, data);
    if (seen.empty()) failInput(where, "a data window outside the display window", "data to display");
    if (seen.width() != display.width() || seen.height() != display.height())
        warnings.add(where.text() + ": its data cover " + std::to_string(seen.width()) + " x " + std::to_string(seen.height()) +
                     " texels of its display window of " + std::to_string(display.width()) + " x " + std::to_string(display.height()) +
                     "; the rest is black");
    return display;
}

/// Grey and alpha become red, green, blue and alpha: a texture has 1, 3 or 4 channels.
std::vector<int> textureChannels(std::vector<int> indices) {
    if (indices.size() == 2) indices.insert(indices.begin() + 1, 2, indices[0]);
    return indices;
}

/// The values of a picture in a rectangle, read from the file's rectangle and channels.
Pixels arrange(const std::vector<float> &read, const Rectangle &data, int firstChannel, int channelCount, const Rectangle &display,
                const std::vector<int> &indices) {
    Pixels texture;
    texture.width = display.width();
    texture.height = display.height();
    texture.channels = static_cast<int>(indices.size());
    texture.texels.resize(static_cast<std::size_t>(texture.width) * static_cast<std::size_t>(texture.height) * indices.size());
    const Rectangle seen = intersection(display, data);
    for (int y = seen.y0; y < seen.y1; ++y) {
        const auto offset = [&](const Rectangle &r, std::size_t channels) {
            return (static_cast<std::size_t>(y - r.y0) * static_cast<std::size_t>(r.width()) + static_cast<std::size_t>(seen.x0 - r.x0)) *
                   channels;
        };
        const float *from = read.data() + offset(data, static_cast<std::size_t>(channelCount));
        float *to = texture.texels.data() + offset(display, indices.size());
        for (int x = seen.x0; x < seen.x1; ++x, from += channelCount, to += indices.size())
            for (std::size_t c = 0; c < indices.size(); ++c) to[c] = indices[c] < 0 ? 0 : from[indices[c] - firstChannel];
    }
    return texture;
}

/// A renderer's accident in a texel (a division by zero, an overflow of half floats, a filter's undershoot) spoils no picture: values
/// that are no numbers are held at 0, infinite ones at the greatest or least finite one, negative radiance at 0.
void holdTexels(Pixels &texture, bool isRadiance, const Location &where, Warnings &warnings) {
    std::size_t notANumber = 0;
    std::size_t infinite = 0;
    std::size_t negative = 0;
    std::size_t first = 0;
    const auto channels = static_cast<std::size_t>(texture.channels);
    const std::size_t texels = texture.texels.size() / channels;
    float least = 0;
    float greatest = 0;
    for (const float value : texture.texels) {
        if (!std::isfinite(value)) continue;
        least = std::min(least, value);
        greatest = std::max(greatest, value);
    }
    for (std::size_t i = 0; i < texels; ++i) {
        bool isNan = false;
        bool isInfinite = false;
        bool isNegative = false;
        for (std::size_t c = 0; c < channels; ++c) {
            float &value = texture.texels[i * channels + c];
            isNan |= std::isnan(value);
            isInfinite |= std::isinf(value);
            isNegative |= isRadiance && value < 0 && std::isfinite(value);
            if (std::isnan(value)) value = 0;
            if (std::isinf(value)) value = value > 0 ? greatest : least;
            if (isRadiance) value = std::max(value, 0.0F);
        }
        if ((isNan || isInfinite || isNegative) && notANumber + infinite + negative == 0) first = i;
        if (isNan)
            ++notANumber;
        else if (isInfinite)
            ++infinite;
        else if (isNegative)
            ++negative;
    }
    const std::size_t bad = notANumber + infinite + negative;
    if (bad == 0) return;
    std::string found;
    const auto add = [&](std::size_t count, const std::string &what) {
        if (count > 0) found += (found.empty() ? "" : ", ") + std::to_string(count) + " " + what;
    };
    add(notANumber, "not a number, held at 0");
    add(infinite, "infinite, held at " + formatNumber(static_cast<double>(greatest)));
    add(negative, "negative, held at 0");
    const std::string place = " (the first in column " + std::to_string(first % static_cast<std::size_t>(texture.width)) + ", row " +
                              std::to_string(first / static_cast<std::size_t>(texture.width)) + ")";
    const std::string of = " of " + std::to_string(texels) + (texels == 1 ? " texel" : " texels");
    if (bad > 1 && bad > texels / 4) // then it is not the picture that was meant
        failInput(where, std::to_string(bad) + of + " that are negative or not finite" + place, "at most a quarter of them");
    warnings.add(where.text() + ":" + of + ": " + found + place);
}

/// What is done with a file's values.
struct Use {
    ColorSpace space;
    bool isRadiance;
    Budget &budget;
};

Pixels decode(ImageDecoder &input, const Format &format, std::size_t fileBytes, const Use &use, const Location &where,
               Warnings &warnings) {
    const bool isExr = format.plugin == "openexr"sv;
    const ImageChannels picture = pictureOf(input, isExr, where, warnings);
    const ImagePart &part = picture.part;
    const std::vector<int> indices = textureChannels(picture.indices);
    if (!part.isFlat || indices.empty()) failInput(where, "an image that is deep or has no channels", "a flat image");
    const int lastChannel = *std::max_element(indices.begin(), indices.end());
    int firstChannel = lastChannel;
    for (const int index : indices)
        if (index >= 0) firstChannel = std::min(firstChannel, index);
    const int channelCount = lastChannel - firstChannel + 1;
    checkSize(part.width, part.height, channelCount, fileBytes, where);
    if (isExr) checkSize(part.fullWidth, part.fullHeight, static_cast<int>(indices.size()), fileBytes, where);
    const Rectangle data{part.x, part.y, part.x + part.width, part.y + part.height};
    const Rectangle display = displayWindow(part, data, isExr, where, warnings);
    use.budget.require(sizeof(float) * (static_cast<double>(part.width) * part.height * channelCount +
                                        static_cast<double>(display.width()) * display.height() * static_cast<double>(indices.size())),
                       where.text(), "its values");
    std::vector<float> values(static_cast<std::size_t>(part.width) * static_cast<std::size_t>(part.height) *
                              static_cast<std::size_t>(channelCount));
    input.read(picture.number, firstChannel, lastChannel + 1, values.data());
    Pixels texture = arrange(values, data, firstChannel, channelCount, display, indices);
    holdTexels(texture, use.isRadiance, where, warnings);
    const bool auto_ = use.space == ColorSpace::Auto;
    if (use.space == ColorSpace::Srgb || (auto_ && isSrgb(part, format, where, warnings))) decodeSrgb(texture);
    return texture;
}

Pixels decodeWith(const Format &format, std::string_view bytes, const Use &use, const Location &where, Warnings &warnings) {
    const ImageCodec &codec = imageCodec();
    try {
        const auto input = codec.open(format.plugin, bytes, where.file);
        return decode(*input, format, bytes.size(), use, where, warnings);
    } catch (const InputError &) {
        throw;
    } catch (const std::exception &error) {
        failDecoding(where, error.what());
    }
}

/// 32-bit BMP files before version 4 have no alpha but a byte that most programs leave 0.
void ignoreZeroAlpha(Pixels &texture) {
    bool isZero = texture.channels == 4;
    for (std::size_t i = 3; isZero && i < texture.texels.size(); i += 4) isZero = texture.texels[i] == 0;
    for (std::size_t i = 3; isZero && i < texture.texels.size(); i += 4) texture.texels[i] = 1;
}

Texture decodeFile(const std::string &name, std::string_view bytes, const Use &use, Warnings &warnings) {
    const Location where{name, 0, 0, -1};
    const Format *format = formatOf(name, bytes);
    if (format == nullptr) failInput(where, bytes.empty() ? "an empty file" : "a file of another format", "a " + std::string(kFormatNames));
    if (format->damage != nullptr)
        if (const std::string damage = format->damage(bytes); !damage.empty()) failDecoding(where, damage);
    checkAnnounced(*format, bytes, where, use.budget);
    Pixels texture = decodeWith(*format, bytes, use, where, warnings);
    if (format->plugin == "bmp"sv) ignoreZeroAlpha(texture);
    if (format->plugin == "webp"sv && texture.channels == 4) {
        const Pixels colours = decodeWith(*format, opaqueWebp(bytes), use, where, warnings);
        const auto channels = static_cast<std::size_t>(colours.channels);
        for (std::size_t i = 0; 4 * i < texture.texels.size() && channels * i + 2 < colours.texels.size(); ++i)
            std::copy_n(&colours.texels[channels * i], 3, &texture.texels[4 * i]);
    }
    use.budget.take(sizeof(float) * static_cast<double>(texture.texels.size()), where.file, "its texels");
    Texture read;
    read.name = where.file;
    read.width = texture.width;
    read.height = texture.height;
    read.channels = texture.channels;
    read.texels = std::move(texture.texels);
    return read;
}

/// With the caller's budget, else one of its own.
Texture decodeWithin(Budget *budget, const std::string &name, std::string_view bytes, ColorSpace space, bool isRadiance, Warnings &warnings) {
    std::optional<Budget> own;
    Budget &account = budget != nullptr ? *budget : own.emplace();
    account.addInput(bytes.size());
    return decodeFile(name, bytes, {space, isRadiance, account}, warnings);
}

} // namespace

Texture readTextureFromMemory(const std::string &name, const std::vector<unsigned char> &bytes, ColorSpace space, Warnings &warnings,
                              Budget *budget) {
    return decodeWithin(budget, name, {reinterpret_cast<const char *>(bytes.data()), bytes.size()}, space, false, warnings);
}

Texture readTexture(const std::string &path, ColorSpace space, Warnings &warnings, Budget *budget) {
    return decodeWithin(budget, path, readFileBytes(path), space, false, warnings);
}

Texture readRadiance(const std::string &path, Warnings &warnings, Budget *budget) {
    return decodeWithin(budget, path, readFileBytes(path), ColorSpace::Auto, true, warnings);
}

} // namespace taut
