#include "taut/render/image_file.h"

#include "taut/base/budget.h"
#include "taut/base/error.h"
#include "taut/base/file_bytes.h"
#include "taut/images/image_codec.h"
#include "taut/images/view_transform.h"
#include "taut/scene/exr_guard.h"
#include "taut/scene/png_guard.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

namespace taut {

namespace {

/// The first three channels as a display is sent them, in [0, 1].
std::vector<float> shown(const Image &image, const ViewTransform &view) {
    const std::size_t channels = image.channels.size();
    std::vector<float> colours;
    colours.reserve(image.values.size() / channels * 3);
    for (std::size_t first = 0; first + 2 < image.values.size(); first += channels)
        colours.insert(colours.end(), image.values.begin() + static_cast<std::ptrdiff_t>(first),
                       image.values.begin() + static_cast<std::ptrdiff_t>(first + 3));
    view.apply(colours.data(), colours.size() / 3);
    return colours;
}

template <class Integer> std::vector<Integer> quantised(const std::vector<float> &colours) {
    std::vector<Integer> values;
    values.reserve(colours.size());
    for (const float c : colours) values.push_back(static_cast<Integer>(std::lround(std::numeric_limits<Integer>::max() * c)));
    return values;
}

/// Finite values that half floats do not reach are held at the largest.
void holdInHalf(std::vector<float> &values, const std::vector<SampleType> &types) {
    constexpr float kLargest = 65504;
    for (std::size_t i = 0; i < values.size(); ++i)
        if (types[i % types.size()] == SampleType::Half && std::isfinite(values[i])) values[i] = std::clamp(values[i], -kLargest, kLargest);
}

std::vector<unsigned char> encode(const std::string &path, const std::string &format, const ImageToEncode &content) {
    const ImageCodec &codec = imageCodec();
    try {
        return codec.encode(format, content);
    } catch (const std::exception &error) {
        throw RunError(path + ": can't be written: " + error.what());
    }
}

ImagePart partOf(const Image &image, const char *space) {
    ImagePart part;
    part.width = part.fullWidth = image.window.width();
    part.height = part.fullHeight = image.window.height();
    part.channels = {"R", "G", "B"};
    if (space != nullptr) part.attributes.emplace_back("oiio:ColorSpace", space);
    part.attributes.emplace_back("DateTime", ""); // the same picture is the same file
    return part;
}

std::vector<unsigned char> pngOf(const std::string &path, const Image &image, const Metadata &metadata, const ImageSettings &settings) {
    const ViewTransform view(settings.view);
    ImagePart part = partOf(image, view.isSrgb() ? "sRGB" : nullptr);
    for (const auto &entry : metadata) // ids are in EXR files alone
        if (!entry.first.starts_with("cryptomatte/")) part.attributes.push_back(entry);
    part.attributes.insert(part.attributes.end(), view.applied().begin(), view.applied().end());
    const std::vector<float> colours = shown(image, view);
    if (settings.pngBits == 16) {
        const auto words = quantised<std::uint16_t>(colours);
        return encode(path, "png", {part, SampleType::UInt16, nullptr, nullptr, words.data()});
    }
    const auto bytes = quantised<unsigned char>(colours);
    return encode(path, "png", {part, SampleType::UInt8, nullptr, bytes.data()});
}

std::vector<unsigned char> exrOf(const std::string &path, const Image &image, const Metadata &metadata, const ImageSettings &settings) {
    checkCompressionOf(settings.exrCompression, image.channels);
    ImagePart part = partOf(image, "Linear");
    part.channels = image.channels;
    part.x = image.window.x0;
    part.y = image.window.y0;
    part.fullWidth = image.width;
    part.fullHeight = image.height;
    part.attributes.insert(part.attributes.begin(), {"compression", settings.exrCompression});
    part.attributes.insert(part.attributes.end(), metadata.begin(), metadata.end());
    if (!settings.exrHalf) return encode(path, "openexr", {part, SampleType::Float, image.values.data()});
    std::vector<SampleType> types;
    for (const std::string &channel : image.channels) types.push_back(isColourChannel(channel) ? SampleType::Half : SampleType::Float);
    std::vector<float> values = image.values;
    holdInHalf(values, types);
    return encode(path, "openexr", {part, SampleType::Float, values.data(), nullptr, nullptr, std::move(types)});
}

/// Its values fit into the budget; while they are read there are two copies of them.
void checkSize(const std::string &path, std::int64_t width, std::int64_t height, std::size_t channels, double decoder,
               const Budget &budget) {
    const double values = static_cast<double>(width) * static_cast<double>(height) * static_cast<double>(channels);
    budget.require(2 * sizeof(float) * values + decoder, path,
                   "an image of " + std::to_string(width) + " x " + std::to_string(height) + " pixels");
}

/// Before a decoder looks: the header must be sound, and ask for no more than the budget has.
void checkHeader(const std::string &path, const std::string &bytes, bool png, const Budget &budget) {
    const std::string damage = png ? damageOfPng(bytes) : damageOfExr(bytes);
    if (!damage.empty()) throw InputError(path + ": found no readable image (" + damage + "), expected an EXR or PNG");
    const AnnouncedSize size = png ? sizeOfPng(bytes) : sizeOfExr(bytes);
    checkSize(path, size.width, size.height, static_cast<std::size_t>(size.channels), size.decoder, budget);
}

} // namespace

bool isImagePath(const std::string &path) {
    return lowerExtension(path) == "exr" || lowerExtension(path) == "png";
}

void writeImage(const std::string &path, const Image &image, const Metadata &metadata, const ImageSettings &settings) {
    makeFolderOf(path);
    OutputFile file(path); // before the work of encoding, so that a folder without room is known at once
    const bool png = lowerExtension(path) == "png";
    const std::vector<unsigned char> encoded = png ? pngOf(path, image, metadata, settings) : exrOf(path, image, metadata, settings);
    file.write(encoded.data(), encoded.size());
    file.finish();
}

void writeImage(const std::string &path, const Image &image, const Metadata &metadata) {
    static const ImageSettings kDefault;
    writeImage(path, image, metadata, kDefault);
}

Image readImage(const std::string &path) {
    const std::string bytes = readFileBytes(path);
    const bool png = bytes.compare(0, 4, "\x89PNG") == 0;
    Budget budget;
    budget.addInput(bytes.size());
    checkHeader(path, bytes, png, budget);
    const ImageCodec &codec = imageCodec();
    Image image;
    try {
        const auto input = codec.open(png ? "png" : "openexr", bytes, path);
        const ImagePart part = input->parts(false).at(0);
        image.window = {part.x, part.y, part.x + part.width, part.y + part.height};
        image.width = part.fullWidth;
        image.height = part.fullHeight;
        image.channels = part.channels;
        checkSize(path, part.width, part.height, part.channels.size(), 0, budget);
        image.values.resize(static_cast<std::size_t>(part.width) * static_cast<std::size_t>(part.height) * part.channels.size());
        input->read(0, 0, part.channelCount(), image.values.data());
    } catch (const InputError &) {
        throw;
    } catch (const std::exception &error) {
        throw InputError(path + ": found no readable image (" + error.what() + "), expected an EXR or PNG");
    }
    return image;
}

void writeTextFile(const std::string &path, const std::string &text) {
    makeFolderOf(path);
    writeFileWhole(path, text);
}

} // namespace taut
