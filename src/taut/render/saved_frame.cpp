#include "taut/render/saved_frame.h"

#include "taut/base/checked_stream.h"
#include "taut/base/error.h"
#include "taut/render/embree_scene.h"

#include <nlohmann/json.hpp>

#ifdef __GLIBC__
#include <gnu/libc-version.h>
#endif

#include <algorithm>
#include <array>
#include <filesystem>
#include <limits>
#include <optional>

namespace taut {

namespace {

using nlohmann::json;

constexpr std::string_view kSavedMagic = "taut saved frame 1\n";
constexpr std::size_t kLongestHead = 1 << 24;
constexpr int kMostParts = 1 << 20;
constexpr int kMostPixels = 1 << 20; ///< a side
/// Differences that an error tells of; the others are counted.
constexpr std::size_t kTold = 3;
/// Rows of pixels that are traced together: parts that begin with them are traced as the whole is.
constexpr int kTileRows = 16;

const char *nameOf(SplitBy by) {
    return by == SplitBy::Samples ? "samples" : "rows";
}

json toJson(const StageTimes &t) {
    return {t.deformation, t.gradient, t.bvh, t.cameraRays, t.scatteredRays, t.shadowRays, t.shading, t.film};
}

json toJson(const RayCounts &c) {
    return {c.paths, c.camera, c.scattered, c.shadow, c.notFinite};
}

StageTimes timesFrom(const json &j) {
    const auto at = [&](std::size_t i) { return j.at(i).get<double>(); };
    return {at(0), at(1), at(2), at(3), at(4), at(5), at(6), at(7)};
}

RayCounts countsFrom(const json &j) {
    const auto at = [&](std::size_t i) { return j.at(i).get<std::uint64_t>(); };
    return {at(0), at(1), at(2), at(3), at(4)};
}

json toJson(const ImageSettings &s) {
    return {{"exposure", s.view.exposure}, {"view", s.view.view},     {"display", s.view.display},
            {"look", s.view.look},         {"config", s.view.config}, {"space", s.view.space},
            {"exr_half", s.exrHalf},       {"png_bits", s.pngBits},   {"compression", s.exrCompression}};
}

ImageSettings settingsFrom(const json &j) {
    ImageSettings s;
    const auto text = [&](const char *key) { return j.at(key).get<std::string>(); };
    s.view = {j.at("exposure").get<double>(), text("view"), text("display"), text("look"), text("config"), text("space")};
    s.exrHalf = j.at("exr_half").get<bool>();
    s.pngBits = j.at("png_bits").get<int>() == 16 ? 16 : 8;
    s.exrCompression = text("compression");
    return s;
}

std::string textOf(const SavedHead &head) {
    const json j{{"facts", head.facts},         {"by", nameOf(head.part.by)},
                 {"part", head.part.index},     {"parts", head.part.count},
                 {"frame", head.frame},         {"width", head.width},
                 {"height", head.height},       {"window", {head.window.x0, head.window.y0, head.window.x1, head.window.y1}},
                 {"metadata", head.metadata},   {"image", toJson(head.image)},
                 {"done", head.done},           {"seconds", head.seconds},
                 {"times", toJson(head.times)}, {"counts", toJson(head.counts)}};
    return j.dump(-1, ' ', false, json::error_handler_t::replace);
}

SavedHead headFrom(const std::string &text) {
    const json j = json::parse(text);
    SavedHead head;
    head.facts = j.at("facts").get<FrameFacts>();
    head.part = {j.at("by") == nameOf(SplitBy::Rows) ? SplitBy::Rows : SplitBy::Samples, j.at("part").get<int>(), j.at("parts").get<int>()};
    head.frame = j.at("frame").get<int>();
    head.width = j.at("width").get<int>();
    head.height = j.at("height").get<int>();
    const auto window = j.at("window").get<std::array<int, 4>>();
    head.window = {window[0], window[1], window[2], window[3]};
    head.metadata = j.at("metadata").get<Metadata>();
    if (j.contains("image")) head.image = settingsFrom(j.at("image")); // else of before there were any
    head.done = j.at("done").get<bool>();
    head.seconds = j.at("seconds").get<double>();
    head.times = timesFrom(j.at("times"));
    head.counts = countsFrom(j.at("counts"));
    return head;
}

/// Numbers that no frame has, before anything is reckoned with them.
void checkHead(const SavedHead &head, const Location &where) {
    const auto inRange = [&](const char *what, int value, int least, int most) {
        if (value < least || value > most)
            failInput(where, std::string(what) + ' ' + std::to_string(value), std::to_string(least) + " to " + std::to_string(most));
    };
    inRange("number of parts", head.part.count, 1, kMostParts);
    inRange("part", head.part.index, 1, head.part.count);
    inRange("width", head.width, 1, kMostPixels);
    inRange("height", head.height, 1, kMostPixels);
    inRange("left edge of the window", head.window.x0, 0, head.width);
    inRange("upper edge of the window", head.window.y0, 0, head.height);
    inRange("right edge of the window", head.window.x1, head.window.x0, head.width);
    inRange("lower edge of the window", head.window.y1, head.window.y0, head.height);
}

/// From a stream that ends before the hash. `path`: for errors.
SavedHead readHead(std::istream &in, const std::string &path) {
    const Location where{path, 0, 0, -1};
    std::string magic(kSavedMagic.size(), ' ');
    if (!in.read(magic.data(), static_cast<std::streamsize>(magic.size())) || magic != kSavedMagic)
        failInput(where, "a file that is no saved frame", "a checkpoint or shard of this version");
    std::string text;
    for (int c = in.get(); c != '\n'; c = in.get()) {
        if (c == std::istream::traits_type::eof() || text.size() >= kLongestHead) failInput(where, "no end of its head", "a line of JSON");
        text += static_cast<char>(c);
    }
    try {
        SavedHead head = headFrom(text);
        checkHead(head, where);
        return head;
    } catch (const json::exception &) {
        failInput(where, "a head that can't be read", "what a saved frame says of itself");
    }
}

/// An error about the saved sums, with the file it is about.
template <class Read> auto namingFile(const std::string &path, const Read &read) {
    try {
        return read();
    } catch (const InputError &error) {
        const std::string what = error.what();
        throw InputError(what.compare(0, path.size(), path) == 0 ? what : path + ": " + what);
    }
}

const std::string *valueOf(const FrameFacts &facts, const std::string &name) {
    const auto found = std::find_if(facts.begin(), facts.end(), [&](const auto &fact) { return fact.first == name; });
    return found == facts.end() ? nullptr : &found->second;
}

/// Its functions of floats are not the same bits in every version.
std::string libraryVersion() {
#ifdef __GLIBC__
    return gnu_get_libc_version();
#else
    return "not known";
#endif
}

std::string joined(const std::vector<int> &numbers) {
    std::string text;
    for (const int n : numbers) text += (text.empty() ? "" : ",") + std::to_string(n);
    return text.size() <= 80 ? text : std::to_string(numbers.size()) + " (" + contentHash(text) + ")";
}

int splitAt(int whole, int index, int count) {
    return static_cast<int>(static_cast<std::int64_t>(whole) * index / count);
}

} // namespace

std::string textOf(const FramePart &part) {
    return std::to_string(part.index) + " of " + std::to_string(part.count) + " by " + nameOf(part.by);
}

FrameOptions optionsOfPart(const FrameOptions &whole, const FramePart &part, const RenderSettings &render) {
    if (part.count == 1) return whole;
    if (whole.noise || whole.picture || whole.seconds)
        throw InputError("shard " + textOf(part) + ": found a frame to an error, noise level or time, expected a number of samples");
    FrameOptions options = whole;
    if (part.by == SplitBy::Samples) {
        if (whole.spp < part.count)
            throw InputError("shard " + textOf(part) + ": found " + std::to_string(whole.spp) + " samples a pixel, expected one a shard");
        const int first = splitAt(whole.spp, part.index - 1, part.count);
        options.firstSample = whole.firstSample + first;
        options.spp = splitAt(whole.spp, part.index, part.count) - first;
        return options;
    }
    if (options.window.empty()) options.window = {0, 0, render.width, render.height};
    const int rows = options.window.height();
    if (rows < part.count)
        throw InputError("shard " + textOf(part) + ": found " + std::to_string(rows) + " rows of pixels, expected one a shard");
    const int unit = rows / kTileRows >= part.count ? kTileRows : 1;
    const int units = (rows + unit - 1) / unit;
    const Window &w = options.window;
    options.window.y1 = std::min(w.y0 + unit * splitAt(units, part.index, part.count), w.y1);
    options.window.y0 = w.y0 + unit * splitAt(units, part.index - 1, part.count);
    return options;
}

FrameFacts inputFacts(const Scene &scene) {
    namespace fs = std::filesystem;
    const fs::path folder = fs::path(scene.path).parent_path();
    FrameFacts facts;
    for (const std::string &path : scene.inputs) {
        const fs::path relative = fs::path(path).lexically_relative(folder.empty() ? "." : folder);
        facts.emplace_back("contents of " + (relative.empty() ? fs::path(path) : relative).generic_string(), contentHashOfFile(path));
    }
    return facts;
}

FrameFacts settingFacts(const Scene &scene, const FrameOptions &whole, int frame) {
    const RenderSettings &r = scene.render;
    const Window w = whole.window.empty() ? Window{0, 0, r.width, r.height} : whole.window;
    std::string aovs;
    for (const Aov aov : whole.aovs) aovs += (aovs.empty() ? "" : ",") + std::string(infoOf(aov).name);
    for (const std::string &word : whole.layers.words()) aovs += (aovs.empty() ? "" : ",") + word;
    const auto text = [](const auto value) { return std::to_string(value); };
    FrameFacts facts{{"version", TAUT_VERSION},
                     {"version of Embree", std::string(embreeVersion())},
                     {"version of the C library", libraryVersion()},
                     {"frame", text(frame)},
                     {"frames", joined(r.frames)},
                     {"size", text(r.width) + "x" + text(r.height)},
                     {"pixels", text(w.x0) + "," + text(w.y0) + "," + text(w.x1) + "," + text(w.y1)},
                     {"samples a pixel", text(whole.spp)},
                     {"noise level", whole.noise ? formatNumber(*whole.noise) : "none"},
                     {"noise of the picture", whole.picture ? formatNumber(whole.picture->noise) : "any"},
                     {"time a frame", whole.seconds ? formatNumber(*whole.seconds) + " s" : "any"},
                     {"seed", text(whole.seed) + (whole.independent ? ", samples independent" : "")},
                     {"AOVs", aovs.empty() ? "none" : aovs}};
    if (whole.shares) facts.emplace_back("samples", "shared by pixels");
    if (whole.denoiseBlock > 0) facts.emplace_back("denoising", "halves in blocks of " + text(whole.denoiseBlock));
    return facts;
}

std::string differenceOf(const FrameFacts &found, const FrameFacts &expected) {
    std::string text;
    std::size_t count = 0;
    const auto tell = [&](const std::string &name, const std::string &is, const std::string &shouldBe) {
        if (++count <= kTold) text += (text.empty() ? "found " : "; ") + name + " " + is + ", expected " + shouldBe;
    };
    for (const auto &[name, value] : expected) {
        const std::string *other = valueOf(found, name);
        if (other == nullptr || *other != value) tell(name, other == nullptr ? "not given" : *other, value);
    }
    for (const auto &[name, value] : found)
        if (valueOf(expected, name) == nullptr) tell(name, value, "none");
    if (count > kTold) text += "; and " + std::to_string(count - kTold) + " more";
    return text;
}

void writeSavedFrame(const std::string &path, const SavedHead &head, const FrameRender &frame) {
    makeFolderOf(path);
    CheckedWriter writer(path);
    writer.stream() << kSavedMagic << textOf(head) << '\n';
    frame.save(writer.stream());
    writer.finish();
}

SavedHead resumeSavedFrame(const std::string &path, const SavedHead &expected, FrameRender &frame) {
    // The hash is looked at before the frame is touched.
    CheckedReader check(path);
    readHead(check.stream(), path);
    check.stream().ignore(std::numeric_limits<std::streamsize>::max());
    check.finish();

    CheckedReader reader(path);
    const SavedHead head = readHead(reader.stream(), path);
    if (const std::string difference = differenceOf(head.facts, expected.facts); !difference.empty())
        throw InputError(path + ": " + difference);
    if (head.part != expected.part) throw InputError(path + ": found shard " + textOf(head.part) + ", expected " + textOf(expected.part));
    namingFile(path, [&] { frame.restore(reader.stream()); });
    return head;
}

SavedHead readSavedHead(const std::string &path) {
    CheckedReader reader(path);
    return readHead(reader.stream(), path);
}

namespace {

struct Shard {
    std::string path;
    SavedHead head;
};

/// All of one frame, and each once; in the order of their numbers.
void check(std::vector<Shard> &shards) {
    const Shard &first = shards.front();
    const int count = first.head.part.count;
    for (const Shard &s : shards) {
        if (const std::string difference = differenceOf(s.head.facts, first.head.facts); !difference.empty())
            throw InputError(s.path + ": found a shard of something else than " + first.path + ": " + difference);
        if (s.head.part.count != count || s.head.part.by != first.head.part.by)
            throw InputError(s.path + ": found shard " + textOf(s.head.part) + " beside " + first.path + ", expected one of " +
                             std::to_string(count) + " by " + nameOf(first.head.part.by));
        if (!s.head.done) throw InputError(s.path + ": found a frame that is not done, expected a whole shard (taut render --resume)");
        if (s.head.part.index < 1 || s.head.part.index > count)
            throw InputError(s.path + ": found shard " + textOf(s.head.part) + ", expected one from 1 on");
    }
    std::stable_sort(shards.begin(), shards.end(), [](const Shard &a, const Shard &b) { return a.head.part.index < b.head.part.index; });
    for (std::size_t i = 1; i < shards.size(); ++i)
        if (shards[i].head.part.index == shards[i - 1].head.part.index)
            throw InputError(shards[i].path + ": found shard " + textOf(shards[i].head.part) + " a second time, as " + shards[i - 1].path +
                             ", expected it once");
    std::vector<int> missing;
    for (int i = 1, next = 0; i <= count; ++i)
        if (static_cast<std::size_t>(next) < shards.size() && shards[static_cast<std::size_t>(next)].head.part.index == i)
            ++next;
        else
            missing.push_back(i);
    if (!missing.empty())
        throw InputError("frame " + std::to_string(first.head.frame) + ": found no shard " + joined(missing) + " of " +
                         std::to_string(count) + ", expected all of them");
}

std::vector<Shard> checkedShards(const std::vector<std::string> &paths) {
    if (paths.empty()) throw InputError("merge: found no shards, expected all of a frame");
    std::vector<Shard> shards;
    shards.reserve(paths.size());
    for (const std::string &path : paths) shards.push_back({path, readSavedHead(path)});
    check(shards);
    return shards;
}

} // namespace

void checkShards(const std::vector<std::string> &paths) {
    checkedShards(paths);
}

MergedFrame mergeShards(const std::vector<std::string> &paths) {
    const std::vector<Shard> shards = checkedShards(paths);
    SavedHead whole = shards.front().head;
    whole.seconds = 0;
    whole.times = {};
    whole.counts = {};
    std::uint64_t bytes = 0;
    for (const Shard &shard : shards) bytes += std::filesystem::file_size(shard.path);
    const auto pixels = static_cast<std::uint64_t>(whole.window.width()) * static_cast<std::uint64_t>(whole.window.height());
    std::optional<Film> sum;
    for (const Shard &shard : shards) {
        CheckedReader reader(shard.path);
        const SavedHead head = readHead(reader.stream(), shard.path);
        const Film film = namingFile(shard.path, [&] {
            Film read = FrameRender::savedFilm(reader.stream());
            reader.finish();
            return read;
        });
        if (pixels > bytes || !whole.window.contains(film.window()))
            throw InputError(shard.path + ": found other pixels than its head says, expected those of its frame");
        if (!sum) sum.emplace(whole.window, film.aovs(), film.layers(), film.denoiseBlock());
        namingFile(shard.path, [&] { sum->merge(film); });
        whole.seconds += head.seconds;
        whole.times += head.times;
        whole.counts += head.counts;
    }
    return {std::move(whole), std::move(*sum)};
}

} // namespace taut
