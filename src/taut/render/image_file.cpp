#include "taut/render/image_file.h"

#include "taut/base/budget.h"
#include "taut/base/error.h"
#include "taut/base/file_bytes.h"
#include "taut/base/srgb.h"
#include "taut/images/image_codec.h"
#include "taut/scene/exr_guard.h"
#include "taut/scene/png_guard.h"

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
    part.attributes.insert(part.attributes.end(), metadata.begin(), metadata.end());
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
