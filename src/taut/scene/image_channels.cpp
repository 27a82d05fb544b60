#include "taut/scene/image_channels.h"

#include <algorithm>
#include <array>

namespace taut {

namespace {

/// "diffuse.R" -> {"diffuse", "r"}: a layer, empty for the main one, and what the channel is in it.
struct ChannelName {
    std::string layer;
    std::string part;
};

ChannelName split(const std::string &name) {
    const std::size_t dot = name.rfind('.');
    ChannelName out{dot == std::string::npos ? "" : name.substr(0, dot), dot == std::string::npos ? name : name.substr(dot + 1)};
    for (char &c : out.part) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c + 32) : c;
    return out;
}

int findChannel(const OIIO::ImageSpec &spec, const std::string &layer, std::initializer_list<std::string_view> names) {
    for (int i = 0; i < spec.nchannels; ++i) {
        const ChannelName name = split(spec.channel_name(i));
        if (name.layer == layer && std::find(names.begin(), names.end(), name.part) != names.end()) return i;
    }
    return -1;
}

/// Red, green and blue of a layer, with alpha where it has one; empty where it lacks a colour.
std::vector<int> colourOf(const OIIO::ImageSpec &spec, const std::string &layer) {
    std::vector<int> found{findChannel(spec, layer, {"r", "red"}), findChannel(spec, layer, {"g", "green"}),
                           findChannel(spec, layer, {"b", "blue"})};
    if (std::find(found.begin(), found.end(), -1) != found.end()) return {};
    if (const int alpha = findChannel(spec, layer, {"a", "alpha"}); alpha >= 0) found.push_back(alpha);
    return found;
}

/// Choices from the best to the last resort; each is empty where a part does not have it.
using Choice = std::vector<int> (*)(const OIIO::ImageSpec &);
constexpr std::array<Choice, 4> kChoices{
    [](const OIIO::ImageSpec &spec) { return colourOf(spec, ""); },
    [](const OIIO::ImageSpec &spec) {
        std::vector<int> found{findChannel(spec, "", {"y"})};
        const bool isVector = findChannel(spec, "", {"x"}) >= 0 || findChannel(spec, "", {"z"}) >= 0;
        if (found[0] < 0 || isVector) return std::vector<int>();
        if (const int alpha = findChannel(spec, "", {"a", "alpha"}); alpha >= 0) found.push_back(alpha);
        return found;
    },
    [](const OIIO::ImageSpec &spec) {
        for (int i = 0; i < spec.nchannels; ++i)
            if (std::vector<int> found = colourOf(spec, split(spec.channel_name(i)).layer); !found.empty()) return found;
        return std::vector<int>();
    },
    [](const OIIO::ImageSpec &spec) {
        std::vector<int> found;
        const int alpha = findChannel(spec, "", {"a", "alpha"});
        for (int i = 0; i < spec.nchannels && found.size() < 3; ++i)
            if (i != alpha) found.push_back(i);
        if (found.size() == 2) found.push_back(-1); // two numbers are no grey with alpha
        if (alpha >= 0) found.push_back(alpha);
        return found;
    },
};

std::string partName(const OIIO::ImageSpec &spec, int part) {
    const std::string name(spec.get_string_attribute("oiio:subimagename", spec.get_string_attribute("name", "")));
    return name.empty() ? "part " + std::to_string(part) : "part " + quoted(name);
}

/// Names of channels, the first few of them.
std::string listed(const std::vector<std::string> &names) {
    constexpr std::size_t kMost = 8;
    std::string out;
    for (std::size_t i = 0; i < std::min(names.size(), kMost); ++i) out += (i != 0 ? ", " : "") + names[i];
    return names.size() > kMost ? out + " and " + std::to_string(names.size() - kMost) + " more" : out;
}

void warnOfRest(const std::vector<OIIO::ImageSpec> &parts, const ImageChannels &chosen, const Location &where, Warnings &warnings) {
    std::vector<std::string> used;
    std::vector<std::string> unused;
    for (std::size_t part = 0; part < parts.size(); ++part)
        for (int i = 0; i < parts[part].nchannels; ++i) {
            const std::string name = quoted(std::string(parts[part].channel_name(i)));
            const bool isUsed =
                static_cast<int>(part) == chosen.part && std::find(chosen.indices.begin(), chosen.indices.end(), i) != chosen.indices.end();
            if (isUsed)
                used.push_back(name);
            else
                unused.push_back(static_cast<int>(part) == chosen.part ? name
                                                                       : name + " of " + partName(parts[part], static_cast<int>(part)));
        }
    if (unused.empty()) return;
    warnings.add(where.text() + ": read " + listed(used) + (parts.size() > 1 ? " of " + partName(chosen.spec, chosen.part) : "") +
                 "; left out " + listed(unused));
}

/// By place: grey, grey and alpha, RGB, RGBA.
std::vector<int> channelsInOrder(int count) {
    std::vector<int> indices;
    for (int i = 0; i < std::min(count, 4); ++i) indices.push_back(i);
    return indices;
}

} // namespace

ImageChannels pictureOf(OIIO::ImageInput &input, bool isExr, const Location &where, Warnings &warnings) {
    if (!isExr) return {0, input.spec(), channelsInOrder(input.spec().nchannels)};
    std::vector<OIIO::ImageSpec> parts;
    constexpr int kMostParts = 1024;
    for (int part = 0; part < kMostParts && input.seek_subimage(part, 0); ++part) parts.push_back(input.spec());
    static_cast<void>(input.geterror()); // that of the part behind the last
    for (const Choice choice : kChoices)
        for (std::size_t part = 0; part < parts.size(); ++part) {
            const OIIO::ImageSpec &spec = parts[part];
            ImageChannels chosen{static_cast<int>(part), spec, spec.deep ? std::vector<int>() : choice(spec)};
            if (chosen.indices.empty()) continue;
            if (findChannel(spec, "", {"ry"}) >= 0 && findChannel(spec, "", {"by"}) >= 0 && choice != kChoices[0])
                failInput(where, "luminance and chroma (Y, RY, BY)", "channels R, G and B");
            warnOfRest(parts, chosen, where, warnings);
            return chosen;
        }
    if (parts.empty()) failInput(where, "an image without parts", "at least one");
    return {0, parts[0], channelsInOrder(parts[0].nchannels)};
}

} // namespace taut
