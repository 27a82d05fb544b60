// Contact sheets: where pictures are, what is drawn of them, and what the command says.

#include "cli_fixtures.h"

#include "taut/base/srgb.h"

#include <cmath>

using namespace taut;
using namespace taut::test;

namespace {

/// A picture of one grey, of sRGB of 8 bits.
void writeGrey(const std::string &path, int width, int height, int grey) {
    Image image;
    image.width = width;
    image.height = height;
    image.window = {0, 0, width, height};
    image.channels = {"R", "G", "B"};
    image.values.assign(static_cast<std::size_t>(3 * width * height), linearFromSrgb(static_cast<float>(grey) / 255));
    writeImage(path, image);
}

int greyAt(const Image &image, int x, int y) {
    return static_cast<int>(std::lround(255 * valueAt(image, x, y, "G")));
}

constexpr int kGap = 12, kBackground = 39; // sRGB of the background, 0.02 linear

} // namespace

TEST_CASE("sheet: pictures are in their order, with a gap, whatever their sizes", "[sheet]") {
    const std::string folder = freshFolder("order");
    for (int i = 0; i < 5; ++i) writeGrey(folder + "/" + std::to_string(i) + ".png", i == 2 ? 40 : 80, i == 3 ? 20 : 45, 60 + 30 * i);
    Arguments arguments{"sheet", "0.png", "1.png", "2.png", "3.png", "4.png", "--columns", "3", "--no-labels", "-o", "sheet.png"};
    requireSuccess(runTaut(arguments, folder));
    const Image sheet = readImage(folder + "/sheet.png");
    CHECK(sheet.width == kGap + 3 * (80 + kGap));
    CHECK(sheet.height == kGap + 2 * (45 + kGap));
    for (int i = 0; i < 5; ++i) {
        CAPTURE(i);
        const int x = kGap + i % 3 * (80 + kGap) + 40, y = kGap + i / 3 * (45 + kGap) + 22;
        CHECK(greyAt(sheet, x, y) == 60 + 30 * i);
    }
    CHECK(greyAt(sheet, 0, 0) == kBackground);
    CHECK(greyAt(sheet, kGap + 80 + 2, kGap + 10) == kBackground);
    const int third = kGap + 2 * (80 + kGap); // 40 wide: in the middle of its cell
    CHECK(greyAt(sheet, third + 19, kGap + 22) == kBackground);
    CHECK(greyAt(sheet, third + 20, kGap + 22) == 120);
    CHECK(greyAt(sheet, third + 59, kGap + 22) == 120);
    CHECK(greyAt(sheet, third + 60, kGap + 22) == kBackground);
    CHECK(greyAt(sheet, third + 40, kGap + 45 + kGap + 22) == kBackground); // the last cell is empty
    const std::string bytes = readBytes(folder + "/sheet.png");
    requireSuccess(runTaut(arguments, folder));
    CHECK(readBytes(folder + "/sheet.png") == bytes);
}

TEST_CASE("sheet: larger pictures are reduced to the cell by the mean of their light", "[sheet]") {
    const std::string folder = freshFolder("reduced");
    Image stripes; // black and white, pixel by pixel
    stripes.width = 64;
    stripes.height = 32;
    stripes.window = {0, 0, 64, 32};
    stripes.channels = {"R", "G", "B"};
    for (int i = 0; i < 64 * 32; ++i) stripes.values.insert(stripes.values.end(), 3, static_cast<float>(i % 2));
    writeImage(folder + "/stripes.png", stripes);
    writeImage(folder + "/stripes.exr", stripes);
    requireSuccess(
        runTaut({"sheet", "stripes.png", "stripes.exr", "--cell", "32", "--columns", "2", "--no-labels", "-o", "sheet.png"}, folder));
    const Image sheet = readImage(folder + "/sheet.png");
    CHECK(sheet.width == 3 * kGap + 2 * 32);
    CHECK(sheet.height == 2 * kGap + 16);
    const int half = static_cast<int>(std::lround(255 * srgbFromLinear(0.5F)));
    for (const int x : {0, 7, 31, 32 + kGap, 63 + kGap})
        for (const int y : {0, 15}) CHECK(greyAt(sheet, kGap + x, kGap + y) == half);
}

TEST_CASE("sheet: labels are the names of the files", "[sheet]") {
    const std::string folder = freshFolder("labels");
    fs::create_directories(folder + "/a");
    fs::create_directories(folder + "/b");
    for (const char *name : {"one.png", "two.png", "a/0001.png", "b/0001.png", "a/0002.png"}) writeGrey(folder + "/" + name, 96, 54, 128);
    const auto make = [&](Arguments arguments) {
        arguments.insert(arguments.begin(), "sheet");
        arguments.insert(arguments.end(), {"-o", "sheet.png"});
        requireSuccess(runTaut(arguments, folder));
        return readImage(folder + "/sheet.png");
    };
    /// Dots of letters below the cell.
    const auto letters = [&](const Image &sheet, int cell) {
        int count = 0;
        for (int y = kGap + 54; y < kGap + 54 + 12; ++y)
            for (int x = kGap + cell * (96 + kGap); x < kGap + cell * (96 + kGap) + 96; ++x)
                if (greyAt(sheet, x, y) > 150) ++count;
        return count;
    };
    const Image named = make({"one.png", "two.png", "--columns", "2"});
    CHECK(named.height == 2 * kGap + 54 + 12);
    CHECK(letters(named, 0) == 12 + 12 + 14); // dots of o, n, e
    CHECK(letters(named, 1) > 25);
    CHECK(named.values == make({"one.png", "two.png", "--columns", "2", "--label", "one", "--label", "two"}).values);
    CHECK(named.values != make({"one.png", "two.png", "--columns", "2", "--label", "one", "--label", "tow"}).values);
    CHECK(make({"a/0001.png", "b/0001.png", "--columns", "2"}).values ==
          make({"a/0001.png", "b/0001.png", "--columns", "2", "--label", "a/0001", "--label", "b/0001"}).values);
    CHECK(make({"a/####.png", "--frames", "1-2", "--columns", "2"}).values == make({"a/0001.png", "a/0002.png", "--columns", "2"}).values);
    // A name that is too long loses its middle, and stays in its cell.
    const Image lengthy = make({"one.png", "two.png", "--columns", "2", "--label", std::string(200, 'W'), "--label", "u\xc3\xa4"});
    CHECK(letters(lengthy, 0) > 100);
    for (int y = kGap + 54; y < kGap + 66; ++y) CHECK(greyAt(lengthy, kGap + 96 + kGap / 2, y) == kBackground);
    CHECK(lengthy.values == make({"one.png", "two.png", "--columns", "2", "--label", std::string(200, 'W'), "--label", "u?"}).values);
}

TEST_CASE("sheet: EXR go through the view", "[sheet][colour]") {
    const std::string folder = freshFolder("view");
    Image image;
    image.width = image.height = 16;
    image.window = {4, 0, 16, 16}; // a crop: black beside it
    image.channels = {"A", "R", "G", "B"};
    for (int i = 0; i < 12 * 16; ++i) image.values.insert(image.values.end(), {1, 0.18F, 0.18F, 0.18F});
    writeImage(folder + "/crop.exr", image);
    requireSuccess(runTaut({"sheet", "crop.exr", "--view", "filmic", "--exposure", "1", "--no-labels", "-o", "sheet.png"}, folder));
    const Image sheet = readImage(folder + "/sheet.png");
    const double x = 0.36, curve = x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14);
    CHECK(greyAt(sheet, kGap + 8, kGap + 8) == std::lround(255 * srgbFromLinear(static_cast<float>(curve))));
    CHECK(greyAt(sheet, kGap + 1, kGap + 8) == 0);
    CHECK(metadata(folder + "/sheet.png", "taut:view") == "filmic");
}

TEST_CASE("sheet: mistakes are one line", "[sheet]") {
    const std::string folder = freshFolder("mistakes");
    writeGrey(folder + "/one.png", 8, 8, 100);
    writeBytes(folder + "/text.png", "not a picture");
    const auto fails = [&](Arguments arguments, const std::string &part) {
        arguments.insert(arguments.begin(), "sheet");
        checkUsageError(runTaut(arguments, folder), part);
        CHECK(!fs::exists(folder + "/sheet.png"));
    };
    fails({"one.png", "absent.png", "-o", "sheet.png"}, "absent.png");
    fails({"one.png", "text.png", "-o", "sheet.png"}, "text.png");
    fails({"one.png", "-o", "sheet.exr"}, "ends in .png");
    fails({"one.png", "-o", "sheet.png", "--label", "a", "--label", "b"}, "2 labels");
    fails({"one.png", "-o", "sheet.png", "--frames", "1-2"}, "one.png");
    fails({"one.png", "-o", "sheet.png", "--colums", "2"}, "did you mean '--columns'?");
    fails({"-o", "sheet.png"}, "images");
}
