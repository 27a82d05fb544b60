#include "taut/render/image_file.h"

#include "taut/base/error.h"
#include "taut/base/file_bytes.h"
#include "taut/base/srgb.h"
#include "taut/images/image_codec.h"

#include <cmath>

namespace taut {

namespace {

/// The first three channels, 8 bit sRGB.
std::vector<unsigned char> srgbBytes(const Image &image) {
    const std::size_t channels = image.channels.size();
    std::vector<unsigned char> bytes;
    bytes.reserve(image.values.size() / channels * 3);
    for (std::size_t first = 0; first + 2 < image.values.size(); first += channels)
        for (std::size_t c = 0; c < 3; ++c)
            bytes.push_back(static_cast<unsigned char>(std::lround(255 * srgbFromLinear(image.values[first + c]))));
    return bytes;
}

} // namespace

bool isImagePath(const std::string &path) {
    return lowerExtension(path) == "exr" || lowerExtension(path) == "png";
}

void writeImage(const std::string &path, const Image &image, const Metadata &metadata) {
    makeFolderOf(path);
    OutputFile file(path); // before the work of encoding, so that a folder without room is known at once
    const bool png = lowerExtension(path) == "png";
    ImagePart part;
    part.width = part.fullWidth = image.window.width();
    part.height = part.fullHeight = image.window.height();
    part.channels = {"R", "G", "B"};
    if (!png) {
        part.channels = image.channels;
        part.x = image.window.x0;
        part.y = image.window.y0;
        part.fullWidth = image.width;
        part.fullHeight = image.height;
        part.attributes.emplace_back("compression", "zip");
    }
    part.attributes.emplace_back("oiio:ColorSpace", png ? "sRGB" : "Linear");
    part.attributes.emplace_back("DateTime", ""); // the same picture is the same file
    for (const auto &entry : metadata) // ids are in EXR files alone
        if (!png || !entry.first.starts_with("cryptomatte/")) part.attributes.push_back(entry);
    const std::vector<unsigned char> bytes = png ? srgbBytes(image) : std::vector<unsigned char>();
    const ImageToEncode content{part, png ? SampleType::UInt8 : SampleType::Float, image.values.data(), png ? bytes.data() : nullptr};
    const ImageCodec &codec = imageCodec();
    std::vector<unsigned char> encoded;
    try {
        encoded = codec.encode(png ? "png" : "openexr", content);
    } catch (const std::exception &error) {
        throw RunError(path + ": can't be written: " + error.what());
    }
    file.write(encoded.data(), encoded.size());
    file.finish();
}

Image readImage(const std::string &path) {
    const std::string bytes = readFileBytes(path);
    const bool png = bytes.compare(0, 4, "\x89PNG") == 0;
    const ImageCodec &codec = imageCodec();
    Image image;
    try {
        const auto input = codec.open(png ? "png" : "openexr", bytes, path);
        const ImagePart part = input->parts(false).at(0);
        image.window = {part.x, part.y, part.x + part.width, part.y + part.height};
        image.width = part.fullWidth;
        image.height = part.fullHeight;
        image.channels = part.channels;
        image.values.resize(static_cast<std::size_t>(part.width) * static_cast<std::size_t>(part.height) * part.channels.size());
        input->read(0, 0, part.channelCount(), image.values.data());
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
