/// taut compare: how far a picture is from another, in numbers and as a picture of the difference.

#include "commands.h"
#include "false_colour.h"
#include "json_text.h"

#include "study/measures/flip.h"
#include "study/measures/image_error.h"
#include "study/measures/welch.h"
#include "taut/base/file_bytes.h"
#include "taut/base/srgb.h"
#include "taut/render/image_file.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <iostream>
#include <optional>

namespace taut::app {

namespace {

struct CompareArguments {
    std::string image, reference;
    std::string output;
    double exposure = 0;
    double most = -1; ///< FLIP above which the exit code is 1; negative: none
    int box = 1;      ///< pixels across, whose means are compared
    bool json = false;
};

/// Of the t-test.
constexpr double kLevel = 0.05;

struct Difference {
    double relativeMse = 0, relativeRms = 0;
    double mean = 0, referenceMean = 0;
    float greatest = 0; ///< of any colour of any pixel
    int x = 0, y = 0;   ///< where
    double flipMean = 0, flipGreatest = 0;
    std::size_t notFinite = 0;
};

/// A picture and, where it has them, the variances and numbers of samples of its values.
struct Compared {
    std::vector<float> rgb, variances, samples; ///< [pixels x 3]
};

/// Linear R, G and B of an image; a PNG's are decoded.
std::vector<float> colours(const Image &image, const std::string &path) {
    const bool png = lowerExtension(path) == "png";
    std::array<std::size_t, 3> at{};
    for (std::size_t c = 0; c < 3; ++c) {
        const auto found = std::find(image.channels.begin(), image.channels.end(), std::string(1, "RGB"[c]));
        if (found == image.channels.end()) failInput({path}, "no channel " + std::string(1, "RGB"[c]), "R, G and B");
        at[c] = static_cast<std::size_t>(found - image.channels.begin());
    }
    std::vector<float> rgb;
    rgb.reserve(image.values.size() / image.channels.size() * 3);
    for (std::size_t first = 0; first < image.values.size(); first += image.channels.size())
        for (const std::size_t c : at) rgb.push_back(png ? linearFromSrgb(image.values[first + c]) : image.values[first + c]);
    return rgb;
}

/// The values of three channels, or of one three times; empty where the image lacks one.
std::vector<float> channelsOf(const Image &image, const std::array<const char *, 3> &names) {
    std::array<std::size_t, 3> at{};
    for (std::size_t c = 0; c < 3; ++c) {
        const auto found = std::find(image.channels.begin(), image.channels.end(), names[c]);
        if (found == image.channels.end()) return {};
        at[c] = static_cast<std::size_t>(found - image.channels.begin());
    }
    std::vector<float> values;
    for (std::size_t first = 0; first < image.values.size(); first += image.channels.size())
        for (const std::size_t c : at) values.push_back(image.values[first + c]);
    return values;
}

Compared comparedOf(const Image &image, const std::string &path) {
    return {colours(image, path), channelsOf(image, {"Variance.R", "Variance.G", "Variance.B"}),
            channelsOf(image, {"Samples.X", "Samples.X", "Samples.X"})};
}

/// Where both have variances.
std::optional<chart::WelchTest> testOf(const Compared &image, const Compared &reference) {
    if (image.variances.empty() || reference.variances.empty()) return std::nullopt;
    return chart::welchTest({image.rgb, image.variances, image.samples}, {reference.rgb, reference.variances, reference.samples}, kLevel);
}

std::string sizeOf(const Window &w) {
    return fmt::format("pixels {},{} to {},{}", w.x0, w.y0, w.x1, w.y1);
}

std::vector<float> exposed(const std::vector<float> &rgb, double exposure) {
    const auto factor = static_cast<float>(std::exp2(exposure));
    std::vector<float> out(rgb);
    for (float &v : out) v *= factor;
    return out;
}

/// Not finite values count and become 0.
void clean(std::vector<float> &rgb, std::size_t &count) {
    for (float &v : rgb)
        if (!std::isfinite(v)) {
            ++count;
            v = 0;
        }
}

Difference differenceOf(std::vector<float> image, std::vector<float> reference, const Window &window, double exposure,
                        std::vector<float> &flip) {
    Difference d;
    clean(image, d.notFinite);
    clean(reference, d.notFinite);
    d.relativeMse = chart::relativeMse(image, reference);
    d.relativeRms = chart::relativeRms(image, reference);
    d.mean = chart::meanOf(image);
    d.referenceMean = chart::meanOf(reference);
    for (std::size_t i = 0; i < image.size(); ++i)
        if (const float difference = std::fabs(image[i] - reference[i]); difference > d.greatest) {
            d.greatest = difference;
            const auto width = static_cast<std::size_t>(window.width());
            d.x = window.x0 + static_cast<int>(i / 3 % width);
            d.y = window.y0 + static_cast<int>(i / 3 / width);
        }
    flip = chart::flip(exposed(image, exposure), exposed(reference, exposure), window.width(), window.height());
    d.flipMean = chart::meanOf(flip);
    d.flipGreatest = *std::max_element(flip.begin(), flip.end());
    return d;
}

void print(const Difference &d) {
    fmt::print("relMSE {:.4g}, RMS {:.4g} of the reference's\n", d.relativeMse, d.relativeRms);
    fmt::print("mean {:.6g}, of the reference {:.6g}\n", d.mean, d.referenceMean);
    fmt::print("greatest difference {:.4g} at pixel {},{}\n", d.greatest, d.x, d.y);
    fmt::print("FLIP {:.4g} on average, {:.4g} at most\n", d.flipMean, d.flipGreatest);
    if (d.notFinite > 0) fmt::print("{} values are not finite and count as 0\n", d.notFinite);
}

std::string pixelOf(const Window &window, std::size_t value) {
    const auto width = static_cast<std::size_t>(window.width());
    return fmt::format("{} at pixel {},{}", "RGB"[value % 3], window.x0 + static_cast<int>(value / 3 % width),
                       window.y0 + static_cast<int>(value / 3 / width));
}

void print(const chart::WelchTest &test, const Window &window) {
    fmt::print("t-test: {} of {} values beyond the 5 % bound ({:.3g} %; by chance {:.0f}), greatest |t| {:.3g} of {}\n", test.beyond,
               test.tested, 100 * test.share(), kLevel * static_cast<double>(test.tested), test.greatest, pixelOf(window, test.at));
}

nlohmann::json toJson(const Difference &d) {
    return {{"relmse", d.relativeMse},           {"relative_rms", d.relativeRms},     {"mean", d.mean},
            {"reference_mean", d.referenceMean}, {"greatest_difference", d.greatest}, {"greatest_at", {d.x, d.y}},
            {"flip_mean", d.flipMean},           {"flip_greatest", d.flipGreatest},   {"not_finite", d.notFinite}};
}

/// Appends t as channels T.R, T.G and T.B.
void addTest(const chart::WelchTest &test, Image &picture) {
    std::vector<float> values;
    const std::size_t channels = picture.channels.size();
    for (std::size_t pixel = 0; pixel < test.t.size() / 3; ++pixel) {
        const auto own = picture.values.begin() + static_cast<std::ptrdiff_t>(pixel * channels);
        values.insert(values.end(), own, own + static_cast<std::ptrdiff_t>(channels));
        values.insert(values.end(), test.t.begin() + static_cast<std::ptrdiff_t>(3 * pixel),
                      test.t.begin() + static_cast<std::ptrdiff_t>(3 * pixel + 3));
    }
    picture.channels.insert(picture.channels.end(), {"T.R", "T.G", "T.B"});
    picture.values = std::move(values);
}

nlohmann::json toJson(const chart::WelchTest &test) {
    nlohmann::json greatest = nullptr; // JSON knows no infinity
    if (std::isfinite(test.greatest)) greatest = test.greatest;
    return {{"tested", test.tested},
            {"beyond", test.beyond},
            {"share", test.share()},
            {"by_chance", kLevel * static_cast<double>(test.tested)},
            {"greatest_t", greatest}};
}

int compare(const CompareArguments &arguments) {
    if (!arguments.output.empty() && !isImagePath(arguments.output))
        failInput({"-o"}, quoted(arguments.output), "a file name that ends in .exr or .png");
    const Image image = readImage(arguments.image);
    const Image reference = readImage(arguments.reference);
    if (image.window != reference.window)
        failInput({arguments.image}, sizeOf(image.window), sizeOf(reference.window) + ", as " + arguments.reference + " has");
    const Compared compared = comparedOf(image, arguments.image);
    const Compared expected = comparedOf(reference, arguments.reference);
    const std::optional<chart::WelchTest> test = testOf(compared, expected);
    const int shortest = std::min(image.window.width(), image.window.height());
    if (shortest < arguments.box)
        failInput({"--box"}, std::to_string(arguments.box), fmt::format("at most {}, the images' shorter side", shortest));
    std::vector<float> flip;
    const Difference d = differenceOf(compared.rgb, expected.rgb, image.window, arguments.exposure, flip);
    const auto boxed = [&](const std::vector<float> &rgb) {
        return chart::boxed(rgb, image.window.width(), image.window.height(), arguments.box);
    };
    const double boxedMse = chart::relativeMse(boxed(compared.rgb), boxed(expected.rgb));
    if (!arguments.output.empty()) {
        Image picture{image.window, image.width, image.height, {"FLIP", "A"}, {}};
        for (const float v : flip) picture.values.insert(picture.values.end(), {v, 1.0F});
        picture = falseColours(picture, "FLIP", Vec2(0, 1));
        if (test && lowerExtension(arguments.output) == "exr") addTest(*test, picture);
        writeImage(arguments.output, picture, {{"taut:channel", "FLIP"}, {"taut:range", "0 1"}});
    }
    if (arguments.json) {
        nlohmann::json said = toJson(d);
        if (arguments.box > 1) said["boxed_relmse"] = boxedMse;
        if (test) said["t_test"] = toJson(*test);
        std::cout << jsonText(said, 2) << std::endl;
    } else {
        print(d);
        if (arguments.box > 1) fmt::print("relMSE of means of {} x {} pixels {:.4g}\n", arguments.box, arguments.box, boxedMse);
        if (test) print(*test, image.window);
    }
    return arguments.most >= 0 && !(d.flipMean <= arguments.most) ? 1 : 0;
}

} // namespace

void addCompare(CLI::App &parent, Run &run) {
    auto arguments = std::make_shared<CompareArguments>();
    CLI::App *command = parent.add_subcommand("compare", "How far an image is from a reference: relMSE, FLIP, a picture of the difference");
    command->add_option("image", arguments->image, "EXR or PNG")->required();
    command->add_option("reference", arguments->reference, "What it should be: EXR or PNG")->required();
    command->add_option(
        "-o,--output", arguments->output,
        "FLIP at every pixel in false colours, 0 dark blue to 1 yellow: out/difference.png or .exr (with Welch's t as T.R, T.G, T.B)");
    command->add_option("--exposure", arguments->exposure, "Stops by which both are brightened for FLIP, which sees [0, 1]")
        ->check(CLI::Range(-50.0, 50.0));
    command->add_option("--most", arguments->most, "Exit with 1 where the mean FLIP is above this")->check(CLI::Range(0.0, 1.0));
    command->add_option("--box", arguments->box, "Also the relMSE of means of boxes of so many pixels each way, which noise hardly touches")
        ->check(CLI::Range(1, 4096));
    command->add_flag("--json", arguments->json, "One JSON object on standard output");
    command->callback([&run, arguments] { run = [arguments] { return compare(*arguments); }; });
}

} // namespace taut::app
