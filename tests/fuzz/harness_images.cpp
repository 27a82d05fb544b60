/// Images as textures and as maps of radiance. OpenImageIO does the decoding, uninstrumented, in a module of its own: what is fuzzed is what
/// looks at the bytes before it does, and what is made of its answers.

#include "harness.h"
#include "harness_list.h"

#include "taut/images/image_codec.h"
#include "taut/scene/environment.h"
#include "taut/scene/texture.h"
#include "taut/scene/texture_pyramid.h"

namespace taut::fuzz {

namespace {

std::string encoded(const std::string &format, std::vector<std::string> channels, SampleType type) {
    ImagePart part;
    part.channels = std::move(channels);
    part.width = part.fullWidth = 3;
    part.height = part.fullHeight = 2;
    std::vector<float> values;
    for (int i = 0; i < 6 * part.channelCount(); ++i) values.push_back(static_cast<float>(i) / 24);
    const std::vector<unsigned char> bytes = imageCodec().encode(format, {part, type, values.data(), nullptr});
    return {bytes.begin(), bytes.end()};
}

} // namespace

void runImage(std::string_view bytes) {
    survive([&] {
        Warnings warnings;
        const std::vector<unsigned char> copy(bytes.begin(), bytes.end());
        const Texture texture = readTextureFromMemory("fuzz.tga", copy, ColorSpace::Auto, warnings);
        require(texture.texels.size() == static_cast<std::size_t>(texture.width) * static_cast<std::size_t>(texture.height) *
                                             static_cast<std::size_t>(texture.channels),
                "a texture has its texels");
        for (const float value : texture.texels) require(std::isfinite(value), "texels are finite");
        static_cast<void>(lookup(texture, Vec2(0.3F, -7)));
        if (texture.texels.size() < 4096) static_cast<void>(colourPyramid(texture));
    });
}

void runEnvironment(std::string_view bytes) {
    survive([&] {
        Warnings warnings;
        const Environment environment = readEnvironment(scratchFile("fuzz.hdr", bytes), 0.5, Vec3(2), warnings);
        require(isFinite(lookUpEnvironment(environment, Vec3(0, 0, 1)).radiance), "radiance is finite");
        const EnvironmentSample sample = sampleEnvironment(environment, Vec2(0.25F, 0.75F));
        require(!(sample.pdf < 0) && isFinite(sample.radiance), "a sample has a density");
    });
}

std::vector<std::string> imageSeeds() {
    std::vector<std::string> seeds;
    for (const char *format : {"png", "jpeg", "tiff", "webp", "targa", "bmp"}) seeds.push_back(encoded(format, {"R", "G", "B"}, SampleType::UInt8));
    seeds.push_back(encoded("hdr", {"R", "G", "B"}, SampleType::Float));
    seeds.push_back(encoded("openexr", {"R", "G", "B"}, SampleType::Float));
    seeds.push_back(encoded("openexr", {"Y", "A"}, SampleType::Float));
    seeds.push_back(encoded("tiff", {"R", "G", "B", "A"}, SampleType::Float));
    seeds.push_back(encoded("webp", {"R", "G", "B", "A"}, SampleType::UInt8));
    return seeds;
}
std::vector<std::string> pngSeeds() {
    return {encoded("png", {"R", "G", "B"}, SampleType::UInt8), encoded("png", {"Y"}, SampleType::UInt16),
            encoded("png", {"R", "G", "B", "A"}, SampleType::UInt8)};
}
std::vector<std::string> environmentSeeds() {
    return {encoded("hdr", {"R", "G", "B"}, SampleType::Float), encoded("openexr", {"R", "G", "B"}, SampleType::Float)};
}

} // namespace taut::fuzz
