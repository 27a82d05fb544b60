#include "taut/render/film_layers.h"

#include "taut/base/error.h"
#include "taut/render/sum_packing.h"

#include <algorithm>
#include <bit>
#include <charconv>

namespace taut {

namespace {

constexpr std::string_view kRanks = "ranks:";
constexpr std::string_view kGroup = "light:";
constexpr int kMostRanks = 32;

struct NamedLayer {
    std::string_view name;
    bool FilmLayers::*asked;
};
constexpr NamedLayer kLayers[] = {{"crypto_object", &FilmLayers::objects},
                                  {"crypto_material", &FilmLayers::materials},
                                  {"lights", &FilmLayers::lights},
                                  {"samples", &FilmLayers::samples},
                                  {"variance", &FilmLayers::variance}};

const NamedLayer *findLayer(std::string_view name) {
    const auto *found = std::find_if(std::begin(kLayers), std::end(kLayers), [&](const NamedLayer &layer) { return layer.name == name; });
    return found == std::end(kLayers) ? nullptr : found;
}

void addChannels(const std::string &layer, std::string_view channels, std::vector<std::string> &names) {
    for (const char channel : channels) names.push_back(layer + '.' + channel);
}

/// Bits lost to no rounding but one.
long double longValue(const ExactSum &sum) {
    return static_cast<long double>(sum.high()) + static_cast<long double>(sum.low()) * 0x1p-64L;
}

} // namespace

std::vector<std::string> FilmLayers::channelNames() const {
    std::vector<std::string> names;
    const auto addMattes = [&](const std::string &kind) {
        for (int level = 0; level < ranks / 2; ++level)
            addChannels(kind + static_cast<char>('0' + level / 10) + static_cast<char>('0' + level % 10), "RGBA", names);
    };
    if (objects) addMattes("CryptoObject");
    if (materials) addMattes("CryptoMaterial");
    if (lights)
        for (const std::string &group : lightGroups) addChannels("Light_" + group, "RGB", names);
    if (samples) addChannels("Samples", "X", names);
    if (variance) addChannels("Variance", "RGB", names);
    return names;
}

std::vector<std::string> FilmLayers::words() const {
    std::vector<std::string> words;
    for (const NamedLayer &layer : kLayers)
        if (this->*layer.asked) words.emplace_back(layer.name);
    if (objects || materials || ranks != FilmLayers().ranks) words.push_back(std::string(kRanks) + std::to_string(ranks));
    for (const std::string &group : lightGroups) words.push_back(std::string(kGroup) + group);
    return words;
}

void FilmLayers::addWord(std::string_view word) {
    if (const NamedLayer *layer = findLayer(word)) {
        this->*layer->asked = true;
    } else if (word.starts_with(kGroup)) {
        lightGroups.emplace_back(word.substr(kGroup.size()));
    } else {
        const std::string_view number = word.substr(std::min(kRanks.size(), word.size()));
        const auto [end, error] = std::from_chars(number.data(), number.data() + number.size(), ranks);
        const bool isNumber = word.starts_with(kRanks) && error == std::errc() && end == number.data() + number.size();
        if (!isNumber || ranks < 2 || ranks > kMostRanks || ranks % 2 != 0) throw InputError("film: found a layer that is none");
    }
}

FilmContents filmContentsNamed(std::span<const std::string> names, std::string_view option) {
    FilmContents contents;
    std::vector<std::string_view> rows;
    for (const std::string &name : names) {
        const NamedLayer *layer = findLayer(name);
        if (layer != nullptr) {
            contents.layers.*layer->asked = true;
            continue;
        }
        if (name != "all" && !findAov(name)) {
            std::vector<std::string_view> valid;
            for (const AovInfo &info : aovTable()) valid.push_back(info.name);
            for (const NamedLayer &known : kLayers) valid.push_back(known.name);
            valid.emplace_back("all");
            failUnknownName({std::string(option)}, name, valid);
        }
        rows.emplace_back(name);
    }
    contents.aovs = aovsNamed(rows, option);
    return contents;
}

void LayerSums::resize(std::size_t pixels) {
    if (asked_.objects) objects_.resize(pixels);
    if (asked_.materials) materials_.resize(pixels);
    lights_.resize(pixels * lightSums());
    if (asked_.variance) squares_.resize(3 * pixels);
}

void LayerSums::addTo(Counts &counts, std::uint32_t id, std::uint32_t samples) {
    const auto at = std::lower_bound(counts.begin(), counts.end(), id, [](const Count &c, std::uint32_t other) { return c.id < other; });
    if (at != counts.end() && at->id == id)
        at->samples += samples;
    else
        counts.insert(at, {id, samples});
}

void LayerSums::add(std::size_t pixel, const Vec3 &radiance, const LayerSample &sample) {
    if (asked_.objects && sample.object != 0) addTo(objects_[pixel], sample.object, 1);
    if (asked_.materials && sample.material != 0) addTo(materials_[pixel], sample.material, 1);
    if (asked_.variance)
        for (int c = 0; c < 3; ++c) squares_[3 * pixel + static_cast<std::size_t>(c)].addSquare(radiance[c]);
    if (!asked_.lights || sample.lights == nullptr) return;
    // A group's float is rounded in another order than the sample's: the brightest takes what is left over, so that sums agree.
    const std::span<const Vec3> parts(sample.lights, asked_.lightGroups.size());
    const auto brightest = static_cast<std::size_t>(
        std::max_element(parts.begin(), parts.end(), [](const Vec3 &a, const Vec3 &b) { return luminance(a) < luminance(b); }) -
        parts.begin());
    ExactSum *sums = &lights_[pixel * lightSums()];
    for (int c = 0; c < 3; ++c) {
        ExactSum rest;
        rest.add(radiance[c]);
        for (std::size_t g = 0; g < parts.size(); ++g) {
            if (g == brightest || parts[g][c] == 0) continue;
            ExactSum part;
            part.add(parts[g][c]);
            rest.subtract(part);
            sums[3 * g + static_cast<std::size_t>(c)].add(part);
        }
        sums[3 * brightest + static_cast<std::size_t>(c)].add(rest);
    }
}

void LayerSums::merge(std::size_t pixel, const LayerSums &other, std::size_t from) {
    if (asked_.objects)
        for (const Count &count : other.objects_[from]) addTo(objects_[pixel], count.id, count.samples);
    if (asked_.materials)
        for (const Count &count : other.materials_[from]) addTo(materials_[pixel], count.id, count.samples);
    const std::size_t stride = lightSums();
    for (std::size_t i = 0; i < stride; ++i) lights_[pixel * stride + i].add(other.lights_[from * stride + i]);
    if (asked_.variance)
        for (std::size_t c = 0; c < 3; ++c) squares_[3 * pixel + c].add(other.squares_[3 * from + c]);
}

void LayerSums::copy(std::size_t first, const LayerSums &other, std::size_t from, std::size_t count) {
    const auto copyPart = [&](const auto &source, auto &target, std::size_t stride) {
        if (!target.empty())
            std::copy_n(source.begin() + static_cast<std::ptrdiff_t>(from * stride), count * stride,
                        target.begin() + static_cast<std::ptrdiff_t>(first * stride));
    };
    copyPart(other.objects_, objects_, 1);
    copyPart(other.materials_, materials_, 1);
    copyPart(other.lights_, lights_, lightSums());
    copyPart(other.squares_, squares_, 3);
}

/// Ids by their coverage, the greatest first, of equal ones the lesser id; pairs of id and coverage. What is beyond the ranks is lost.
void LayerSums::resolveMattes(const Counts &counts, std::uint32_t samples, std::vector<float> &values) const {
    Counts ranked = counts;
    std::stable_sort(ranked.begin(), ranked.end(), [](const Count &a, const Count &b) { return a.samples > b.samples; });
    ranked.resize(static_cast<std::size_t>(asked_.ranks));
    for (const Count &count : ranked) {
        values.push_back(std::bit_cast<float>(count.id));
        values.push_back(samples > 0 ? static_cast<float>(static_cast<double>(count.samples) / samples) : 0.0F);
    }
}

void LayerSums::resolve(std::size_t pixel, std::uint32_t samples, const ExactSum *rgb, std::vector<float> &values) const {
    if (asked_.objects) resolveMattes(objects_[pixel], samples, values);
    if (asked_.materials) resolveMattes(materials_[pixel], samples, values);
    const std::size_t stride = lightSums();
    const double inverse = samples > 0 ? 1.0 / samples : 0.0;
    for (std::size_t i = 0; i < stride; ++i) values.push_back(static_cast<float>(lights_[pixel * stride + i].value() * inverse));
    if (asked_.samples) values.push_back(static_cast<float>(samples));
    for (std::size_t c = 0; asked_.variance && c < 3; ++c) {
        const auto n = static_cast<long double>(samples);
        const long double sum = longValue(rgb[c]);
        const long double squares = n * longValue(squares_[3 * pixel + c]) - sum * sum; // n sum (x - mean)^2
        values.push_back(samples > 1 ? static_cast<float>(std::max(squares, 0.0L) / (n * n * (n - 1))) : kInfinity);
    }
}

void LayerSums::pack(std::size_t first, std::size_t count, std::vector<unsigned char> &out) const {
    for (const std::vector<Counts> *kind : {&objects_, &materials_}) {
        if (kind->empty()) continue;
        for (std::size_t pixel = first; pixel < first + count; ++pixel) {
            packNumber((*kind)[pixel].size(), out);
            for (const Count &c : (*kind)[pixel]) {
                packNumber(c.id, out);
                packNumber(c.samples, out);
            }
        }
    }
    const std::size_t stride = lightSums();
    for (std::size_t i = first * stride; i < (first + count) * stride; ++i) packSum(lights_[i], out);
    if (asked_.variance)
        for (std::size_t i = 3 * first; i < 3 * (first + count); ++i) packSum(squares_[i], out);
}

void LayerSums::unpack(std::span<const std::uint32_t> samples, Unpacker &in) {
    const auto unpackCounts = [&](std::vector<Counts> &kind) {
        for (const std::uint32_t all : samples) {
            Counts &counts = kind.emplace_back();
            std::uint64_t sum = 0;
            for (std::uint64_t left = in.number(); left > 0; --left) {
                const std::uint64_t id = in.number();
                const std::uint64_t own = in.number();
                sum += own;
                if (id == 0 || id > 0xffffffffU || own == 0 || sum > all || (!counts.empty() && id <= counts.back().id))
                    throw InputError("film: found a matte that is none");
                counts.push_back({static_cast<std::uint32_t>(id), static_cast<std::uint32_t>(own)});
            }
        }
    };
    if (asked_.objects) unpackCounts(objects_);
    if (asked_.materials) unpackCounts(materials_);
    for (std::size_t i = 0; i < samples.size() * lightSums(); ++i) lights_.push_back(in.sum());
    for (std::size_t i = 0; asked_.variance && i < 3 * samples.size(); ++i) squares_.push_back(in.sum());
}

} // namespace taut
