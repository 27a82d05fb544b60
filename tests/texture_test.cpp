#include "scene_fixtures.h"
#include "texels.h"

#include "taut/bsdf/metals.h"

#include <cstring>

using namespace taut;
using namespace taut::test;

namespace {

std::vector<unsigned char> toBytes(const std::string &text) {
    return {text.begin(), text.end()};
}

/// CRC-32 of PNG chunks.
std::uint32_t crc32(const std::string &bytes) {
    std::uint32_t crc = 0xffffffffU;
    for (const char c : bytes) {
        crc ^= static_cast<unsigned char>(c);
        for (int bit = 0; bit < 8; ++bit) crc = (crc & 1U) != 0 ? crc >> 1U ^ 0xedb88320U : crc >> 1U;
    }
    return ~crc;
}

/// A PNG whose header says another size.
std::string withPngSize(std::string png, std::uint32_t width, std::uint32_t height) {
    std::string chunk = "IHDR";
    append(chunk, width, true);
    append(chunk, height, true);
    chunk += png.substr(24, 5);
    append(chunk, crc32(chunk), true);
    return png.replace(12, chunk.size(), chunk);
}

/// An EXR whose data window says another size.
std::string withExrSize(std::string exr, std::int32_t width, std::int32_t height) {
    for (const char *name : {"dataWindow", "displayWindow"}) {
        const std::size_t at = exr.find(name);
        REQUIRE(at != std::string::npos);
        std::string window;
        appendAll<std::int32_t>(window, {0, 0, width - 1, height - 1});
        exr.replace(at + std::strlen(name) + 1 + 6 + 4, 16, window); // name\0 box2i\0 size
    }
    return exr;
}

} // namespace

TEST_CASE("texture colours are decoded from sRGB, alpha never", "[texture]") {
    Warnings warnings;
    const std::string folder = outputFolder("texture");
    const std::vector<float> texels{0, 10 / 255.0F, 128 / 255.0F, 128 / 255.0F, 1, 200 / 255.0F, 11 / 255.0F, 0};
    const std::string path = writeImage(folder, "rgba.png", 2, 1, 4, texels);
    // Reference values of IEC 61966-2-1.
    const std::vector<double> linear{0, 0.0030352698, 0.2158605, 128 / 255.0, 1, 0.57758044, 0.0033465358, 0};
    for (const ColorSpace space : {ColorSpace::Srgb, ColorSpace::Auto}) {
        const Texture texture = readTexture(path, space, warnings);
        REQUIRE(texture.channels == 4);
        REQUIRE(texture.texels.size() == 8);
        for (std::size_t i = 0; i < 8; ++i) CHECK(texture.texels[i] == Approx(linear[i]).epsilon(1e-5).margin(1e-9));
    }
    const Texture raw = readTexture(path, ColorSpace::Linear, warnings);
    for (std::size_t i = 0; i < 8; ++i) CHECK(raw.texels[i] == Approx(texels[i]).margin(1e-6));
    // PNG is sRGB at any depth, TIFF of 16 bits is linear, unless told otherwise.
    const std::string deep = writeImage(folder, "deep.png", 1, 1, 3, {0.25F, 0.5F, 1}, SampleType::UInt16);
    CHECK(readTexture(deep, ColorSpace::Auto, warnings).texels[1] == Approx(0.2140411).epsilon(1e-4));
    CHECK(readTexture(deep, ColorSpace::Srgb, warnings).texels[1] == Approx(0.2140411).epsilon(1e-4));
    CHECK(readTexture(deep, ColorSpace::Linear, warnings).texels[1] == Approx(0.5).epsilon(1e-4));
    const std::string deepTiff = writeImage(folder, "deep.tif", 1, 1, 3, {0.25F, 0.5F, 1}, SampleType::UInt16);
    CHECK(readTexture(deepTiff, ColorSpace::Auto, warnings).texels[1] == Approx(0.5).epsilon(1e-4));
    CHECK(readTexture(deepTiff, ColorSpace::Srgb, warnings).texels[1] == Approx(0.2140411).epsilon(1e-4));
}

TEST_CASE("texture channels", "[texture]") {
    Warnings warnings;
    const std::string folder = outputFolder("texture");
    const Texture grey = readTexture(writeImage(folder, "grey.png", 1, 1, 1, {0.6F}), ColorSpace::Linear, warnings);
    CHECK(grey.channels == 1);
    CHECK(lookup(grey, {0.5F, 0.5F}) == Vec4(0.6F, 0.6F, 0.6F, 1));
    const Texture greyAlpha = readTexture(writeImage(folder, "greyalpha.png", 1, 1, 2, {0.6F, 0.2F}), ColorSpace::Linear, warnings);
    CHECK(greyAlpha.channels == 4);
    CHECK(glm::length(lookup(greyAlpha, {0.5F, 0.5F}) - Vec4(0.6F, 0.6F, 0.6F, 0.2F)) < 1e-6F);
    const Texture rgb = readTexture(writeImage(folder, "rgb.exr", 1, 1, 3, {1, 2, 3}, SampleType::Float), ColorSpace::Auto, warnings);
    CHECK(lookup(rgb, {0.5F, 0.5F}) == Vec4(1, 2, 3, 1));
}

TEST_CASE("texture lookup is bilinear with v up", "[texture]") {
    Texture t;
    t.width = 2;
    t.height = 2;
    t.channels = 1;
    t.texels = {1, 2, 3, 4}; // top row 1 2, bottom row 3 4
    const auto at = [&](float u, float v) { return lookup(t, {u, v}).x; };
    CHECK(at(0.25F, 0.75F) == 1);
    CHECK(at(0.75F, 0.75F) == 2);
    CHECK(at(0.25F, 0.25F) == 3);
    CHECK(at(0.75F, 0.25F) == 4);
    CHECK(at(0.5F, 0.5F) == Approx(2.5));
    CHECK(at(0.5F, 0.75F) == Approx(1.5));
    CHECK(at(0, 0.75F) == Approx(1.5)); // repeated: halfway between the last and the first column
    CHECK(at(7.25F, -3.25F) == at(0.25F, 0.75F));
    t.sampler.wrapU = t.sampler.wrapV = TextureWrap::Clamp;
    CHECK(at(0, 0.75F) == 1);
    CHECK(at(-5, 9) == 1);
    CHECK(at(100, -100) == 4);
    CHECK(std::isfinite(at(NAN, INFINITY)));
}

TEST_CASE("samplers mirror, take the nearest texel, and move the place: glTF 2.0, 3.8.4 and KHR_texture_transform", "[texture]") {
    Texture t;
    t.width = t.height = 2;
    t.channels = 1;
    t.texels = {1, 2, 3, 4}; // top row 1 2, bottom row 3 4
    const auto at = [&](float u, float v) { return lookup(t, {u, v}).x; };
    t.sampler.wrapU = t.sampler.wrapV = TextureWrap::Mirror;
    CHECK(at(1.25F, 0.75F) == 2); // the last column again, then back
    CHECK(at(1.75F, 0.75F) == 1);
    CHECK(at(-0.25F, 0.75F) == 1);
    CHECK(at(0.25F, -0.25F) == 3);
    CHECK(at(0, 0.75F) == 1); // no blend across the border of mirror images
    CHECK(at(2.25F, 2.75F) == at(0.25F, 0.75F));
    t.sampler.nearest = true;
    CHECK(at(0.49F, 0.51F) == 1);
    CHECK(at(0.51F, 0.49F) == 4);
    t.sampler = {};
    t.sampler.nearest = true;
    setTextureTransform(t.sampler, {0.5F, 0}, 0, {1, 1});
    CHECK(at(0.25F, 0.75F) == 2); // half the image further along u
    CHECK(at(0.75F, 0.75F) == 1);
    setTextureTransform(t.sampler, {0, 0.5F}, 0, {1, 1});
    CHECK(at(0.25F, 0.75F) == 3); // v of an offset points down
    setTextureTransform(t.sampler, {0, 0}, 0, {2, 0.5F});
    CHECK(at(0.3F, 0.9F) == 2);
    // A quarter turn: (u, v) goes to (v, -u), v down. The upper right of the mesh, (0.75, 0.25), reads (0.25, -0.75), which repeats as
    // (0.25, 0.25).
    setTextureTransform(t.sampler, {0, 0}, kPi / 2, {1, 1});
    CHECK(at(0.75F, 0.75F) == 1);
    CHECK(at(0.75F, 0.25F) == 2);
    CHECK(at(0.25F, 0.75F) == 3);
    CHECK(at(0.25F, 0.25F) == 4);
    // Scale first, then the turn, then the offset.
    setTextureTransform(t.sampler, {0.25F, 0.125F}, kPi / 6, {2, 4});
    CHECK(close(DVec3(t.sampler.moveU), DVec3(2 * std::cos(kPi / 6), 4 * std::sin(kPi / 6), 0.25), 1e-6));
    CHECK(close(DVec3(t.sampler.moveV), DVec3(-2 * std::sin(kPi / 6), 4 * std::cos(kPi / 6), 0.125), 1e-6));
    t.sampler.uvSet = 1;
    UvPoint point(Vec2(0.1F));
    point.second = Vec2(0.3F, 0.8F);
    CHECK(lookup(t, point) == lookup(t, Vec2(0.3F, 0.8F)));
}

TEST_CASE("a texture in memory is read like its file", "[texture]") {
    Warnings warnings;
    const std::string folder = outputFolder("texture");
    for (const char *name : {"same.png", "same.exr", "same.hdr", "same.tif", "same.jpg", "same.webp", "same.tga", "same.bmp"}) {
        const std::string path = writeImage(
            folder, name, 3, 2, 3, std::vector<float>(18, 0.5F),
            std::strstr(name, "exr") != nullptr || std::strstr(name, "hdr") != nullptr ? SampleType::Float : SampleType::UInt8);
        const Texture file = readTexture(path, ColorSpace::Auto, warnings);
        const Texture memory = readTextureFromMemory("memory", toBytes(readBytes(path)), ColorSpace::Auto, warnings);
        CHECK(file.width == 3);
        CHECK(file.height == 2);
        CHECK(std::equal(file.texels.begin(), file.texels.end(), memory.texels.begin(), memory.texels.end()));
    }
}

TEST_CASE("textures of absurd size are refused before allocation", "[texture][malformed]") {
    Warnings warnings;
    const std::string folder = outputFolder("texture");
    const std::string png = readBytes(writeImage(folder, "small.png", 1, 1, 3, {1, 1, 1}));
    const std::string exr = readBytes(writeImage(folder, "small.exr", 1, 1, 3, {1, 1, 1}, SampleType::Float));
    const auto error = [&](const std::string &bytes) {
        return errorOf([&] { readTextureFromMemory("image", toBytes(bytes), ColorSpace::Auto, warnings); });
    };
    CHECK(error(withPngSize(png, 1, 1)).empty()); // the patch itself does no harm
    CHECK(says(error(withPngSize(png, 40000, 2)), "image: found 40000 x 2 texels", {"at most 32768"}));
    CHECK(says(error(withPngSize(png, 20000, 20000)), "image: found 20000 x 20000 texels", {"2^28"}));
    CHECK(says(error(withPngSize(png, 16000, 16000)), "image: found 16000 x 16000 texels", {"long enough"}));
    CHECK(error(withExrSize(exr, 1, 1)).empty());
    CHECK(!error(withExrSize(exr, 100000, 100000)).empty());
    CHECK(!error(withExrSize(exr, 16000, 16000)).empty());
    CHECK(!error(withExrSize(exr, 2000000000, 2000000000)).empty());
}

TEST_CASE("texture files that hold no image", "[texture][malformed]") {
    Warnings warnings;
    const std::string folder = outputFolder("texture");
    CHECK(says(errorOf([&] { readTexture(folder + "/absent.png", ColorSpace::Auto, warnings); }), "absent.png: found no such file", {}));
    CHECK(!errorOf([&] { readTexture(folder, ColorSpace::Auto, warnings); }).empty());
    CHECK(says(errorOf([&] { readTexture(writeTo(folder, "empty.png", ""), ColorSpace::Auto, warnings); }),
               "empty.png: found an empty file", {}));
    CHECK(says(errorOf([&] { readTexture(writeTo(folder, "text.png", "hello"), ColorSpace::Auto, warnings); }),
               "text.png: found a file of another format", {"PNG"}));
    const std::string nan = writeImage(folder, "nan.exr", 2, 2, 1, {1, 1, 1, INFINITY}, SampleType::Float);
    CHECK(readTexture(nan, ColorSpace::Auto, warnings).texels == std::vector<float>{1, 1, 1, 1});
    REQUIRE(warnings.lines.size() == 1);
    CHECK(says(warnings.lines[0], "nan.exr: of 4 texels: 1 infinite, held at 1 (the first in column 1, row 1)", {}));
}

TEST_CASE("metals match the measured tables", "[metals]") {
    struct Table {
        const char *name;
        const char *file;
    };
    for (const Table &table : {Table{"Au", "Au_Johnson"}, Table{"Ag", "Ag_Johnson"}, Table{"Cu", "Cu_Johnson"}, Table{"Al", "Al_Rakic"}}) {
        const auto path = asset(std::string("ref/ior/refractiveindex_") + table.file + ".yml");
        if (!path) continue;
        std::vector<DVec3> rows; // wavelength in micrometres, n, k
        std::ifstream in(*path);
        for (std::string line; std::getline(in, line);) {
            DVec3 row(0);
            if (std::sscanf(line.c_str(), " %lf %lf %lf", &row.x, &row.y, &row.z) == 3) rows.push_back(row);
        }
        REQUIRE(rows.size() > 20);
        const auto metal = std::find_if(metals().begin(), metals().end(), [&](const Metal &m) { return m.name == table.name; });
        REQUIRE(metal != metals().end());
        const double wavelengths[] = {0.65, 0.55, 0.45};
        for (int c = 0; c < 3; ++c) {
            const auto next = std::find_if(rows.begin(), rows.end(), [&](const DVec3 &row) { return row.x >= wavelengths[c]; });
            const DVec3 previous = *(next - 1);
            const DVec3 at = glm::mix(previous, *next, (wavelengths[c] - previous.x) / (next->x - previous.x));
            INFO(table.name << " at " << at.x);
            CHECK(metal->eta[c] == Approx(at.y).epsilon(0.02));
            CHECK(metal->k[c] == Approx(at.z).epsilon(0.02));
        }
    }
}

TEST_CASE("transition metals lie between the measured points", "[metals]") {
    // Johnson & Christy 1974: wavelength (micrometres), n, k on both sides of 650, 550 and 450 nm.
    struct Bracket {
        const char *name;
        int channel;
        DVec3 below, above;
    };
    const Bracket brackets[] = {
        {"Fe", 0, {0.617, 2.88, 3.05}, {0.659, 2.92, 3.10}}, {"Fe", 1, {0.549, 2.95, 2.93}, {0.582, 2.94, 2.99}},
        {"Fe", 2, {0.431, 2.48, 2.71}, {0.451, 2.59, 2.77}}, {"Ti", 0, {0.617, 2.67, 3.72}, {0.659, 2.76, 3.84}},
        {"Ti", 1, {0.549, 2.54, 3.43}, {0.582, 2.60, 3.58}}, {"Ti", 2, {0.431, 2.21, 3.01}, {0.451, 2.27, 3.04}},
        {"Cr", 0, {0.617, 3.17, 3.30}, {0.659, 3.09, 3.34}}, {"Cr", 1, {0.549, 3.18, 3.33}, {0.582, 3.22, 3.30}},
        {"Cr", 2, {0.431, 2.19, 3.04}, {0.451, 2.33, 3.14}},
    };
    const double wavelengths[] = {0.65, 0.55, 0.45};
    for (const Bracket &bracket : brackets) {
        const auto metal = std::find_if(metals().begin(), metals().end(), [&](const Metal &m) { return m.name == bracket.name; });
        REQUIRE(metal != metals().end());
        const DVec3 at =
            glm::mix(bracket.below, bracket.above, (wavelengths[bracket.channel] - bracket.below.x) / (bracket.above.x - bracket.below.x));
        CHECK(metal->eta[bracket.channel] == Approx(at.y).epsilon(1e-3));
        CHECK(metal->k[bracket.channel] == Approx(at.z).epsilon(1e-3));
    }
}
