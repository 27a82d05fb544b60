#include "taut/render/film.h"

#include "taut/base/error.h"
#include "taut/render/sum_packing.h"

#include <algorithm>
#include <array>
#include <bit>
#include <istream>
#include <ostream>

namespace taut {

namespace {

constexpr std::string_view kFilmMagic = "taut film 2\n";
/// Among the names of its AOVs: sums for denoising follow.
constexpr std::string_view kDenoise = "+denoise2";
/// Sums of shared samples follow.
constexpr std::string_view kShares = "+shared1";
/// Pixels that are read or written at once.
constexpr std::size_t kFilmBlock = 4096;
/// Before the words of layers, among the names of AOVs.
constexpr char kLayerMark = '+';
/// Bytes of a stream that can't tell how many it has.
constexpr std::uint64_t kUnknownSize = std::uint64_t{1} << 30;

static_assert(std::endian::native == std::endian::little, "films are written in the machine's order");

template <class T> void writeRaw(std::ostream &out, const T *values, std::size_t count) {
    out.write(reinterpret_cast<const char *>(values), static_cast<std::streamsize>(count * sizeof(T)));
}

template <class T> void readRaw(std::istream &in, T *values, std::size_t count) {
    if (!in.read(reinterpret_cast<char *>(values), static_cast<std::streamsize>(count * sizeof(T)))) throw InputError(kFilmEndsEarly);
}

/// Of a stream that can tell; of another, what a file may have.
std::uint64_t bytesLeft(std::istream &in) {
    std::streambuf &buffer = *in.rdbuf();
    const auto here = buffer.pubseekoff(0, std::ios::cur, std::ios::in);
    const auto end = buffer.pubseekoff(0, std::ios::end, std::ios::in);
    if (here < 0 || end < 0 || buffer.pubseekpos(here, std::ios::in) != here) return kUnknownSize;
    return static_cast<std::uint64_t>(end - here);
}

} // namespace

Film::Film(const Window &window, const std::vector<Aov> &aovs, const FilmLayers &layers, int denoiseBlock, bool shares)
    : window_(window), aovs_(aovs), layers_(layers) {
    if (denoiseBlock > 0) denoise_.emplace(window, denoiseBlock);
    if (shares) shared_.emplace(window);
    for (const Aov aov : aovs_) stride_ += infoOf(aov).channels.size();
    const std::size_t pixels = window.empty() ? 0 : static_cast<std::size_t>(window.width()) * static_cast<std::size_t>(window.height());
    layers_.resize(pixels);
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
    const std::vector<std::string> layered = layers_.asked().channelNames();
    names.insert(names.end(), layered.begin(), layered.end());
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
    if (other.aovs_ != aovs_ || other.layers() != layers())
        throw InputError("film: found a film with other AOVs, expected the same ones to merge");
    if (other.denoise_.has_value() != denoise_.has_value())
        throw InputError("film: found sums for denoising in one film and none in the other, expected them in both or in none");
    if (shared_ || other.shared_) throw InputError("film: found pixels that share their samples, expected films of even samples to merge");
    if (!window_.contains(other.window_)) {
        Film both(unionOf(window_, other.window_), aovs_, layers(), denoiseBlock());
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
            layers_.merge(to, other.layers_, from);
        }
    if (denoise_) denoise_->merge(*other.denoise_);
}

void Film::copy(const Film &from, const Window &part) {
    if (denoise_ && from.denoise_) denoise_->copy(*from.denoise_, part);
    if (shared_ && from.shared_) shared_->copy(*from.shared_, part);
    const auto width = static_cast<std::size_t>(part.width());
    for (int y = part.y0; y < part.y1; ++y) {
        const std::size_t source = from.pixelAt(part.x0, y);
        const std::size_t target = pixelAt(part.x0, y);
        std::copy_n(&from.counts_[source], width, &counts_[target]);
        std::copy_n(&from.hits_[source], width, &hits_[target]);
        std::copy_n(&from.sums_[source * stride_], width * stride_, &sums_[target * stride_]);
        layers_.copy(target, from.layers_, source, width);
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

std::vector<std::array<float, 4>> Film::colours() const {
    if (shared_) return shared_->resolve(counts_);
    std::vector<std::array<float, 4>> colours(counts_.size());
    for (std::size_t p = 0; p < counts_.size(); ++p) {
        const double inverse = counts_[p] > 0 ? 1.0 / counts_[p] : 0.0;
        for (std::size_t c = 0; c < 4; ++c) colours[p][c] = static_cast<float>(sums_[p * stride_ + c].value() * inverse);
    }
    return colours;
}

std::vector<float> Film::resolve() const {
    const std::vector<std::array<float, 4>> colours = this->colours();
    std::vector<float> values;
    values.reserve(counts_.size() * channelNames().size());
    for (std::size_t p = 0; p < counts_.size(); ++p) {
        const ExactSum *sum = &sums_[p * stride_];
        values.insert(values.end(), colours[p].begin(), colours[p].end());
        for (std::size_t c = 4; c < stride_; ++c) values.push_back(hits_[p] > 0 ? static_cast<float>(sum[c].value() / hits_[p]) : 0.0F);
        layers_.resolve(p, counts_[p], sum, values);
    }
    return values;
}

void Film::save(std::ostream &out) const {
    out << kFilmMagic;
    for (const Aov aov : aovs_) out << infoOf(aov).name << ' ';
    for (const std::string &word : layers().words()) out << kLayerMark << word << ' ';
    if (denoise_) out << kDenoise << ' ';
    if (shared_) out << kShares << ' ';
    out << '\n';
    const std::array<std::int32_t, 4> window{window_.x0, window_.y0, window_.x1, window_.y1};
    writeRaw(out, window.data(), window.size());
    std::vector<unsigned char> bytes;
    for (std::size_t first = 0; first < counts_.size(); first += kFilmBlock) {
        const std::size_t block = std::min(kFilmBlock, counts_.size() - first);
        bytes.clear();
        packCounts({counts_.data() + first, block}, bytes);
        packCounts({hits_.data() + first, block}, bytes);
        for (std::size_t i = first * stride_; i < (first + block) * stride_; ++i) packSum(sums_[i], bytes);
        layers_.pack(first, block, bytes);
        writeRaw(out, bytes.data(), bytes.size());
    }
    if (denoise_) denoise_->save(out);
    if (shared_) shared_->save(out);
}

Film Film::load(std::istream &in) {
    std::string magic(kFilmMagic.size(), ' ');
    if (!in.read(magic.data(), static_cast<std::streamsize>(magic.size())) || magic != kFilmMagic)
        throw InputError("film: found other bytes at its begin, expected 'taut film 2'");
    std::vector<Aov> aovs;
    FilmLayers layers;
    bool denoises = false;
    bool shares = false;
    std::string name;
    for (int c = in.get(); c != '\n'; c = in.get()) {
        if (c == std::istream::traits_type::eof() || name.size() > 64) throw InputError("film: found no end of the names of its AOVs");
        if (c != ' ') {
            name += static_cast<char>(c);
            continue;
        }
        const std::string_view view = name;
        if (view == kDenoise)
            denoises = true;
        else if (view == kShares)
            shares = true;
        else if (view.starts_with(kLayerMark))
            layers.addWord(view.substr(1));
        else
            aovs.push_back(aovsNamed({&view, 1}, "film").front());
        name.clear();
    }
    std::array<std::int32_t, 4> w{};
    readRaw(in, w.data(), w.size());
    const Window window{w[0], w[1], w[2], w[3]};
    constexpr int kMost = 1 << 20;
    const bool inRange = std::all_of(w.begin(), w.end(), [](int v) { return v >= 0 && v <= kMost; });
    if (!inRange || window.width() < 0 || window.height() < 0) throw InputError("film: found a window that is none, expected x0 y0 x1 y1");
    Film film({}, aovs, layers);
    film.window_ = window;
    const auto pixels = static_cast<std::size_t>(window.width()) * static_cast<std::size_t>(window.height());
    // A sum has a byte at least: no head asks for more memory than its file is worth.
    const std::uint64_t left = bytesLeft(in);
    if (pixels > left / film.stride_) throw InputError(kFilmEndsEarly);
    film.counts_.reserve(pixels);
    film.hits_.reserve(pixels);
    film.sums_.reserve(pixels * film.stride_);
    Unpacker unpacker(in);
    for (std::size_t first = 0; first < pixels; first += kFilmBlock) {
        const std::size_t last = std::min(first + kFilmBlock, pixels);
        film.counts_.resize(last);
        film.hits_.resize(last);
        unpacker.counts({film.counts_.data() + first, last - first});
        unpacker.counts({film.hits_.data() + first, last - first});
        for (std::size_t i = first * film.stride_; i < last * film.stride_; ++i) film.sums_.push_back(unpacker.sum());
        film.layers_.unpack(std::span(film.counts_).subspan(first, last - first), unpacker);
    }
    if (denoises) film.denoise_ = DenoiseSums::load(in, window);
    if (shares) film.shared_ = SharedSums::load(in, window);
    return film;
}

} // namespace taut
