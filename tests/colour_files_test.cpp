// Image files of every kind that is written, opened by other programs; what the command says of them.

#include "cli_fixtures.h"

#include "taut/base/half.h"
#include "taut/base/srgb.h"

#include <cmath>
#include <iostream>

using namespace taut;
using namespace taut::test;

namespace {

/// 64 x 32, smooth, with values below 0 and beyond those of half floats; a channel of data beside the colours.
Image testImage() {
    Image image;
    image.width = 64;
    image.height = 32;
    image.window = {0, 0, 64, 32};
    image.channels = {"R", "G", "B", "A", "Z"};
    for (int y = 0; y < 32; ++y)
        for (int x = 0; x < 64; ++x) {
            const float u = static_cast<float>(x) / 63, v = static_cast<float>(y) / 31;
            image.values.insert(image.values.end(), {u, 0.3F * v, 0.2F + 0.1F * u * v, 1, 100.001F + u});
        }
    image.values[0] = -0.25F;
    image.values[5] = 1e6F;
    return image;
}

bool isThere(const std::string &program, const std::string &option) {
    if (runProgram({program, option}, 60).exitCode == 0) return true;
    std::cout << "SKIPPED: no " << program << " on this machine" << std::endl;
    return false;
}

std::string infoOf(const std::string &path) {
    const CommandResult result = runProgram({"oiiotool", "--info", "-v", path}, 60);
    requireSuccess(result);
    return result.out;
}

} // namespace

TEST_CASE("colour files: EXR of half and float, of every compression, is what oiiotool reads", "[colour]") {
    const std::string folder = freshFolder("exr");
    const Image image = testImage();
    const bool oiiotool = isThere("oiiotool", "--version");
    for (const std::string compression : {"none", "rle", "zips", "zip", "piz", "pxr24", "b44", "b44a", "dwaa", "dwab", "dwaa:10"})
        for (const bool half : {false, true}) {
            CAPTURE(compression, half);
            ImageSettings settings;
            settings.exrCompression = compression;
            settings.exrHalf = half;
            settings.view.view = "filmic"; // an EXR stays scene linear
            settings.view.exposure = 3;
            const std::string path = folder + "/image.exr";
            writeImage(path, image, {{"taut:spp", "4"}}, settings);
            const Image read = readImage(path);
            REQUIRE(read.channels == image.channels);
            const std::string name = compression.substr(0, compression.find(':'));
            const bool exact = name == "none" || name == "rle" || name == "zips" || name == "zip" || name == "piz";
            for (std::size_t i = 0; i < image.values.size(); ++i) {
                const bool isHalf = half && i % 5 < 4;
                const float wanted = isHalf ? std::fmin(image.values[i], 65504.0F) : image.values[i];
                const float tolerance = i % 5 == 4 ? 1e-4F * wanted : isHalf ? std::fabs(wanted) / 2048 : 0;
                if (exact || i % 5 == 4) REQUIRE(std::fabs(read.values[i] - wanted) <= (name == "pxr24" ? 1e-2F : tolerance));
                if (!exact && i > 400 && i % 5 < 3) REQUIRE(std::fabs(read.values[i] - wanted) <= 0.05F);
            }
            CHECK(metadata(path, "taut:view") == "absent");
            CHECK(metadata(path, "taut:spp") == "4");
            CHECK(metadata(path, "compression").find(name) == 0);
            if (!oiiotool) continue;
            const std::string info = infoOf(path);
            CHECK(info.find("compression: \"" + name) != std::string::npos);
            CHECK(info.find(half ? "R (half), G (half), B (half), A (half), Z (float)" : "float openexr") != std::string::npos);
            CHECK(info.find("oiio:ColorSpace: \"Linear\"") != std::string::npos);
        }
}

TEST_CASE("colour files: numbers of objects are not stored by what changes them", "[colour]") {
    const std::string folder = freshFolder("crypto");
    Image image = testImage();
    image.channels = {"R", "G", "B", "CryptoObject00.R", "CryptoObject00.G"};
    for (const std::string compression : {"dwaa", "dwab:10", "b44", "b44a", "pxr24"}) {
        ImageSettings settings;
        settings.exrCompression = compression;
        CHECK_THROWS_AS(writeImage(folder + "/a.exr", image, {}, settings), InputError);
    }
    ImageSettings settings;
    settings.exrHalf = true; // they stay float
    writeImage(folder + "/a.exr", image, {}, settings);
    CHECK(readImage(folder + "/a.exr").values[4] == image.values[4]);
}

TEST_CASE("colour files: PNG of 8 and 16 bits, without options what it always was", "[colour]") {
    const std::string folder = freshFolder("png");
    const Image image = testImage();
    writeImage(folder + "/plain.png", image);
    const Image plain = readImage(folder + "/plain.png");
    for (std::size_t i = 0; i < plain.values.size(); ++i)
        REQUIRE(std::lround(255 * plain.values[i]) == std::lround(255 * srgbFromLinear(image.values[i / 3 * 5 + i % 3])));
    for (const char *key : {"taut:view", "taut:exposure", "taut:display", "taut:ocio"})
        CHECK(metadata(folder + "/plain.png", key) == "absent");

    ImageSettings settings;
    settings.pngBits = 16;
    settings.view.exposure = -1;
    writeImage(folder + "/deep.png", image, {}, settings);
    const Image deep = readImage(folder + "/deep.png");
    for (std::size_t i = 0; i < deep.values.size(); ++i)
        REQUIRE(std::lround(65535 * deep.values[i]) == std::lround(65535 * srgbFromLinear(image.values[i / 3 * 5 + i % 3] / 2)));
    CHECK(metadata(folder + "/deep.png", "taut:exposure") == "-1");
    CHECK(metadata(folder + "/deep.png", "taut:view") == "standard");
    if (isThere("oiiotool", "--version")) {
        CHECK(infoOf(folder + "/plain.png").find("3 channel, uint8 png") != std::string::npos);
        CHECK(infoOf(folder + "/deep.png").find("3 channel, uint16 png") != std::string::npos);
        CHECK(infoOf(folder + "/deep.png").find("oiio:ColorSpace: \"sRGB\"") != std::string::npos);
    }
}

TEST_CASE("colour files: ffprobe and Blender open them", "[colour][blender]") {
    const std::string folder = freshFolder("readers");
    Image image = testImage(); // without its data: ffmpeg 5.1 reads DWAA of one type of channel alone
    image.channels.pop_back();
    for (std::size_t i = 64 * 32; i-- > 0;) image.values.erase(image.values.begin() + static_cast<std::ptrdiff_t>(5 * i + 4));
    struct Kind {
        const char *name, *bits, *compression, *pixels;
    };
    const Kind kinds[] = {{"a.png", "8", "zip", "rgb24"},          {"b.png", "16", "zip", "rgb48be"},
                          {"c.exr", "half", "zip", "gbrapf32le"},  {"d.exr", "float", "piz", "gbrapf32le"},
                          {"e.exr", "half", "dwaa", "gbrapf32le"}, {"f.exr", "float", "dwab", ""}};
    for (const Kind &kind : kinds) {
        ImageSettings settings;
        setBits(kind.bits, {}, settings);
        settings.exrCompression = kind.compression;
        writeImage(folder + "/" + kind.name, image, {}, settings);
    }
    if (isThere("ffprobe", "-version"))
        for (const Kind &kind : kinds) {
            if (*kind.pixels == '\0') continue; // of ffmpeg 5.1, which knows no DWAB
            CAPTURE(kind.name);
            const CommandResult result = runProgram(
                {"ffprobe", "-v", "error", "-show_entries", "stream=width,height,pix_fmt", "-of", "csv=p=0", folder + "/" + kind.name}, 60);
            requireSuccess(result);
            CHECK(result.out.find("64,32," + std::string(kind.pixels)) == 0);
        }
    if (!isThere("blender", "--version")) return;
    std::string script = "import bpy\nfor name in '";
    for (const Kind &kind : kinds) script += std::string(kind.name) + " ";
    script += "'.split():\n    image = bpy.data.images.load('" + folder +
              "/' + name)\n    x = 4 * (64 * 16 + 32)\n"
              "    print('SEEN', name, image.size[0], image.size[1], image.is_float, *image.pixels[x:x + 3])\n";
    writeBytes(folder + "/read.py", script);
    const CommandResult blender =
        runProgram({"blender", "-b", "-noaudio", "--factory-startup", "--python-exit-code", "1", "--python", folder + "/read.py"}, 200);
    requireSuccess(blender);
    int found = 0;
    for (const std::string &line : linesOf(blender.out)) {
        if (line.find("SEEN ") != 0) continue;
        ++found;
        std::istringstream words(line.substr(5));
        std::string name, isFloat;
        int width = 0, height = 0;
        float r = 0, g = 0, b = 0;
        words >> name >> width >> height >> isFloat >> r >> g >> b;
        CAPTURE(line);
        CHECK((width == 64 && height == 32));
        const std::size_t pixel = 4 * (64 * 15 + 32); // rows from the bottom there
        const bool exr = name.find("exr") != std::string::npos;
        // Integers are as stored; Blender makes floats of 16 bits, linear ones.
        const auto wanted = [&](float linear) { return exr || isFloat == "True" ? linear : srgbFromLinear(linear); };
        CHECK(r == Approx(wanted(image.values[pixel])).margin(5e-3));
        CHECK(g == Approx(wanted(image.values[pixel + 1])).margin(5e-3));
        CHECK(b == Approx(wanted(image.values[pixel + 2])).margin(5e-3));
    }
    CHECK(found == 6);
}

TEST_CASE("colour files: the table [image], and options that win over it", "[colour][cli]") {
    const Workplace place("image_table");
    writeBytes(place.scene, plateScene() + "[image]\nexposure = 1\nview = \"filmic\"\nbits = [16, \"half\"]\ncompression = \"piz\"\n");
    const Image linear = [&] {
        renderedValues(place, "a.exr", {});
        return readImage(place.path("a.exr"));
    }();
    CHECK(metadata(place.path("a.exr"), "compression") == "piz");
    CHECK(metadata(place.path("a.exr"), "taut:view") == "absent");
    renderedValues(place, "a.png", {});
    CHECK(metadata(place.path("a.png"), "taut:view") == "filmic");
    CHECK(metadata(place.path("a.png"), "taut:exposure") == "1");
    const Image shown = readImage(place.path("a.png"));
    const auto curve = [](double x) { return x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14); };
    for (int x = 0; x < 24; x += 5) {
        const double wanted = static_cast<double>(srgbFromLinear(static_cast<float>(std::min(1.0, curve(2 * valueAt(linear, x, 8, "G"))))));
        CHECK(valueAt(shown, x, 8, "G") == Approx(wanted).margin(2e-3)); // a half float of the light
    }
    renderedValues(place, "b.png", {"--exposure", "-1", "--view", "standard", "--bits", "8"});
    CHECK(metadata(place.path("b.png"), "taut:exposure") == "-1");
    renderedValues(place, "c.png", {"-D", "image.view=aces", "-D", "image.exposure=0"});
    CHECK(metadata(place.path("c.png"), "taut:view") == "aces");

    const auto fails = [&](const Arguments &more, const std::string &part) {
        Arguments arguments{"render", place.scene, "-q"};
        arguments.insert(arguments.end(), more.begin(), more.end());
        checkUsageError(runTaut(arguments), part);
    };
    const std::string png = place.path("x.png"), exr = place.path("x.exr");
    fails({"-o", png, "--view", "acs"}, "did you mean 'aces'?");
    fails({"-o", exr, "--bits", "16"}, "found 16, but no .png among the outputs");
    fails({"-o", png, "--bits", "half"}, "half or float for .exr");
    fails({"-o", png, "--bits", "haf"}, "did you mean 'half'?");
    fails({"-o", exr, "--compression", "dwa"}, "did you mean 'dwaa'?");
    fails({"-o", exr, "--compression", "dwaa:x"}, "a level from 0 to 100000");
    fails({"-o", exr, "--compression", "zip:4"}, "only dwaa and dwab have a level");
    fails({"-o", png, "--exposure", "60"}, "--exposure");
    fails({"-o", png, "--ocio", place.path("none.ocio")}, "none.ocio");
    fails({"-o", png, "-D", "image.expsure=1"}, "did you mean 'exposure'?");
    fails({"-o", png, "-D", "image.exposure=bright"}, "image.exposure");
    fails({"-o", png, "-D", "image.bits=12"}, "image.bits");
    CHECK(!fs::exists(png));
    CHECK(!fs::exists(exr));
}

TEST_CASE("colour files: what is merged has the view and the metadata of what was never split", "[colour][cli]") {
    const Workplace place("merged_view");
    const Arguments look{"--view", "aces", "--exposure", "0.5", "--bits", "half,16", "--compression", "zips", "--spp", "8", "-q"};
    const auto render = [&](const std::string &name, Arguments more) {
        more.insert(more.begin(), {"render", place.scene, "-o", place.path(name + ".png"), "-o", place.path(name + ".exr")});
        more.insert(more.end(), look.begin(), look.end());
        requireSuccess(runTaut(more));
    };
    render("whole", {});
    render("parts", {"--shard", "1/2", "--shard-by", "samples"});
    render("parts", {"--shard", "2/2", "--shard-by", "samples"});
    const Arguments merge{"merge",
                          place.path("parts.png.1-of-2.shard"),
                          place.path("parts.png.2-of-2.shard"),
                          "-q",
                          "-o",
                          place.path("parts.png"),
                          "-o",
                          place.path("parts.exr")};
    requireSuccess(runTaut(merge));
    CHECK(readBytes(place.path("parts.png")) == readBytes(place.path("whole.png")));
    CHECK(readBytes(place.path("parts.exr")) == readBytes(place.path("whole.exr")));
    CHECK(metadata(place.path("parts.png"), "taut:view") == "aces");
    Arguments other = merge;
    other.insert(other.end(), {"--view", "filmic"});
    requireSuccess(runTaut(other));
    CHECK(metadata(place.path("parts.png"), "taut:view") == "filmic");
    CHECK(metadata(place.path("parts.png"), "taut:exposure") == "0.5");
}
