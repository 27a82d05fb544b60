#include "taut/images/image_settings.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <cmath>

namespace taut {

namespace {

constexpr double kMostDwaLevel = 1e5;

/// Numbers of objects, and squares: what a colour may lose of either is too much.
bool isExactData(std::string_view channel) {
    std::string first(channel.substr(0, 6));
    for (char &c : first) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    return first == "crypto" || channel.starts_with("Variance.");
}

} // namespace

const std::vector<std::string_view> &exrCompressions() {
    static const std::vector<std::string_view> names{"none", "rle", "zips", "zip", "piz", "pxr24", "b44", "b44a", "dwaa", "dwab"};
    return names;
}

void checkCompression(const std::string &compression, const Location &where) {
    const std::size_t colon = compression.find(':');
    const std::string name = compression.substr(0, colon);
    const std::vector<std::string_view> &names = exrCompressions();
    if (std::find(names.begin(), names.end(), name) == names.end()) failUnknownName(where, name, names);
    if (colon == std::string::npos) return;
    if (name != "dwaa" && name != "dwab") failInput(where, quoted(compression), name + ": only dwaa and dwab have a level");
    double level = 0;
    const char *end = compression.data() + compression.size();
    const auto [stop, error] = std::from_chars(compression.data() + colon + 1, end, level);
    if (error != std::errc() || stop != end || !(level >= 0 && level <= kMostDwaLevel))
        failInput(where, quoted(compression), "a level from 0 to " + formatNumber(kMostDwaLevel) + ", such as " + name + ":45");
}

void checkCompressionOf(const std::string &compression, const std::vector<std::string> &channels) {
    constexpr std::array kChanging{"pxr24", "b44", "b44a", "dwaa", "dwab"};
    const std::string name = compression.substr(0, compression.find(':'));
    if (std::find(kChanging.begin(), kChanging.end(), name) == kChanging.end()) return;
    for (const std::string &channel : channels)
        if (isExactData(channel))
            failInput({"compression"}, name + ", which changes the numbers of " + channel, "zip, zips, piz, rle or none");
}

void setBits(const std::string &bits, const Location &where, ImageSettings &settings) {
    static constexpr std::string_view kBits[] = {"8", "16", "half", "float"};
    if (std::find(std::begin(kBits), std::end(kBits), bits) == std::end(kBits)) failUnknownName(where, bits, kBits);
    if (bits == "8" || bits == "16")
        settings.pngBits = bits == "8" ? 8 : 16;
    else
        settings.exrHalf = bits == "half";
}

bool isColourChannel(std::string_view name) {
    if (isExactData(name)) return false;
    const std::size_t dot = name.rfind('.');
    const std::string_view last = dot == std::string_view::npos ? name : name.substr(dot + 1);
    return last == "R" || last == "G" || last == "B" || last == "A";
}

} // namespace taut
