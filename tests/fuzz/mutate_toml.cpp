#include "mutate.h"

#include <algorithm>
#include <array>

namespace taut::fuzz {

namespace {

/// Values of a kind, as text.
using Values = std::span<const std::string_view>;

constexpr std::array<std::string_view, 20> kNumbers{"0", "1", "-1", "2", "3", "0.5", "1e-4", "1e30", "-1e30", "1e31", "10", "89.9", "180", "360",
                                                    "nan", "inf", "9223372036854775807", "0x10", "128", "16"};
constexpr std::array<std::string_view, 8> kVectors{"[0, 0, 0]",       "[1, 2, 3]",         "[-1, 0.5, 1e-9]",          "[1e20, 1, 1]", "[0, 1]", "[]",
                                                   "[[1, [0, 0, 0]], [9, [1, 2, 3]]]", "[[1, 0], [4, 90], [5, -1]]"};
constexpr std::array<std::string_view, 20> kFiles{"\"quad.obj\"", "\"torus.obj\"", "\"mesh.ply\"", "\"mesh.stl\"", "\"box.glb\"", "\"seq.###.obj\"", "\"two.pc2\"",
                                                  "\"map.png\"",  "\"sky.hdr\"",   "\"none.obj\"", "\"\"",          "\".\"",       "\"../x\"",        "{ file = \"map.png\" }",
                                                  "{ file = \"map.png\", scale = 2, channel = 1 }", "{ at = [0, 1, 0], offset = [0, 0, 1] }", "{ file = \"map.png\", tile = 2 }",
                                                  "{ a = \"x\" }", "[{ type = \"twist\", angle_deg = 40 }]", "[[0, 0, 0, 1, 2, 3]]"};
constexpr std::array<std::string_view, 68> kWords{
    "\"x\"",        "\"y\"",         "\"z\"",       "\"xy\"",     "\"quad\"",     "\"sphere\"",   "\"directional\"", "\"point\"",  "\"spot\"",   "\"mesh\"",
    "\"studio\"",   "\"auto\"",      "\"off\"",     "\"walk\"",   "\"compensation\"", "\"stretch\"", "\"shear\"",   "\"bend\"",   "\"twist\"",  "\"taper\"",
    "\"lattice\"",  "\"wave\"",      "\"diffuse\"", "\"conductor\"", "\"dielectric\"", "\"coated\"", "\"thin_glass\"", "\"metallic_roughness\"", "\"Al\"", "\"Au\"",
    "\"rubber\"",   "\"skin\"",      "\"foil\"",    "\"annealed aluminium\"", "\"clip\"", "\"1-4\"", "\"1-100x7,3\"", "\"bind\"", "\"frame 2\"", "\"loop\"",
    "\"catmull-clark\"", "\"edge\"", "\"edge-and-corner\"", "\"analytic\"", "\"face\"", "\"area\"", "\"least-squares\"", "\"limit\"", "\"ds-dt\"", "\"cholesky\"",
    "\"blend\"",    "\"mask\"",      "\"moments\"", "\"map\"",    "\"bends\"",    "\"box\"",      "true",            "false",
    "\"filmic\"",   "\"aces\"",      "\"standard\"", "\"sRGB\"",   "\"half\"",     "[16, \"float\"]", "\"dwaa:45\"",     "\"piz\"",    "\"show.ocio\"", "\"key\""};

struct Section {
    std::string_view header;
    std::string_view keys; ///< parted by blanks
};
constexpr std::array kSections{
    Section{"[render]", "width height spp max_events frames fps seed fixed_seed filter shutter motion_steps"},
    Section{"[camera]", "position look_at up fov_deg ortho_height aperture_radius focus_distance gltf node clip loop translate rotate_deg scale"},
    Section{"[environment]", "file radiance preset rotation_deg scale camera_visible"},
    Section{"[image]", "exposure view display look ocio space bits compression"},
    Section{"[[light]]", "type radiance intensity irradiance corner u v two_sided centre radius direction position inner_deg outer_deg camera_visible mesh power file group"},
    Section{"[material.brushed]",
            "preset type metal f0 color ior alpha alpha_x alpha_y roughness rotation_deg metallic anisotropy poisson masking multiscatter normal bump height detail "
            "facets roughening yield opacity alpha_mode alpha_cutoff double_sided unlit specular specular_color transmission thin_walled attenuation_color "
            "attenuation_distance clearcoat clearcoat_roughness clearcoat_normal sheen_color sheen_roughness iridescence iridescence_ior iridescence_thickness"},
    Section{"[[mesh]]", "file name material subdivision smooth follow rest translate rotate_deg scale up clip loop lights deform scheme boundary crease_deg gradient "
                        "interpolation lean cache variant group"},
    Section{"[[mesh.deform]]",
            "type centre factor plane amount axis towards direction range angle_deg amplitude wavelength phase_deg lower upper points offsets"},
};

std::string_view wordOf(std::string_view words, Dice &dice) {
    const auto count = static_cast<std::size_t>(std::count(words.begin(), words.end(), ' ')) + 1;
    std::size_t begin = 0;
    for (std::size_t skip = dice.below(count); skip > 0; --skip) begin = words.find(' ', begin) + 1;
    return words.substr(begin, words.find(' ', begin) - begin);
}

std::string valueOf(Dice &dice) {
    const std::array<Values, 4> kinds{kNumbers, kVectors, kFiles, kWords};
    const Values values = kinds[dice.below(kinds.size())];
    std::string value(values[dice.below(values.size())]);
    if (dice.chance(10)) value = '[' + value + ", " + value + ']';
    if (dice.chance(3)) value = "{ a = " + value + " }";
    return value;
}

/// The section that a line lies in.
const Section &sectionAt(const std::vector<std::string> &lines, std::size_t at, Dice &dice) {
    for (std::size_t i = at + 1; i-- > 0;)
        for (const Section &section : kSections)
            if (lines[i].rfind(section.header.substr(0, section.header.find('.')), 0) == 0) return section;
    return kSections[dice.below(kSections.size())];
}

void changeLine(std::vector<std::string> &lines, Dice &dice) {
    const std::size_t at = dice.below(lines.size());
    const auto place = lines.begin() + static_cast<std::ptrdiff_t>(at);
    const std::size_t equals = lines[at].find('=');
    switch (dice.below(7)) {
    case 0: lines.erase(place); return;
    case 1: lines.insert(place, lines[dice.below(lines.size())]); return;
    case 2: lines.insert(place, std::string(kSections[dice.below(kSections.size())].header)); return;
    case 3:
        lines.insert(place + 1, std::string(wordOf(sectionAt(lines, at, dice).keys, dice)) + " = " + valueOf(dice));
        return;
    case 4:
        if (equals != std::string::npos) lines[at] = std::string(wordOf(sectionAt(lines, at, dice).keys, dice)) + ' ' + lines[at].substr(equals);
        return;
    default:
        if (equals != std::string::npos) lines[at] = lines[at].substr(0, equals + 1) + ' ' + valueOf(dice);
    }
}

} // namespace

std::string mutatedToml(std::string_view text, Dice &dice) {
    std::vector<std::string> lines;
    for (std::size_t begin = 0; begin <= text.size();) {
        const std::size_t end = std::min(text.find('\n', begin), text.size());
        lines.emplace_back(text.substr(begin, end - begin));
        begin = end + 1;
    }
    for (std::size_t i = 1 + dice.below(4); i > 0 && !lines.empty(); --i) changeLine(lines, dice);
    std::string out;
    for (const std::string &line : lines) out += line + '\n';
    return out;
}

} // namespace taut::fuzz
