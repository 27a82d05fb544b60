/// Configurations of OpenColorIO, and what their views make of colours. OpenColorIO reads them, uninstrumented, in a module of its own: what
/// is fuzzed is what is made of its answers and of its errors.

#include "harness.h"
#include "harness_list.h"

#include "taut/images/view_transform.h"

#include <array>
#include <limits>

namespace taut::fuzz {

namespace {

constexpr const char *kBuiltIn = R"(ocio_profile_version: 2
roles: {aces_interchange: ACES2065-1, scene_linear: ACEScg, default: ACEScg}
file_rules: [!<Rule> {name: Default, colorspace: default}]
displays:
  Wall:
    - !<View> {name: Show, view_transform: aces, display_colorspace: srgb, looks: ""}
    - !<View> {name: Plain, view_transform: plain, display_colorspace: srgb}
view_transforms:
  - !<ViewTransform> {name: aces, from_scene_reference: !<BuiltinTransform> {style: "ACES-OUTPUT - ACES2065-1_to_CIE-XYZ-D65 - SDR-VIDEO_1.0"}}
  - !<ViewTransform> {name: plain, from_scene_reference: !<BuiltinTransform> {style: UTILITY - ACES-AP0_to_CIE-XYZ-D65_BFD}}
looks: [!<Look> {name: darker, process_space: ACES2065-1, transform: !<CDLTransform> {slope: [0.5, 0.5, 0.5]}}]
display_colorspaces:
  - !<ColorSpace> {name: srgb, from_display_reference: !<BuiltinTransform> {style: DISPLAY - CIE-XYZ-D65_to_sRGB}}
colorspaces:
  - !<ColorSpace> {name: ACES2065-1}
  - !<ColorSpace> {name: ACEScg, to_scene_reference: !<BuiltinTransform> {style: ACEScg_to_ACES2065-1}}
)";

constexpr const char *kByHand = R"(ocio_profile_version: 1
roles: {scene_linear: lin_srgb, default: lin_srgb}
displays:
  screen:
    - !<View> {name: filmic, colorspace: out, looks: "+warm"}
active_displays: [screen]
looks: [!<Look> {name: warm, process_space: lin_srgb, transform: !<ExponentTransform> {value: [1.1, 1, 0.9, 1]}}]
colorspaces:
  - !<ColorSpace> {name: lin_srgb, bitdepth: 32f}
  - !<ColorSpace>
    name: out
    from_reference: !<GroupTransform>
      children:
        - !<MatrixTransform> {matrix: [2, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0.5, 0, 0, 0, 0, 1]}
        - !<AllocationTransform> {allocation: lg2, vars: [-8, 5, 0.00390625]}
        - !<LogTransform> {base: 2}
)";

} // namespace

void checkColours(const ViewSettings &settings) {
    const ViewTransform transform(settings);
    constexpr float kInfinity = std::numeric_limits<float>::infinity();
    std::array<float, 15> rgb{0, 0.18F, 1, 1e-20F, -2, 1e30F, kInfinity, -kInfinity, std::numeric_limits<float>::quiet_NaN(), 0.5F, 0.25F, 7, 65504, 3, 0};
    transform.apply(rgb.data(), rgb.size() / 3);
    for (const float value : rgb) require(value >= 0 && value <= 1, "what a display is sent lies in [0, 1]");
    for (const auto &[name, value] : transform.applied()) require(!name.empty(), "what is applied has a name");
}

/// The default view of a configuration; then a view, a display, a look and a space of these names, which are its first line where that is a
/// comment: #view,display,look,space.
void runOcio(std::string_view bytes) {
    ViewSettings settings;
    settings.config = scratchFile("fuzz.ocio", bytes);
    survive([&] { checkColours(settings); });
    if (bytes.empty() || bytes.front() != '#') return;
    std::string_view names = bytes.substr(1, bytes.find('\n') == std::string_view::npos ? bytes.size() : bytes.find('\n') - 1);
    for (std::string *const part : {&settings.view, &settings.display, &settings.look, &settings.space}) {
        *part = names.substr(0, names.find(','));
        names.remove_prefix(std::min(names.size(), part->size() + 1));
    }
    survive([&] { checkColours(settings); });
}

std::vector<std::string> ocioSeeds() {
    return {kBuiltIn, std::string("#Plain,Wall,darker,ACEScg\n") + kBuiltIn, kByHand, std::string("#filmic,screen,warm,lin_srgb\n") + kByHand};
}

} // namespace taut::fuzz
