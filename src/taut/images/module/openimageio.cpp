/// The module: OpenImageIO as an ImageCodec. It shares nothing with the library but the interface.

#include "opencolorio.h"

#include "taut/images/image_codec.h"

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>

namespace taut {

namespace {

[[noreturn]] void fail(const std::string &reason) {
    throw std::runtime_error(reason);
}

ImagePart partOf(const OIIO::ImageSpec &spec) {
    ImagePart part;
    part.name = std::string(spec.get_string_attribute("oiio:subimagename", spec.get_string_attribute("name", "")));
    for (int c = 0; c < spec.nchannels; ++c) part.channels.emplace_back(spec.channel_name(c));
    // OpenImageIO 2.5 makes colours of luminance and chroma, 2.4 does not: both say what the file has.
    constexpr std::array kLuminanceAndChroma{"Y", "RY", "BY"};
    if (spec.get_int_attribute("openexr:luminancechroma") != 0 && spec.nchannels >= 3)
        std::copy(kLuminanceAndChroma.begin(), kLuminanceAndChroma.end(), part.channels.begin());
    part.x = spec.x;
    part.y = spec.y;
    part.width = spec.width;
    part.height = spec.height;
    part.fullX = spec.full_x;
    part.fullY = spec.full_y;
    part.fullWidth = spec.full_width;
    part.fullHeight = spec.full_height;
    part.isFlat = !spec.deep && spec.depth <= 1;
    part.isEightBits = spec.format.basetype == OIIO::TypeDesc::UINT8;
    part.isLinear = spec.get_string_attribute("oiio:ColorSpace") == "Linear";
    part.gamma = spec.get_float_attribute("oiio:Gamma", 0);
    for (const OIIO::ParamValue &value : spec.extra_attribs)
        if (value.type() == OIIO::TypeDesc::STRING) part.attributes.emplace_back(value.name().string(), value.get_string());
    return part;
}

class Decoder final : public ImageDecoder {
  public:
    Decoder(const std::string &format, std::string_view bytes, const std::string &name)
        : reader_(bytes.data(), bytes.size()), input_(OIIO::ImageInput::create(format)) {
        if (!input_) fail(OIIO::geterror());
        input_->set_ioproxy(&reader_);
        OIIO::ImageSpec spec;
        OIIO::ImageSpec config;
        config.attribute("oiio:UnassociatedAlpha", 1);
        if (!input_->open(name, spec, config)) fail(input_->geterror());
    }

    std::vector<ImagePart> parts(bool all) override {
        std::vector<ImagePart> found;
        if (!all) return {partOf(input_->spec())};
        constexpr int kMostParts = 1024;
        for (int part = 0; part < kMostParts && input_->seek_subimage(part, 0); ++part) found.push_back(partOf(input_->spec()));
        static_cast<void>(input_->geterror()); // that of the part behind the last
        return found;
    }

    void read(int part, int first, int end, float *values) override {
        if (!input_->read_image(part, 0, first, end, OIIO::TypeDesc::FLOAT, values)) fail(input_->geterror());
    }

  private:
    OIIO::Filesystem::IOMemReader reader_;
    std::unique_ptr<OIIO::ImageInput> input_;
};

OIIO::TypeDesc typeOf(SampleType type) {
    switch (type) {
    case SampleType::UInt8: return OIIO::TypeDesc::UINT8;
    case SampleType::UInt16: return OIIO::TypeDesc::UINT16;
    case SampleType::Half: return OIIO::TypeDesc::HALF;
    case SampleType::Float: break;
    }
    return OIIO::TypeDesc::FLOAT;
}

class OpenImageIo final : public ImageCodec {
  public:
    std::unique_ptr<ImageDecoder> open(const std::string &format, std::string_view bytes, const std::string &name) const override {
        return std::make_unique<Decoder>(format, bytes, name);
    }

    std::vector<unsigned char> encode(const std::string &format, const ImageToEncode &image) const override {
        const ImagePart &part = image.part;
        OIIO::ImageSpec spec(part.width, part.height, part.channelCount(), typeOf(image.type));
        spec.channelnames = part.channels;
        for (const SampleType type : image.channelTypes) spec.channelformats.push_back(typeOf(type));
        spec.x = part.x;
        spec.y = part.y;
        spec.full_x = part.fullX;
        spec.full_y = part.fullY;
        spec.full_width = part.fullWidth;
        spec.full_height = part.fullHeight;
        if (format != "openexr") spec.attribute("oiio:UnassociatedAlpha", 1);
        for (const auto &[name, value] : part.attributes) spec.attribute(name, value);
        const auto output = OIIO::ImageOutput::create(format);
        if (!output) fail("no writer for this kind of image: " + OIIO::geterror());
        std::vector<unsigned char> encoded;
        OIIO::Filesystem::IOVecOutput memory(encoded);
        if (!output->set_ioproxy(&memory)) fail("its writer does not write to memory");
        bool written = output->open("image." + format, spec);
        written = written && (image.bytes != nullptr   ? output->write_image(OIIO::TypeDesc::UINT8, image.bytes)
                              : image.words != nullptr ? output->write_image(OIIO::TypeDesc::UINT16, image.words)
                                                       : output->write_image(OIIO::TypeDesc::FLOAT, image.values));
        if (!written || !output->close()) fail(output->geterror());
        return encoded;
    }

    std::unique_ptr<const ColourConfig> openColours(const std::string &path) const override { return openColourConfig(path); }
    std::unique_ptr<const ColourTransform> acesView(const std::string &display) const override { return makeAcesView(display); }
    std::vector<std::string> acesDisplays() const override { return namesOfAcesDisplays(); }
    std::string colourVersion() const override { return versionOfOpenColorIo(); }
};

} // namespace

extern "C" const ImageCodec &tautImageCodec() {
    static const OpenImageIo codec;
    return codec;
}

} // namespace taut
