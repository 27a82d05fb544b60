/// Image files as programs write them: half of one, parts and windows of OpenEXR, alpha, single texels that are no colour.

#include "scene_fixtures.h"
#include "texels.h"

#include <OpenImageIO/imageio.h>

using namespace taut;
using namespace taut::test;

namespace {

struct Loaded {
    Texture texture;
    std::vector<std::string> said;
};

Loaded load(const std::string &path, ColorSpace space = ColorSpace::Linear) {
    Warnings warnings;
    Loaded loaded{readTexture(path, space, warnings), {}};
    loaded.said = warnings.lines;
    return loaded;
}

std::string errorOfImage(const std::string &path) {
    return errorOf([&] { load(path); });
}

/// One part of an OpenEXR file: a data window in a display window, and a value of each channel, everywhere.
struct Part {
    std::string name;
    std::vector<std::string> channels;
    std::vector<float> values;
    int x = 0, y = 0, width = 2, height = 2;
    int fullX = 0, fullY = 0, fullWidth = 2, fullHeight = 2;
};

std::string writeExr(const std::string &name, const std::vector<Part> &parts) {
    const std::string path = outputFolder("read_texture") + "/" + name;
    std::vector<OIIO::ImageSpec> specs;
    for (const Part &part : parts) {
        OIIO::ImageSpec &spec = specs.emplace_back(part.width, part.height, static_cast<int>(part.channels.size()), OIIO::TypeDesc::FLOAT);
        spec.channelnames = part.channels;
        spec.x = part.x;
        spec.y = part.y;
        spec.full_x = part.fullX;
        spec.full_y = part.fullY;
        spec.full_width = part.fullWidth;
        spec.full_height = part.fullHeight;
        spec.attribute("oiio:subimagename", part.name);
    }
    const auto out = OIIO::ImageOutput::create(path);
    REQUIRE(out);
    REQUIRE((parts.size() == 1 ? out->open(path, specs[0]) : out->open(path, static_cast<int>(parts.size()), specs.data())));
    for (std::size_t p = 0; p < parts.size(); ++p) {
        if (p > 0) REQUIRE(out->open(path, specs[p], OIIO::ImageOutput::AppendSubimage));
        std::vector<float> texels;
        for (int i = 0; i < parts[p].width * parts[p].height; ++i)
            texels.insert(texels.end(), parts[p].values.begin(), parts[p].values.end());
        REQUIRE(out->write_image(OIIO::TypeDesc::FLOAT, texels.data()));
    }
    REQUIRE(out->close());
    return path;
}

Vec4 centre(const Texture &texture) {
    return lookup(texture, {0.5F, 0.5F});
}

std::vector<float> noise(int count) {
    std::vector<float> texels;
    for (int i = 0; i < count; ++i) texels.push_back(static_cast<float>(i * 7919 % 256) / 255);
    return texels;
}

} // namespace

TEST_CASE("Image files that end early are refused", "[texture][malformed]") {
    if (const auto scene = caseFile("jpeg-half/s.toml")) {
        Warnings warnings;
        CHECK(says(errorOf([&] { loadScene(*scene, {}, warnings); }), "t.jpg: found an image that can't be decoded",
                   {"ends before the end"}));
    }
    const std::string folder = outputFolder("read_texture");
    for (const std::string name : {"cut.jpg", "cut.png", "cut.tif", "cut.tga", "cut.bmp", "cut.webp", "cut.hdr", "cut.exr"}) {
        const bool isFloat = name == "cut.hdr" || name == "cut.exr";
        const std::string whole = readBytes(
            writeImage(folder, "whole_" + name, 64, 48, 3, noise(64 * 48 * 3), isFloat ? SampleType::Float : SampleType::UInt8));
        CAPTURE(name, whole.size());
        REQUIRE(errorOfImage(writeTo(folder, name, whole)).empty());
        for (const double share : {0.1, 0.3, 0.5, 0.7, 0.9}) {
            CAPTURE(share);
            const std::string cut = whole.substr(0, static_cast<std::size_t>(static_cast<double>(whole.size()) * share));
            CHECK(says(errorOfImage(writeTo(folder, name, cut)), name + ": found", {}));
        }
    }
    // What follows the image has no say, nor has a picture within the picture.
    const std::string jpeg = readBytes(folder + "/whole_cut.jpg");
    CHECK(errorOfImage(writeTo(folder, "tail.jpg", jpeg + "trailing \xff\xd8\xff")).empty());
    const std::string inner = "\xff\xe1" + std::string(1, '\0') + "\x08\xff\xd8\xff\xd9\xff\xff";
    const std::string nested = jpeg.substr(0, 2) + inner + jpeg.substr(2);
    CHECK(load(writeTo(folder, "nested.jpg", nested)).texture.texels == load(folder + "/whole_cut.jpg").texture.texels);
    CHECK(!errorOfImage(writeTo(folder, "nested.jpg", nested.substr(0, nested.size() / 2))).empty());
}

TEST_CASE("The picture of an OpenEXR file is the part with colours", "[texture][exr]") {
    if (const auto path = caseFile("exr-parts/m.exr")) {
        const Loaded loaded = load(*path, ColorSpace::Auto);
        CHECK(centre(loaded.texture) == Vec4(0.25F, 0.5F, 0.75F, 1));
        REQUIRE(loaded.said.size() == 1);
        CHECK_THAT(loaded.said[0], Catch::EndsWith("m.exr: read 'R', 'G', 'B' of part 'rgb'; left out 'Z' of part 'depth'"));
    }
    struct Case {
        std::vector<Part> parts;
        Vec4 found;
        std::string said;
    };
    const Case cases[] = {
        {{{"a", {"R", "G", "B"}, {1, 2, 3}}}, {1, 2, 3, 1}, ""},
        {{{"a", {"R", "G", "B", "A"}, {1, 2, 3, 0.5F}}}, {1, 2, 3, 0.5F}, ""},
        {{{"a", {"R", "G", "B", "Z"}, {1, 2, 3, 4}}}, {1, 2, 3, 1}, "left out 'Z'"},
        {{{"n", {"N.X", "N.Y", "N.Z"}, {7, 8, 9}}, {"a", {"R", "G", "B", "A"}, {1, 2, 3, 0.5F}}}, {1, 2, 3, 0.5F}, "of part 'a'"},
        {{{"z", {"Z"}, {9}}, {"y", {"Y"}, {3}}}, {3, 3, 3, 1}, "read 'Y' of part 'y'"},
        {{{"z", {"Z"}, {9}}, {"l", {"l.R", "l.G", "l.B"}, {1, 2, 3}}}, {1, 2, 3, 1}, "of part 'l'"},
        {{{"a", {"diffuse.R", "diffuse.G", "diffuse.B", "gloss.R", "gloss.G", "gloss.B"}, {1, 2, 3, 4, 5, 6}}},
         {1, 2, 3, 1},
         "left out 'gloss.R'"},
        {{{"a", {"height"}, {5}}}, {5, 5, 5, 1}, ""},
        {{{"a", {"U", "V"}, {5, 6}}}, {5, 6, 0, 1}, ""},
        {{{"a", {"Y", "A"}, {5, 0.5F}}}, {5, 5, 5, 0.5F}, ""},
    };
    int number = 0;
    for (const Case &c : cases) {
        CAPTURE(number);
        const Loaded loaded = load(writeExr("parts_" + std::to_string(number++) + ".exr", c.parts));
        CHECK(centre(loaded.texture) == c.found);
        REQUIRE(loaded.said.size() == (c.said.empty() ? 0 : 1));
        if (!c.said.empty()) CHECK_THAT(loaded.said[0], Catch::Contains(c.said));
    }
    CHECK(says(errorOfImage(writeExr("chroma.exr", {{"", {"Y", "RY", "BY"}, {1, 0, 0}}})), "luminance and chroma", {"R, G and B"}));
}

TEST_CASE("An OpenEXR picture fills its display window", "[texture][exr]") {
    const std::vector<std::string> rgb{"R", "G", "B"};
    // Data in a quarter of the window: the rest is black, and said to be.
    const Loaded small = load(writeExr("small.exr", {{"", rgb, {1, 2, 3}, 12, 21, 2, 1, 10, 20, 4, 2}}));
    CHECK(small.texture.width == 4);
    CHECK(small.texture.height == 2);
    for (int y = 0; y < 2; ++y)
        for (int x = 0; x < 4; ++x)
            CHECK(small.texture.texels[static_cast<std::size_t>(3 * (4 * y + x) + 1)] == (y == 1 && x >= 2 ? 2.0F : 0.0F));
    REQUIRE(small.said.size() == 1);
    CHECK_THAT(small.said[0], Catch::EndsWith(": its data cover 2 x 1 texels of its display window of 4 x 2; the rest is black"));
    // Data beyond the window on all sides, as of a renderer's overscan: what is seen is the window.
    const std::string folder = outputFolder("read_texture");
    const std::string path = folder + "/overscan.exr";
    OIIO::ImageSpec spec(4, 4, 3, OIIO::TypeDesc::FLOAT);
    spec.x = spec.y = -1;
    spec.full_width = spec.full_height = 2;
    std::vector<float> texels;
    for (int i = 0; i < 48; ++i) texels.push_back(static_cast<float>(i));
    const auto out = OIIO::ImageOutput::create(path);
    REQUIRE(out);
    REQUIRE(out->open(path, spec));
    REQUIRE(out->write_image(OIIO::TypeDesc::FLOAT, texels.data()));
    REQUIRE(out->close());
    const Loaded over = load(path);
    CHECK(over.said.empty());
    CHECK(over.texture.texels == std::vector<float>{15, 16, 17, 18, 19, 20, 27, 28, 29, 30, 31, 32});
    CHECK(says(errorOfImage(writeExr("apart.exr", {{"", rgb, {1, 2, 3}, 10, 10, 2, 2, 0, 0, 2, 2}})), "outside the display window", {}));
}

TEST_CASE("Colours are those that the file stores, whatever their alpha", "[texture]") {
    const std::string folder = outputFolder("read_texture");
    const std::vector<float> texels{1, 0.5F, 0.25F, 0, 0.2F, 0.4F, 0.6F, 0.2F, 1, 1, 1, 1, 0, 0, 0, 0.8F};
    for (const std::string name : {"alpha.png", "alpha.tif", "alpha.tga"}) {
        CAPTURE(name);
        const Texture texture = load(writeImage(folder, name, 2, 2, 4, texels)).texture;
        REQUIRE(texture.channels == 4);
        for (std::size_t i = 0; i < texels.size(); ++i) CHECK(texture.texels[i] == Approx(texels[i]).margin(0.003));
    }
    // A lossless WebP (RFC 9649, VP8L) of one texel, 200 100 50 with alpha 0: each colour is a code of one symbol.
    std::string bits;
    const auto put = [&](unsigned value, int count) {
        for (int i = 0; i < count; ++i) bits += (value >> static_cast<unsigned>(i) & 1U) != 0 ? '1' : '0';
    };
    put(0, 14); // width - 1
    put(0, 14);
    put(1, 1); // alpha is used
    put(0, 3);
    put(0, 1);                                                // no transform
    put(0, 1);                                                // no colour cache
    put(0, 1);                                                // no meta prefix codes
    for (const unsigned symbol : {100U, 200U, 50U, 0U, 0U}) { // green, red, blue, alpha, distance
        put(1, 1);                                            // a simple code
        put(0, 1);                                            // of one symbol
        put(1, 1);                                            // of eight bits
        put(symbol, 8);
    }
    std::string data = "\x2f";
    for (std::size_t i = 0; i < bits.size(); i += 8) {
        unsigned byte = 0;
        for (std::size_t k = 0; k < 8 && i + k < bits.size(); ++k) byte |= (bits[i + k] == '1' ? 1U : 0U) << k;
        data += static_cast<char>(byte);
    }
    if (data.size() % 2 != 0) data += '\0';
    std::string webp = "RIFF";
    append(webp, static_cast<std::uint32_t>(4 + 8 + data.size()));
    webp += "WEBPVP8L";
    append(webp, static_cast<std::uint32_t>(data.size()));
    webp += data;
    const Texture texture = load(writeTo(folder, "alpha.webp", webp)).texture;
    REQUIRE(texture.channels == 4);
    CHECK(texture.texels[0] == Approx(200 / 255.0));
    CHECK(texture.texels[1] == Approx(100 / 255.0));
    CHECK(texture.texels[2] == Approx(50 / 255.0));
    CHECK(texture.texels[3] == 0);
}

TEST_CASE("Kinds of images are told by their bytes, TGA by its name", "[texture]") {
    const std::string folder = outputFolder("read_texture");
    const std::vector<float> grey(12, 0.5F);
    for (const std::string extension : {"png", "tif", "bmp", "webp", "jpg"}) {
        const std::string bytes = readBytes(writeImage(folder, "kind." + extension, 2, 2, 3, grey));
        CHECK(centre(load(writeTo(folder, "kind.tga", bytes)).texture).x == Approx(0.5).margin(0.01));
        CHECK(centre(load(writeTo(folder, "kind.unknown", bytes), ColorSpace::Auto).texture).x == Approx(0.2158).margin(0.01));
    }
    // Version 1 of TGA has no signature at all: 2 x 1 texels of blue, green, red.
    const std::string tga = std::string("\0\0\2\0\0\0\0\0\0\0\0\0\2\0\1\0\x18\0", 18) + std::string("\0\0\xff\xff\0\0", 6);
    CHECK(lookup(load(writeTo(folder, "old.TGA", tga)).texture, {0.25F, 0.5F}) == Vec4(1, 0, 0, 1));
    CHECK(says(errorOfImage(writeTo(folder, "old.img", tga)), "a file of another format", {"TGA or BMP"}));
    // A BMP of 32 bits whose fourth byte nobody set is opaque.
    std::string bmp = "BM";
    appendAll<std::uint32_t>(bmp, {58, 0, 54, 40, 1, 1});
    appendAll<std::uint16_t>(bmp, {1, 32});
    appendAll<std::uint32_t>(bmp, {0, 4, 0, 0, 0, 0});
    const std::string header = bmp;
    bmp += std::string("\x00\x80\xff\x00", 4); // blue, green, red
    CHECK(glm::length(centre(load(writeTo(folder, "zero.bmp", bmp)).texture) - Vec4(1, 128 / 255.0F, 0, 1)) < 1e-5F);
    std::string huge = header;
    huge.replace(18, 8, std::string("\xff\xff\xff\x7f\xff\xff\xff\x7f", 8));
    CHECK(says(errorOfImage(writeTo(folder, "huge.bmp", huge + "xxxx")), "2147483647 x 2147483647", {}));
}

TEST_CASE("A PNG that says its values are linear is", "[texture]") {
    const std::string folder = outputFolder("read_texture");
    const std::string path = folder + "/gamma.png";
    for (const auto &[space, expected] : {std::pair("Linear", 0.5), std::pair("sRGB", 0.2140411)}) {
        OIIO::ImageSpec spec(1, 1, 3, OIIO::TypeDesc::UINT16);
        spec.attribute("oiio:ColorSpace", space);
        const auto out = OIIO::ImageOutput::create(path);
        REQUIRE(out);
        REQUIRE(out->open(path, spec));
        const std::vector<float> half(3, 0.5F);
        REQUIRE(out->write_image(OIIO::TypeDesc::FLOAT, half.data()));
        REQUIRE(out->close());
        CAPTURE(space);
        CHECK(load(path, ColorSpace::Auto).texture.texels[0] == Approx(expected).epsilon(1e-3));
    }
}
