#include "taut/render/film.h"

#include "taut/base/error.h"

#include <algorithm>
#include <array>
#include <istream>
#include <ostream>

namespace taut {

namespace {

constexpr std::string_view kMagic = "taut film 1\n";
/// Pixels whose sums are read or written at once.
constexpr std::size_t kBlock = 4096;

static_assert(std::endian::native == std::endian::little, "films are written in the machine's order");

template <class T> void writeRaw(std::ostream &out, const T *values, std::size_t count) {
    out.write(reinterpret_cast<const char *>(values), static_cast<std::streamsize>(count * sizeof(T)));
}

template <class T> void readRaw(std::istream &in, T *values, std::size_t count) {
    if (!in.read(reinterpret_cast<char *>(values), static_cast<std::streamsize>(count * sizeof(T))))
        throw InputError("film: found its end early, expected as many sums as its head says");
}

/// Appends `count` values from the stream; memory grows with what is really there.
template <class T> void appendRaw(std::istream &in, std::size_t count, std::vector<T> &values) {
    for (std::size_t done = 0; done < count; done += kBlock) {
        const std::size_t block = std::min(kBlock, count - done);
        values.resize(values.size() + block);
        readRaw(in, values.data() + values.size() - block, block);
    }
}

} // namespace

Film::Film(const Window &window, const std::vector<Aov> &aovs) : window_(window), aovs_(aovs) {
    for (const Aov aov : aovs_) stride_ += infoOf(aov).channels.size();
    const std::size_t pixels = window.empty() ? 0 : static_cast<std::size_t>(window.width()) * static_cast<std::size_t>(window.height());
    counts_.assign(pixels, 0);
    hits_.assign(pixels, 0);
    sums_.assign(pixels * stride_, {});
}

std::vector<std::string> Film::channelNames() const {
    std::vector<std::string> names{"R", "G", "B", "A"};
    for (const Aov aov : aovs_) {
        const auto &channels = infoOf(aov).channels;
        names.insert(names.end(), channels.begin(), channels.end());
    }
    return names;
}

void Film::add(int x, int y, const Vec3 &radiance, float alpha, const float *aovs) {
    const std::size_t pixel = pixelAt(x, y);
    ++counts_[pixel];
    ExactSum *sum = &sums_[pixel * stride_];
    for (int c = 0; c < 3; ++c) sum[c].add(radiance[c]);
    sum[3].add(alpha);
    if (aovs == nullptr) return;
    ++hits_[pixel];
    for (std::size_t c = 4; c < stride_; ++c) sum[c].add(aovs[c - 4]);
}

void Film::merge(const Film &other) {
    if (other.aovs_ != aovs_) throw InputError("film: found a film with other AOVs, expected the same ones to merge");
    if (!window_.contains(other.window_)) {
        Film both(unionOf(window_, other.window_), aovs_);
        both.merge(*this);
        *this = std::move(both);
    }
    for (int y = other.window_.y0; y < other.window_.y1; ++y)
        for (int x = other.window_.x0; x < other.window_.x1; ++x) {
            const std::size_t from = other.pixelAt(x, y);
            const std::size_t to = pixelAt(x, y);
            counts_[to] += other.counts_[from];
            hits_[to] += other.hits_[from];
            for (std::size_t c = 0; c < stride_; ++c) sums_[to * stride_ + c].add(other.sums_[from * stride_ + c]);
        }
}

void Film::copy(const Film &from, const Window &part) {
    const auto width = static_cast<std::size_t>(part.width());
    for (int y = part.y0; y < part.y1; ++y) {
        const std::size_t source = from.pixelAt(part.x0, y);
        const std::size_t target = pixelAt(part.x0, y);
        std::copy_n(&from.counts_[source], width, &counts_[target]);
        std::copy_n(&from.hits_[source], width, &hits_[target]);
        std::copy_n(&from.sums_[source * stride_], width * stride_, &sums_[target * stride_]);
    }
}

int Film::samples() const {
    return counts_.empty() ? 0 : static_cast<int>(*std::max_element(counts_.begin(), counts_.end()));
}

double Film::meanSamples() const {
    double sum = 0;
    for (const std::uint32_t count : counts_) sum += count;
    return counts_.empty() ? 0 : sum / static_cast<double>(counts_.size());
}

double Film::luminanceSum(int x, int y) const {
    const ExactSum *sum = &sums_[pixelAt(x, y) * stride_];
    return 0.2126 * sum[0].value() + 0.7152 * sum[1].value() + 0.0722 * sum[2].value();
}

std::vector<float> Film::resolve() const {
    std::vector<float> values;
    values.reserve(sums_.size());
    for (std::size_t p = 0; p < counts_.size(); ++p) {
        const ExactSum *sum = &sums_[p * stride_];
        const double inverse = counts_[p] > 0 ? 1.0 / counts_[p] : 0.0;
        for (std::size_t c = 0; c < 4; ++c) values.push_back(static_cast<float>(sum[c].value() * inverse));
        for (std::size_t c = 4; c < stride_; ++c) values.push_back(hits_[p] > 0 ? static_cast<float>(sum[c].value() / hits_[p]) : 0.0F);
    }
    return values;
}

void Film::save(std::ostream &out) const {
    out << kMagic;
    for (const Aov aov : aovs_) out << infoOf(aov).name << ' ';
    out << '\n';
    const std::array<std::int32_t, 4> window{window_.x0, window_.y0, window_.x1, window_.y1};
    writeRaw(out, window.data(), window.size());
    writeRaw(out, counts_.data(), counts_.size());
    writeRaw(out, hits_.data(), hits_.size());
    std::vector<std::uint64_t> words;
    for (std::size_t begin = 0; begin < sums_.size(); begin += kBlock) {
        words.clear();
        for (std::size_t i = begin; i < std::min(begin + kBlock, sums_.size()); ++i) {
            words.push_back(sums_[i].low());
            words.push_back(static_cast<std::uint64_t>(sums_[i].high()));
        }
        writeRaw(out, words.data(), words.size());
    }
}

Film Film::load(std::istream &in) {
    std::string magic(kMagic.size(), ' ');
    if (!in.read(magic.data(), static_cast<std::streamsize>(magic.size())) || magic != kMagic)
        throw InputError("film: found other bytes at its begin, expected 'taut film 1'");
    std::vector<Aov> aovs;
    std::string name;
    for (int c = in.get(); c != '\n'; c = in.get()) {
        if (c == std::istream::traits_type::eof() || name.size() > 64) throw InputError("film: found no end of the names of its AOVs");
        if (c != ' ') {
            name += static_cast<char>(c);
            continue;
        }
        const std::string_view view = name;
        aovs.push_back(aovsNamed({&view, 1}, "film").front());
        name.clear();
    }
    std::array<std::int32_t, 4> w{};
    readRaw(in, w.data(), w.size());
    const Window window{w[0], w[1], w[2], w[3]};
    constexpr int kMost = 1 << 20;
    const bool inRange = std::all_of(w.begin(), w.end(), [](int v) { return v >= 0 && v <= kMost; });
    if (!inRange || window.width() < 0 || window.height() < 0) throw InputError("film: found a window that is none, expected x0 y0 x1 y1");
    Film film({}, aovs);
    film.window_ = window;
    const auto pixels = static_cast<std::size_t>(window.width()) * static_cast<std::size_t>(window.height());
    appendRaw(in, pixels, film.counts_);
    appendRaw(in, pixels, film.hits_);
    std::vector<std::uint64_t> words;
    for (std::size_t done = 0; done < pixels * film.stride_; done += kBlock) {
        const std::size_t block = std::min(kBlock, pixels * film.stride_ - done);
        words.resize(2 * block);
        readRaw(in, words.data(), words.size());
        for (std::size_t i = 0; i < block; ++i) film.sums_.emplace_back(words[2 * i], static_cast<std::int64_t>(words[2 * i + 1]));
    }
    return film;
}

} // namespace taut
