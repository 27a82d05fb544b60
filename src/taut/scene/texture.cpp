#include "taut/scene/texture.h"

#include "taut/base/file_bytes.h"
#include "taut/base/parallel.h"
#include "taut/base/srgb.h"
#include "taut/scene/png_guard.h"

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>

#include <algorithm>
#include <cstring>
#include <memory>

namespace taut {

namespace {

constexpr int kMostTexelsPerSide = 32768;
constexpr std::int64_t kMostTexels = std::int64_t{1} << 28;
/// Floats below this many bytes are allocated on the header's word alone; above it the file must be long enough to hold the
/// image at this ratio, which no compression of these formats exceeds on pictures.
constexpr std::int64_t kTrustedBytes = std::int64_t{64} << 20;
constexpr std::int64_t kMostCompression = 65536;

struct Format {
    const char *magic;
    std::size_t length;
    const char *plugin; ///< OpenImageIO's name
};
/// Told apart by their first bytes, never by trying one decoder after the other.
constexpr Format kFormats[] = {
    {"\x89PNG", 4, "png"}, {"\xff\xd8\xff", 3, "jpeg"}, {"\x76\x2f\x31\x01", 4, "openexr"},
    {"#?", 2, "hdr"},      {"II*\0", 4, "tiff"},        {"MM\0*", 4, "tiff"},
};

const char *pluginOf(std::string_view bytes) {
    for (const Format &format : kFormats)
        if (bytes.size() >= format.length && std::memcmp(bytes.data(), format.magic, format.length) == 0) return format.plugin;
    return nullptr;
}

[[noreturn]] void failDecoding(const Location &where, std::string reason) {
    constexpr std::size_t kLongest = 200;
    while (!reason.empty() && std::isspace(static_cast<unsigned char>(reason.back())) != 0) reason.pop_back();
    if (reason.empty()) reason = "no reason given";
    failInput(where, "an image that can't be decoded (" + reason.substr(0, kLongest) + ")",
              "a complete PNG, JPEG, OpenEXR, HDR or TIFF image");
}

void checkSize(const OIIO::ImageSpec &spec, std::size_t fileBytes, const Location &where) {
    const std::string found =
        std::to_string(spec.width) + " x " + std::to_string(spec.height) + " texels of " + std::to_string(spec.nchannels) + " channels";
    if (spec.width < 1 || spec.height < 1 || spec.nchannels < 1 || spec.depth > 1 || spec.deep)
        failInput(where, found + (spec.deep ? ", deep" : ""), "a flat image with texels");
    const std::int64_t texels = std::int64_t{spec.width} * spec.height;
    if (spec.width > kMostTexelsPerSide || spec.height > kMostTexelsPerSide || texels > kMostTexels || spec.nchannels > 1024)
        failInput(where, found, "at most 32768 texels a side and 2^28 in all");
    const std::int64_t bytes = texels * spec.nchannels * static_cast<std::int64_t>(sizeof(float));
    if (bytes > kTrustedBytes && bytes / kMostCompression > static_cast<std::int64_t>(fileBytes))
        failInput(where, found + " in " + std::to_string(fileBytes) + " bytes", "a file long enough to hold them");
}

/// Grey and alpha become red, green, blue and alpha.
std::vector<float> expandGreyAlpha(const std::vector<float> &texels) {
    std::vector<float> out(texels.size() * 2);
    for (std::size_t i = 0; i < texels.size() / 2; ++i) {
        std::fill_n(out.begin() + static_cast<std::ptrdiff_t>(4 * i), 3, texels[2 * i]);
        out[4 * i + 3] = texels[2 * i + 1];
    }
    return out;
}

void decodeSrgb(Texture &texture) {
    const int channels = texture.channels;
    const int colors = std::min(channels, 3); // the fourth is alpha, which is linear in every format
    parallelFor(texture.texels.size() / static_cast<std::size_t>(channels), 65536, [&](std::size_t i) {
        float *texel = &texture.texels[i * static_cast<std::size_t>(channels)];
        for (int c = 0; c < colors; ++c) texel[c] = linearFromSrgb(texel[c]);
    });
}

void checkFinite(const Texture &texture, const Location &where) {
    const auto bad = std::find_if(texture.texels.begin(), texture.texels.end(), [](float value) { return !std::isfinite(value); });
    if (bad == texture.texels.end()) return;
    const std::int64_t texel = (bad - texture.texels.begin()) / texture.channels;
    failInput(where,
              "a value that is not finite in column " + std::to_string(texel % texture.width) + ", row " +
                  std::to_string(texel / texture.width),
              "finite values");
}

Texture decode(OIIO::ImageInput &input, const Location &where, std::size_t fileBytes, ColorSpace space) {
    const OIIO::ImageSpec spec = input.spec();
    checkSize(spec, fileBytes, where);
    Texture texture;
    texture.name = where.file;
    texture.width = spec.width;
    texture.height = spec.height;
    texture.channels = std::min(spec.nchannels, 4);
    texture.texels.resize(static_cast<std::size_t>(spec.width) * static_cast<std::size_t>(spec.height) *
                          static_cast<std::size_t>(texture.channels));
    if (!input.read_image(0, 0, 0, texture.channels, OIIO::TypeDesc::FLOAT, texture.texels.data())) failDecoding(where, input.geterror());
    if (texture.channels == 2) {
        texture.texels = expandGreyAlpha(texture.texels);
        texture.channels = 4;
    }
    checkFinite(texture, where);
    const bool eightBit = spec.format.basetype == OIIO::TypeDesc::UINT8;
    if (space == ColorSpace::Srgb || (space == ColorSpace::Auto && eightBit)) decodeSrgb(texture);
    return texture;
}

/// Index of the texel at or below a continuous coordinate, wrapped or clamped.
int resolve(int index, int count, bool repeat) {
    if (!repeat) return std::clamp(index, 0, count - 1);
    const int wrapped = index % count;
    return wrapped < 0 ? wrapped + count : wrapped;
}

/// A texture coordinate brought to where floats are fine; far outside [0, 1] a clamped one stays outside.
float reduce(float x, bool repeat) {
    if (!std::isfinite(x)) return 0;
    return repeat ? x - std::floor(x) : std::clamp(x, -1.0F, 2.0F);
}

Vec4 texelAt(const Texture &texture, int x, int y) {
    const std::size_t column = static_cast<std::size_t>(resolve(x, texture.width, texture.repeatU));
    const std::size_t row = static_cast<std::size_t>(resolve(y, texture.height, texture.repeatV));
    const float *t = &texture.texels[(row * static_cast<std::size_t>(texture.width) + column) * static_cast<std::size_t>(texture.channels)];
    if (texture.channels == 1) return {t[0], t[0], t[0], 1};
    return {t[0], t[1], t[2], texture.channels == 4 ? t[3] : 1.0F};
}

Texture decodeFile(const std::string &name, std::string_view bytes, ColorSpace space) {
    const Location where{name, 0, 0, -1};
    const char *plugin = pluginOf(bytes);
    if (plugin == nullptr)
        failInput(where, bytes.empty() ? "an empty file" : "a file of another format", "a PNG, JPEG, OpenEXR, HDR or TIFF image");
    if (std::string_view(plugin) == "png")
        if (const std::string damage = damageOfPng(bytes); !damage.empty()) failDecoding(where, damage);
    try {
        OIIO::Filesystem::IOMemReader reader(bytes.data(), bytes.size());
        const auto input = OIIO::ImageInput::create(plugin);
        if (!input) failDecoding(where, OIIO::geterror());
        input->set_ioproxy(&reader);
        OIIO::ImageSpec spec;
        OIIO::ImageSpec config;
        config.attribute("oiio:UnassociatedAlpha", 1); // colours as stored, not multiplied by alpha
        if (!input->open(name, spec, config)) failDecoding(where, input->geterror());
        Texture texture = decode(*input, where, bytes.size(), space);
        input->close();
        return texture;
    } catch (const InputError &) {
        throw;
    } catch (const std::exception &error) {
        failDecoding(where, error.what());
    }
}

} // namespace

Texture readTextureFromMemory(const std::string &name, const std::vector<unsigned char> &bytes, ColorSpace space) {
    return decodeFile(name, {reinterpret_cast<const char *>(bytes.data()), bytes.size()}, space);
}

Texture readTexture(const std::string &path, ColorSpace space) {
    return decodeFile(path, readFileBytes(path), space);
}

Vec4 lookup(const Texture &texture, const Vec2 &uv) {
    const float x = reduce(uv.x, texture.repeatU) * static_cast<float>(texture.width) - 0.5F;
    const float y = reduce(1 - uv.y, texture.repeatV) * static_cast<float>(texture.height) - 0.5F;
    const float x0 = std::floor(x);
    const float y0 = std::floor(y);
    const int column = static_cast<int>(x0);
    const int row = static_cast<int>(y0);
    const Vec4 upper = glm::mix(texelAt(texture, column, row), texelAt(texture, column + 1, row), x - x0);
    const Vec4 lower = glm::mix(texelAt(texture, column, row + 1), texelAt(texture, column + 1, row + 1), x - x0);
    return glm::mix(upper, lower, y - y0);
}

} // namespace taut
