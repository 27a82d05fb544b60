#include "taut/render/image_file.h"

#include "taut/base/error.h"
#include "taut/base/srgb.h"

#include <OpenImageIO/imageio.h>

#include <cmath>
#include <filesystem>
#include <fstream>

namespace taut {

namespace {

namespace fs = std::filesystem;

std::string extensionOf(const std::string &path) {
    std::string extension = fs::path(path).extension().string();
    for (char &c : extension) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    return extension;
}

void makeParent(const std::string &path) {
    const fs::path parent = fs::path(path).parent_path();
    std::error_code error;
    if (!parent.empty()) fs::create_directories(parent, error);
    if (error) throw RunError(path + ": can't make its folder: " + error.message());
}

/// A file under construction beside its final name, with the same extension so that writers choose the same format. It is gone
/// with this object unless it was finished.
class PartFile {
  public:
    explicit PartFile(const std::string &path) : target_(path) {
        makeParent(path);
        part_ = (target_.parent_path() / ("." + target_.stem().string() + ".part" + target_.extension().string())).string();
    }
    ~PartFile() {
        std::error_code ignored;
        if (!finished_) fs::remove(part_, ignored);
    }
    PartFile(const PartFile &) = delete;
    PartFile &operator=(const PartFile &) = delete;

    [[nodiscard]] const std::string &name() const { return part_; }
    void finish() {
        std::error_code error;
        fs::rename(part_, target_, error);
        if (error) throw RunError(target_.string() + ": can't be written: " + error.message());
        finished_ = true;
    }

  private:
    fs::path target_;
    std::string part_;
    bool finished_ = false;
};

} // namespace

bool isImagePath(const std::string &path) {
    return extensionOf(path) == ".exr" || extensionOf(path) == ".png";
}

void writeImage(const std::string &path, const Image &image, const Metadata &metadata) {
    PartFile part(path);
    const bool png = extensionOf(path) == ".png";
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

    const auto output = OIIO::ImageOutput::create(part.name());
    if (!output) throw RunError(path + ": no writer for this kind of image: " + OIIO::geterror());
    bool written = output->open(part.name(), spec);
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
    part.finish();
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
    PartFile part(path);
    std::ofstream file(part.name(), std::ios::binary);
    file << text;
    file.close();
    if (!file) throw RunError(path + ": can't be written");
    part.finish();
}

} // namespace taut
