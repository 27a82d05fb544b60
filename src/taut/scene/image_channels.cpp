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

int findChannel(const ImagePart &part, const std::string &layer, std::initializer_list<std::string_view> names) {
    for (int i = 0; i < part.channelCount(); ++i) {
        const ChannelName name = split(part.channels[static_cast<std::size_t>(i)]);
        if (name.layer == layer && std::find(names.begin(), names.end(), name.part) != names.end()) return i;
    }
    return -1;
}

/// Red, green and blue of a layer, with alpha where it has one; empty where it lacks a colour.
std::vector<int> colourOf(const ImagePart &part, const std::string &layer) {
    std::vector<int> found{findChannel(part, layer, {"r", "red"}), findChannel(part, layer, {"g", "green"}),
                           findChannel(part, layer, {"b", "blue"})};
    if (std::find(found.begin(), found.end(), -1) != found.end()) return {};
    if (const int alpha = findChannel(part, layer, {"a", "alpha"}); alpha >= 0) found.push_back(alpha);
    return found;
}

/// Choices from the best to the last resort; each is empty where a part does not have it.
using Choice = std::vector<int> (*)(const ImagePart &);
constexpr std::array<Choice, 4> kChoices{
    [](const ImagePart &part) { return colourOf(part, ""); },
    [](const ImagePart &part) {
        std::vector<int> found{findChannel(part, "", {"y"})};
        const bool isVector = findChannel(part, "", {"x"}) >= 0 || findChannel(part, "", {"z"}) >= 0;
        if (found[0] < 0 || isVector) return std::vector<int>();
        if (const int alpha = findChannel(part, "", {"a", "alpha"}); alpha >= 0) found.push_back(alpha);
        return found;
    },
    [](const ImagePart &part) {
        for (int i = 0; i < part.channelCount(); ++i)
            if (std::vector<int> found = colourOf(part, split(part.channels[static_cast<std::size_t>(i)]).layer); !found.empty())
                return found;
        return std::vector<int>();
    },
    [](const ImagePart &part) {
        std::vector<int> found;
        const int alpha = findChannel(part, "", {"a", "alpha"});
        for (int i = 0; i < part.channelCount() && found.size() < 3; ++i)
            if (i != alpha) found.push_back(i);
        if (found.size() == 2) found.push_back(-1); // two numbers are no grey with alpha
        if (alpha >= 0) found.push_back(alpha);
        return found;
    },
};

std::string partName(const ImagePart &part, int number) {
    return part.name.empty() ? "part " + std::to_string(number) : "part " + quoted(part.name);
}

/// Names of channels, the first few of them.
std::string listed(const std::vector<std::string> &names) {
    constexpr std::size_t kMost = 8;
    std::string out;
    for (std::size_t i = 0; i < std::min(names.size(), kMost); ++i) out += (i != 0 ? ", " : "") + names[i];
    return names.size() > kMost ? out + " and " + std::to_string(names.size() - kMost) + " more" : out;
}

void warnOfRest(const std::vector<ImagePart> &parts, const ImageChannels &chosen, const Location &where, Warnings &warnings) {
    std::vector<std::string> used;
    std::vector<std::string> unused;
    for (std::size_t p = 0; p < parts.size(); ++p)
        for (int i = 0; i < parts[p].channelCount(); ++i) {
            const auto number = static_cast<int>(p);
            const std::string name = quoted(parts[p].channels[static_cast<std::size_t>(i)]);
            const bool isUsed =
                number == chosen.number && std::find(chosen.indices.begin(), chosen.indices.end(), i) != chosen.indices.end();
            if (isUsed)
                used.push_back(name);
            else
                unused.push_back(number == chosen.number ? name : name + " of " + partName(parts[p], number));
        }
    if (unused.empty()) return;
    warnings.add(where.text() + ": read " + listed(used) + (parts.size() > 1 ? " of " + partName(chosen.part, chosen.number) : "") +
                 "; left out " + listed(unused));
}

/// By place: grey, grey and alpha, RGB, RGBA.
std::vector<int> channelsInOrder(int count) {
    std::vector<int> indices;
    for (int i = 0; i < std::min(count, 4); ++i) indices.push_back(i);
    return indices;
}

} // namespace

ImageChannels pictureOf(ImageDecoder &input, bool isExr, const Location &where, Warnings &warnings) {
    const std::vector<ImagePart> parts = input.parts(isExr);
    if (parts.empty()) failInput(where, "an image without parts", "at least one");
    if (!isExr) return {0, parts[0], channelsInOrder(parts[0].channelCount())};
    for (const Choice choice : kChoices)
        for (std::size_t p = 0; p < parts.size(); ++p) {
            const ImagePart &part = parts[p];
            ImageChannels chosen{static_cast<int>(p), part, part.isFlat ? choice(part) : std::vector<int>()};
            if (chosen.indices.empty()) continue;
            if (findChannel(part, "", {"ry"}) >= 0 && findChannel(part, "", {"by"}) >= 0 && choice != kChoices[0])
                failInput(where, "luminance and chroma (Y, RY, BY)", "channels R, G and B");
            warnOfRest(parts, chosen, where, warnings);
            return chosen;
        }
    return {0, parts[0], channelsInOrder(parts[0].channelCount())};
}

} // namespace taut
