#include "taut/render/image_file.h"

#include "taut/base/error.h"
#include "taut/base/file_bytes.h"
#include "taut/base/srgb.h"

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>

#include <cmath>
#include <filesystem>

namespace taut {

namespace {

namespace fs = std::filesystem;

void makeParent(const std::string &path) {
    const fs::path parent = fs::path(path).parent_path();
    std::error_code error;
    if (!parent.empty()) fs::create_directories(parent, error);
    if (error) throw RunError(path + ": can't make its folder: " + error.message());
}

} // namespace

bool isImagePath(const std::string &path) {
    return lowerExtension(path) == "exr" || lowerExtension(path) == "png";
}

void writeImage(const std::string &path, const Image &image, const Metadata &metadata) {
    makeParent(path);
    OutputFile file(path); // before the work of encoding, so that a folder without room is known at once
    const bool png = lowerExtension(path) == "png";
    const int channels = static_cast<int>(image.channels.size());
    OIIO::ImageSpec spec(image.window.width(), image.window.height(), png ? 3 : channels,
                         png ? OIIO::TypeDesc::UINT8 : OIIO::TypeDesc::FLOAT);
    if (!png) {
        spec.channelnames = image.channels;
        spec.x = image.window.x0;
        spec.y = image.window.y0;
        spec.full_width = image.width;
        spec.full_height = image.height;
        spec.attribute("compression", "zip");
        spec.attribute("oiio:ColorSpace", "Linear");
    } else {
        spec.attribute("oiio:ColorSpace", "sRGB");
    }
    for (const auto &[name, value] : metadata) spec.attribute(name, value);

    const auto output = OIIO::ImageOutput::create(png ? "png" : "openexr");
    if (!output) throw RunError(path + ": no writer for this kind of image: " + OIIO::geterror());
    std::vector<unsigned char> encoded; // in memory: what a full disk says is said by OutputFile, in its words
    OIIO::Filesystem::IOVecOutput memory(encoded);
    output->set_ioproxy(&memory);
    bool written = output->open(path, spec);
    if (written && png) {
        const std::size_t pixels = image.values.size() / static_cast<std::size_t>(channels);
        std::vector<unsigned char> bytes;
        bytes.reserve(pixels * 3);
        for (std::size_t p = 0; p < pixels; ++p)
            for (std::size_t c = 0; c < 3; ++c)
                bytes.push_back(static_cast<unsigned char>(
                    std::lround(255 * srgbFromLinear(image.values[p * static_cast<std::size_t>(channels) + c]))));
        written = output->write_image(OIIO::TypeDesc::UINT8, bytes.data());
    } else if (written) {
        written = output->write_image(OIIO::TypeDesc::FLOAT, image.values.data());
    }
    if (!written || !output->close()) throw RunError(path + ": can't be written: " + output->geterror());
    file.write(encoded.data(), encoded.size());
    file.finish();
}

Image readImage(const std::string &path) {
    const auto input = OIIO::ImageInput::open(path);
    if (!input) throw InputError(path + ": found no readable image (" + OIIO::geterror() + "), expected an EXR or PNG");
    const OIIO::ImageSpec &spec = input->spec();
    Image image;
    image.window = {spec.x, spec.y, spec.x + spec.width, spec.y + spec.height};
    image.width = spec.full_width;
    image.height = spec.full_height;
    image.channels = spec.channelnames;
    image.values.resize(static_cast<std::size_t>(spec.width) * static_cast<std::size_t>(spec.height) *
                        static_cast<std::size_t>(spec.nchannels));
    if (!input->read_image(0, 0, 0, spec.nchannels, OIIO::TypeDesc::FLOAT, image.values.data()))
        throw InputError(path + ": found a damaged image (" + input->geterror() + "), expected an EXR or PNG");
    return image;
}

void writeTextFile(const std::string &path, const std::string &text) {
    makeParent(path);
    writeFileWhole(path, text);
}

} // namespace taut
