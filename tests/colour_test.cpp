// Colours for displays: the curve in closed form, the ACES view against OpenColorIO run by another program, values that are no colours.

#include "cli_fixtures.h"

#include "taut/base/srgb.h"
#include "taut/images/view_transform.h"

#include <cmath>
#include <cstdlib>
#include <iostream>

using namespace taut;
using namespace taut::test;

namespace {

ViewSettings viewNamed(const std::string &name, double exposure = 0, const std::string &config = "") {
    ViewSettings settings;
    settings.view = name;
    settings.exposure = exposure;
    settings.config = config;
    return settings;
}

std::vector<float> seen(const ViewSettings &settings, std::vector<float> rgb) {
    ViewTransform(settings).apply(rgb.data(), rgb.size() / 3);
    return rgb;
}

/// The 24 patches of the ColorChecker in sRGB of 8 bits, as X-Rite published them for charts made before November 2014.
constexpr int kChecker[24][3] = {{115, 82, 68},   {194, 150, 130}, {98, 122, 157},  {87, 108, 67},   {133, 128, 177}, {103, 189, 170},
                                 {214, 126, 44},  {80, 91, 166},   {193, 90, 99},   {94, 60, 108},   {157, 188, 64},  {224, 163, 46},
                                 {56, 61, 150},   {70, 148, 73},   {175, 54, 60},   {231, 199, 31},  {187, 86, 149},  {8, 133, 161},
                                 {243, 243, 242}, {200, 200, 200}, {160, 160, 160}, {122, 122, 121}, {85, 85, 85},    {52, 52, 52}};

/// The checker as linear light, three times: as it is, four stops up and four down.
Image checker() {
    Image image;
    image.width = 24;
    image.height = 3;
    image.window = {0, 0, 24, 3};
    image.channels = {"R", "G", "B", "A"};
    for (const float factor : {1.0F, 16.0F, 1 / 16.0F})
        for (const auto &patch : kChecker) {
            for (const int c : patch) image.values.push_back(factor * linearFromSrgb(static_cast<float>(c) / 255));
            image.values.push_back(1);
        }
    return image;
}

/// A configuration of OpenColorIO's built-in transforms, without files beside it.
const char *const kConfig = R"(ocio_profile_version: 2
roles: {aces_interchange: ACES2065-1, scene_linear: ACEScg, default: ACEScg}
file_rules: [!<Rule> {name: Default, colorspace: default}]
displays:
  Wall:
    - !<View> {name: Show, view_transform: aces, display_colorspace: srgb, looks: ""}
    - !<View> {name: Plain, view_transform: plain, display_colorspace: srgb}
    - !<View> {name: filmic, view_transform: aces, display_colorspace: srgb}
active_displays: [Wall]
active_views: []
view_transforms:
  - !<ViewTransform> {name: aces, from_scene_reference: !<BuiltinTransform> {style: "ACES-OUTPUT - ACES2065-1_to_CIE-XYZ-D65 - SDR-VIDEO_1.0"}}
  - !<ViewTransform> {name: plain, from_scene_reference: !<BuiltinTransform> {style: UTILITY - ACES-AP0_to_CIE-XYZ-D65_BFD}}
looks: [!<Look> {name: darker, process_space: ACES2065-1, transform: !<CDLTransform> {slope: [0.5, 0.5, 0.5]}}]
display_colorspaces:
  - !<ColorSpace> {name: srgb, from_display_reference: !<BuiltinTransform> {style: DISPLAY - CIE-XYZ-D65_to_sRGB}}
colorspaces:
  - !<ColorSpace> {name: ACES2065-1}
  - !<ColorSpace> {name: ACEScg, to_scene_reference: !<BuiltinTransform> {style: ACEScg_to_ACES2065-1}}
  - !<ColorSpace>
    name: Linear Rec.709
    to_scene_reference: !<GroupTransform>
      children:
        - !<BuiltinTransform> {style: UTILITY - ACES-AP1_to_LINEAR-REC709_BFD, direction: inverse}
        - !<BuiltinTransform> {style: ACEScg_to_ACES2065-1}
)";

std::string configIn(const std::string &folder) {
    writeBytes(folder + "/config.ocio", kConfig);
    return folder + "/config.ocio";
}

/// The variable OCIO as long as it lives.
struct OcioVariable {
    explicit OcioVariable(const std::string &value) { setenv("OCIO", value.c_str(), 1); }
    OcioVariable(const OcioVariable &) = delete;
    OcioVariable &operator=(const OcioVariable &) = delete;
    ~OcioVariable() { unsetenv("OCIO"); }
};

std::string failure(const ViewSettings &settings) {
    try {
        const ViewTransform view(settings);
    } catch (const InputError &error) {
        return error.what();
    }
    return "none";
}

} // namespace

TEST_CASE("colour: the filmic curve has its closed values", "[colour]") {
    CHECK(filmicCurve(0) == 0);
    CHECK(filmicCurve(1) == Approx(2.54 / 3.16).epsilon(1e-6));
    CHECK(filmicCurve(0.18F) == Approx(0.18 * 0.4818 / (0.18 * 1.0274 + 0.14)).epsilon(1e-6)); // 0.26689
    CHECK(filmicCurve(0.5F) == Approx(0.5 * 1.285 / (0.5 * 1.805 + 0.14)).epsilon(1e-6));
    CHECK(filmicCurve(7.24F) < 1); // 0.08 x^2 - 0.56 x - 0.14 = 0 at 7.2417
    CHECK(filmicCurve(7.2417F) == Approx(1).epsilon(1e-6));
    CHECK(filmicCurve(1e30F) == 1);
    CHECK(filmicCurve(-3) == 0);
    CHECK(filmicCurve(std::nanf("")) == 0);
    for (float x = 1e-3F; x < 7; x *= 1.1F) CHECK(filmicCurve(1.1F * x) > filmicCurve(x));
    CHECK(seen(viewNamed("filmic"), {1, 0.18F, 0})[0] == Approx(srgbFromLinear(static_cast<float>(2.54 / 3.16))).epsilon(1e-6));
}

TEST_CASE("colour: exposure is stops of light before the view", "[colour]") {
    for (const std::string view : {"standard", "filmic", "aces"}) {
        const std::vector<float> brighter = seen(viewNamed(view, 1.5), {0.1F, 0.2F, 0.05F});
        const auto factor = static_cast<float>(std::exp2(1.5));
        CHECK(brighter == seen(viewNamed(view), {0.1F * factor, 0.2F * factor, 0.05F * factor}));
    }
    CHECK(seen(viewNamed("standard", 1), {0.1F, 0, 0})[0] == srgbFromLinear(0.2F));
}

TEST_CASE("colour: every value gives one that a display can be sent", "[colour]") {
    const std::string folder = freshFolder("values");
    const float inf = std::numeric_limits<float>::infinity();
    const std::vector<float> odd{0, -0.0F, 1e-30F, -1e-3F, -1, -1e30F, 65504, 1e30F, inf, -inf, std::nanf(""), 0.5F};
    for (const ViewSettings &settings :
         {viewNamed(""), viewNamed("filmic"), viewNamed("aces"), viewNamed("Show", 0, configIn(folder)), viewNamed("aces", 40)})
        for (const float a : odd)
            for (const float b : odd) {
                CAPTURE(settings.view, a, b);
                const std::vector<float> out = seen(settings, {a, b, 0.2F});
                for (const float v : out) CHECK((v >= 0 && v <= 1)); // false for NaN
                if (std::isnan(a)) CHECK(out == seen(settings, {0, b, 0.2F}));
                if (a == inf) CHECK(out == seen(settings, {65504 * std::exp2(static_cast<float>(settings.exposure)), b, 0.2F}));
            }
    const std::vector<float> cut = seen(viewNamed(""), {inf, -inf, std::nanf("")});
    CHECK(cut[0] == Approx(1).margin(1e-6));
    CHECK((cut[1] == 0 && cut[2] == 0));
    for (const float v : seen(viewNamed("aces"), {0, 0, 0})) CHECK(v < 1e-4F);
}

TEST_CASE("colour: a colour checker through ACES has the numbers of OpenColorIO in another program", "[colour]") {
    if (runProgram({"oiiotool", "--version"}, 60).exitCode != 0) {
        std::cout << "SKIPPED: no oiiotool on this machine" << std::endl;
        return;
    }
    const std::string folder = freshFolder("checker");
    const std::string config = configIn(folder);
    const Image image = checker();
    writeImage(folder + "/checker.exr", image);
    requireSuccess(runProgram({"oiiotool", "--colorconfig", config, folder + "/checker.exr", "--ch", "R,G,B",
                               "--ociodisplay:from=Linear Rec.709", "Wall", "Show", "-d", "float", "-o", folder + "/oiiotool.exr"},
                              60));
    const Image theirs = readImage(folder + "/oiiotool.exr");
    REQUIRE(theirs.values.size() == 3 * 72);
    std::vector<float> rgb;
    for (std::size_t i = 0; i < image.values.size(); ++i)
        if (i % 4 != 3) rgb.push_back(image.values[i]);
    const std::vector<float> own = seen(viewNamed("aces"), rgb);                   // composed of built-in transforms
    const std::vector<float> configured = seen(viewNamed("Show", 0, config), rgb); // by the configuration
    float greatest = 0, greatestConfigured = 0;
    for (std::size_t i = 0; i < rgb.size(); ++i) {
        greatest = std::fmax(greatest, std::fabs(own[i] - std::clamp(theirs.values[i], 0.0F, 1.0F)));
        greatestConfigured = std::fmax(greatestConfigured, std::fabs(configured[i] - std::clamp(theirs.values[i], 0.0F, 1.0F)));
    }
    INFO("greatest difference " << greatest << ", by the configuration " << greatestConfigured);
    CHECK(greatest < 2e-4F); // oiiotool lets OpenColorIO approximate powers: 1/20 of a step of 8 bits
    CHECK(greatestConfigured < 2e-4F);
    // The neutral patches stay neutral, and white is brighter than in linear light it is not: the curve is there.
    CHECK(std::fabs(own[3 * 19] - own[3 * 19 + 2]) < 5e-3F);
    CHECK(own[3 * 18] < srgbFromLinear(rgb[3 * 18]));
    // In files: 16 bits hold it to half a step, 8 bits likewise.
    for (const int bits : {8, 16}) {
        ImageSettings settings;
        settings.view.view = "aces";
        settings.pngBits = bits;
        writeImage(folder + "/checker.png", image, {}, settings);
        const Image stored = readImage(folder + "/checker.png");
        const double step = bits == 8 ? 1.0 / 255 : 1.0 / 65535;
        for (std::size_t i = 0; i < own.size(); ++i) REQUIRE(std::fabs(static_cast<double>(stored.values[i] - own[i])) < 0.51 * step);
        CHECK(metadata(folder + "/checker.png", "taut:view") == "aces");
        CHECK(metadata(folder + "/checker.png", "taut:display") == "sRGB");
        CHECK(metadata(folder + "/checker.png", "taut:ocio").find("OpenColorIO 2") == 0);
    }
}

TEST_CASE("colour: views, displays, looks and spaces are those of the configuration", "[colour]") {
    const std::string folder = freshFolder("config");
    const std::string config = configIn(folder);
    const std::vector<float> grey{0.18F, 0.3F, 0.1F};
    // A view of the configuration wins over one of ours with its name; without a view its default is meant.
    CHECK(seen(viewNamed("filmic", 0, config), grey) == seen(viewNamed("Show", 0, config), grey));
    CHECK(seen(viewNamed("", 0, config), grey) == seen(viewNamed("Show", 0, config), grey));
    CHECK(seen(viewNamed("standard", 0, config), grey) == seen(viewNamed("standard"), grey));
    // "Plain" goes to XYZ and back to sRGB's primaries: nothing but the encoding is left.
    const std::vector<float> plain = seen(viewNamed("Plain", 0, config), grey);
    for (std::size_t c = 0; c < 3; ++c) CHECK(plain[c] == Approx(srgbFromLinear(grey[c])).margin(1e-4));
    ViewSettings look = viewNamed("Plain", 0, config);
    look.look = "darker";
    const std::vector<float> darker = seen(look, grey);
    for (std::size_t c = 0; c < 3; ++c) CHECK(darker[c] == Approx(srgbFromLinear(grey[c] / 2)).margin(1e-4));
    ViewSettings space = viewNamed("Plain", 0, config);
    space.space = "ACEScg";
    CHECK(seen(space, {0, 1, 0})[1] > 0.999F);
    CHECK(seen(space, {0, 0.2F, 0})[1] > srgbFromLinear(0.2F) + 0.01F); // a wider green than Rec. 709's
    // Without a name for linear Rec. 709 the way is by ACES 2065-1.
    std::string unnamed = kConfig;
    unnamed.replace(unnamed.find("name: Linear Rec.709"), 20, "name: Something else");
    writeBytes(folder + "/unnamed.ocio", unnamed);
    const std::vector<float> byAces = seen(viewNamed("Show", 0, folder + "/unnamed.ocio"), grey);
    const std::vector<float> byName = seen(viewNamed("Show", 0, config), grey);
    for (std::size_t c = 0; c < 3; ++c) CHECK(byAces[c] == Approx(byName[c]).margin(1e-5));
    {
        const OcioVariable ocio(config);
        CHECK(seen(viewNamed("Show"), grey) == seen(viewNamed("Show", 0, config), grey));
        CHECK(seen(viewNamed(""), grey) == seen(viewNamed("standard"), grey)); // it changes no picture by itself
        CHECK(seen(viewNamed("aces"), grey) == byName);                        // ours, where it has no view of that name
        CHECK(failure(viewNamed("Shw")).find("did you mean 'Show'?") != std::string::npos);
    }
    const auto with = [&](auto set) {
        ViewSettings settings = viewNamed("Show", 0, config);
        set(settings);
        return failure(settings);
    };
    CHECK(failure(viewNamed("film")).find("did you mean 'filmic'?") != std::string::npos);
    CHECK(with([](ViewSettings &s) { s.view = "Plane"; }).find("did you mean 'Plain'?") != std::string::npos);
    CHECK(with([](ViewSettings &s) { s.display = "Wal"; }).find("did you mean 'Wall'?") != std::string::npos);
    CHECK(with([](ViewSettings &s) { s.look = "dark"; }).find("did you mean 'darker'?") != std::string::npos);
    CHECK(with([](ViewSettings &s) { s.space = "ACEScc"; }).find("did you mean 'ACEScg'?") != std::string::npos);
    CHECK(failure(viewNamed("Show", 0, folder + "/absent.ocio")).find("absent.ocio") != std::string::npos);
    writeBytes(folder + "/bad.ocio", "no configuration\n");
    CHECK(failure(viewNamed("Show", 0, folder + "/bad.ocio")).find("expected a config.ocio") != std::string::npos);
    ViewSettings plainLook = viewNamed("filmic");
    plainLook.look = "darker";
    CHECK(failure(plainLook).find("expected a view of an OpenColorIO configuration") != std::string::npos);
}
