/// A normal-mapped rough conductor at rest beside Cycles.

#include "cli_fixtures.h"

#include "study/measures/image_error.h"
#include "taut/base/vec.h"

#include <iostream>

using namespace taut;
using namespace taut::test;

namespace {

std::vector<float> readColours(const std::string &path) {
    const Image image = readImage(path);
    const std::size_t channels = image.channels.size();
    std::vector<float> colours;
    for (std::size_t i = 0; i < image.values.size(); i += channels) colours.insert(colours.end(), &image.values[i], &image.values[i] + 3);
    return colours;
}

void writeFloats(const std::string &path, int side, const std::vector<float> &texels) {
    Image image;
    image.window = {0, 0, side, side};
    image.width = image.height = side;
    image.channels = {"R", "G", "B"};
    image.values = texels;
    writeImage(path, image);
}

double relativeError(const std::vector<float> &image, const std::vector<float> &reference) {
    REQUIRE(image.size() == reference.size());
    return sqr(chart::relativeRms(image, reference));
}

} // namespace

TEST_CASE("A normal-mapped rough conductor is that of Cycles, at the noise", "[mapped_blender][blender]") {
    if (runProgram({"blender", "--version"}, 60).exitCode != 0) {
        std::cout << "SKIPPED: there is no Blender on this machine" << std::endl;
        return;
    }
    const std::string folder = freshFolder("mapped_blender");
    constexpr int kSide = 512;
    const float steep = GENERATE(0.3F, 0.5F);
    std::vector<float> texels;
    for (int row = 0; row < kSide; ++row)
        for (int column = 0; column < kSide; ++column) {
            const float u = 8 * kPi * (static_cast<float>(column) + 0.5F) / kSide;
            const float v = 8 * kPi * (static_cast<float>(kSide - row) - 0.5F) / kSide;
            const Vec3 n = glm::normalize(Vec3(steep * std::cos(u) * std::sin(v), steep * std::sin(u) * std::cos(v), 1));
            for (int c = 0; c < 3; ++c) texels.push_back(0.5F * n[c] + 0.5F);
        }
    const std::string normals = folder + "/normals.exr";
    writeFloats(normals, kSide, texels);
    const std::string scene = folder + "/plate.toml";
    const auto ran = runProgram({"blender", "-b", "-noaudio", "--factory-startup", "--python-exit-code", "1", "--python",
                                 TAUT_SOURCE_DIR "/tests/blender/mapped_plate.py", "--", normals, "0.15", "256", folder + "/cycles.exr",
                                 folder + "/other.exr", scene},
                                600);
    REQUIRE(ran.exitCode == 0);
    const auto picture = [&](const std::string &name, const std::string &seed, const std::string &scale) {
        const std::string out = folder + "/" + name + ".exr";
        requireSuccess(
            runTaut({"render", scene, "-q", "--spp", "256", "--seed", seed, "-D", "material.plate.normal.scale=" + scale, "-o", out}));
        return readColours(out);
    };
    const std::vector<float> cycles = readColours(folder + "/cycles.exr");
    const std::vector<float> taut = picture("taut", "1", "1.0");
    // Two pictures differ by the noise of each.
    const double noise =
        0.5 * (relativeError(picture("again", "2", "1.0"), taut) + relativeError(readColours(folder + "/other.exr"), cycles));
    const double apart = relativeError(taut, cycles);
    const double flat = relativeError(picture("flat", "1", "0.0"), cycles);
    std::cout << "Cycles: relative mean squared error " << apart << ", noise of both " << noise << ", without the map " << flat
              << std::endl;
    // At slopes of a half facets reflect below the plate: we mirror that light, Cycles bends the normal.
    CHECK(apart < (steep < 0.4F ? 1.15 : 1.5) * noise);
    CHECK(flat > 100 * apart);
}
