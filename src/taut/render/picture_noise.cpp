#include "taut/render/picture_noise.h"

#include "taut/base/error.h"
#include "taut/base/sobol.h"

#include <cmath>
#include <istream>
#include <ostream>

namespace taut {

namespace {

constexpr int kBisections = 40;
/// A block whose guides saw no noise may have some all the same: it is taken for this share of the mean.
constexpr double kLeastShare = 0.01;
/// Guides are looked for so many blocks around. Their standard deviations are averaged, with weights that halve from block to block: one
/// with rare light counts for less than by its variance.
constexpr int kGuideDistance = 4;
/// Samples that differ from block to block are worth their while where they save this share of the rays.
constexpr double kWorthwhile = 0.1;
/// The first decision goes this part of the way, where that is twice as far as the first pass at least.
constexpr int kPartOfTheWay = 4;
/// Controls: of the blocks one in kBlocksAControl, or kLeastControls where those are at most one in kMostControls.
constexpr std::size_t kBlocksAControl = 80;
constexpr std::size_t kLeastControls = 24;
constexpr std::size_t kMostControls = 40;
/// What is known of the factor beforehand: points that stratify each other have p from 1 to 2, so it lies between 1/3 and 1; these are its
/// mean and standard deviation over the scenes of `taut chart plan`. One control with rare light cannot make it ten.
constexpr double kUsualFactor = 0.7;
constexpr double kUsualSpread = 0.25;
constexpr double kLeastFactor = 0.2, kGreatestFactor = 1.5;
/// Chance of a block without noise by its halves to be a control, over that of an average one.
constexpr double kLeastChance = 0.1;
/// Share of what is not known of the noise that is kept in reserve.
constexpr double kMargin = 0.5;

/// A number of samples n, and n^-p.
struct Step {
    int samples = 0;
    double power = 0;
};

/// Mean over a block's values of what `value` makes of their place in the window's sums.
template <class Value> double meanOver(const Window &block, const Window &window, const Value &value) {
    double sum = 0;
    for (int y = block.y0; y < block.y1; ++y)
        for (int x = block.x0; x < block.x1; ++x)
            for (int channel = 0; channel < 3; ++channel)
                sum += value(static_cast<std::size_t>(((y - window.y0) * window.width() + x - window.x0) * 3 + channel));
    return sum / (3.0 * block.width() * block.height());
}

} // namespace

int nextSampleCount(int samples) {
    int power = 1;
    while (2 * power <= samples) power *= 2;
    return samples < power + power / 2 ? power + power / 2 : 2 * power;
}

double exponentOf(double factor) {
    return std::clamp(std::log2(1 + 1 / std::max(factor, 1e-3)), 1.0, 2.0);
}

PictureNoise::PictureNoise(const Window &window, double level, int first, int most, std::uint32_t seed)
    : grid_(window), level_(level), most_(most), seed_(seed), errors_(grid_.size()), targets_(grid_.size(), std::min(std::max(first, 2), most)) {
    for (Index i = 0; i < grid_.size(); ++i) active_.push_back(i);
}

double PictureNoise::weightOf(Index block) const {
    const Window window = grid_.windowOf(block);
    return static_cast<double>(window.width()) * window.height();
}

double PictureNoise::varianceOf(Index block) const {
    return factor_ * errors_[block].variance * std::pow(errors_[block].samples, exponentOf(factor_));
}

/// Sum over pixels of the square of what the picture is without noise.
double PictureNoise::squares() const {
    double sum = 0;
    for (Index i = 0; i < errors_.size(); ++i) sum += weightOf(i) * std::max(0.0, errors_[i].square - factor_ * errors_[i].variance);
    return sum;
}

/// What a block's chance to be a control grows with. One without noise by its halves has a small one all the same.
double PictureNoise::drawWeight(Index block, double mean) const {
    return weightOf(block) * (errors_[block].variance + kLeastChance * mean);
}

/// Over pixels, by halves.
double PictureNoise::meanVariance() const {
    double sum = 0;
    double pixels = 0;
    for (Index i = 0; i < errors_.size(); ++i) {
        sum += weightOf(i) * errors_[i].variance;
        pixels += weightOf(i);
    }
    return sum / pixels;
}

std::vector<Index> PictureNoise::controls() const {
    const std::size_t count = std::max(errors_.size() / kBlocksAControl, std::min(kLeastControls, errors_.size() / kMostControls));
    const double average = meanVariance();
    double all = 0;
    for (Index i = 0; i < errors_.size(); ++i) all += drawWeight(i, average);
    std::vector<Index> drawn;
    if (!(all > 0)) return drawn;
    // Systematic: at equal distances along the sum, from one random place.
    const double step = all / static_cast<double>(count);
    double next = step * static_cast<double>(hash(seed_, static_cast<std::uint32_t>(decisions_))) * 0x1p-32;
    double sum = 0;
    for (Index i = 0; i < errors_.size(); ++i) {
        sum += drawWeight(i, average);
        for (; next < sum && drawn.size() < count; next += step) drawn.push_back(i);
    }
    return drawn;
}

/// The factor, and what it says of the picture as it stands.
void PictureNoise::measure(const std::vector<Index> &controls, const std::vector<double> &variances) {
    const double average = meanVariance();
    double told = 0;
    double drawn = 0;
    for (Index i = 0; i < errors_.size(); ++i) {
        told += weightOf(i) * errors_[i].variance;
        drawn += drawWeight(i, average);
    }
    const auto count = static_cast<double>(controls.size());
    double mean = 0;
    double squared = 0;
    for (std::size_t k = 0; k < controls.size(); ++k) {
        const double ratio = weightOf(controls[k]) * variances[k] / drawWeight(controls[k], average) * drawn / told;
        mean += ratio / count;
        squared += ratio * ratio / count;
    }
    // Of the factor: what was measured and what is usual, each by how well it is known.
    double spread = kUsualSpread;
    factor_ = kUsualFactor;
    if (count > 1) {
        const double measured = std::max(sqr(1e-3 * mean), std::max(0.0, squared - mean * mean) / (count - 1)); // its variance
        const double weight = sqr(kUsualSpread) / (sqr(kUsualSpread) + measured);
        factor_ = std::clamp(weight * mean + (1 - weight) * kUsualFactor, kLeastFactor, kGreatestFactor);
        spread = std::sqrt(weight * measured);
    }
    const double all = squares();
    const double error = all > 0 ? std::sqrt(factor_ * told / all) : 0;
    reached_ = {error, 0.5 * error * spread / factor_, static_cast<int>(controls.size()), exponentOf(factor_)};
}

/// The level, less what is not known of the noise: whoever stops when an estimate is low enough stops at one that is too low.
double PictureNoise::aim() const {
    return level_ / (1 + (reached_.error > 0 ? kMargin * reached_.spread / reached_.error : 0));
}

std::vector<PictureNoise::Guide> PictureNoise::guidesOf(int reach) const {
    Guide all;
    double pixels = 0;
    for (Index i = 0; i < errors_.size(); ++i) {
        all.variance += weightOf(i) * varianceOf(i);
        all.rays += weightOf(i) * errors_[i].rays;
        pixels += weightOf(i);
    }
    all = {all.variance / pixels, all.rays / pixels};
    std::vector<Guide> guides(errors_.size());
    std::vector<double> deviations(errors_.size());
    for (Index i = 0; i < errors_.size(); ++i) deviations[i] = std::sqrt(varianceOf(i));
    for (Index i = 0; i < errors_.size(); ++i) {
        const int colour = grid_.colourOf(i);
        double deviation = 0;
        double rays = 0;
        double weights = 0;
        for (int dy = -kGuideDistance; dy <= kGuideDistance; ++dy)
            for (int dx = -kGuideDistance; dx <= kGuideDistance; ++dx) {
                const std::optional<Index> other = grid_.beside(i, dx, dy);
                if (!other) continue;
                const int steps = (grid_.colourOf(*other) - colour + BlockGrid::kColours) % BlockGrid::kColours;
                if (steps == 0 || steps > reach) continue;
                const double weight = std::exp2(1 - std::max(std::abs(dx), std::abs(dy)));
                deviation += weight * deviations[*other];
                rays += weight * errors_[*other].rays;
                weights += weight;
            }
        guides[i] = weights > 0 ? Guide{std::max(sqr(deviation / weights), kLeastShare * all.variance), rays / weights} : all;
    }
    return guides;
}

/// The cheapest numbers of samples with which the picture's noise is the level, none below those that there are. Blocks choose by
/// `choosing`, one for all or one for each.
PictureNoise::Allocation PictureNoise::cheapest(const std::vector<Guide> &choosing) const {
    const double p = exponentOf(factor_);
    std::vector<Step> steps; // of good numbers of samples
    for (int n = 1; n <= most_; n = nextSampleCount(n)) steps.push_back({n, std::pow(n, -p)});
    std::vector<Step> starts; // [blocks]
    std::vector<double> own;  // [blocks] v
    for (Index i = 0; i < errors_.size(); ++i) {
        starts.push_back({errors_[i].samples, std::pow(errors_[i].samples, -p)});
        own.push_back(weightOf(i) * varianceOf(i));
    }
    const auto stepOf = [&](Index i, double lambda) {
        const Guide &guide = choosing.size() == 1 ? choosing.front() : choosing[i];
        Step step = starts[i];
        // Blocks of one kind go on one after another as lambda falls, in an order that depends on their place alone.
        const double least = lambda * std::exp2(0.5 * (static_cast<double>(hash(i, 7U)) * 0x1p-32 - 0.5)) * std::max(guide.rays, 1.0);
        for (const Step &next : steps) {
            if (next.samples <= step.samples) continue;
            if (guide.variance * (step.power - next.power) < least * (next.samples - step.samples)) break;
            step = next;
        }
        return step;
    };
    const auto noise = [&](double lambda) { // sum of variances
        double sum = 0;
        for (Index i = 0; i < errors_.size(); ++i) sum += own[i] * stepOf(i, lambda).power;
        return sum;
    };
    const double allowed = sqr(aim()) * squares();
    double greatest = 0;
    for (const Guide &guide : choosing) greatest = std::max(greatest, guide.variance);
    double high = std::log(std::max(2 * greatest, 1e-290));
    double low = high - 60;
    for (int i = 0; i < kBisections; ++i) {
        const double middle = 0.5 * (low + high);
        (noise(std::exp(middle)) > allowed ? high : low) = middle;
    }
    Allocation allocation;
    for (Index i = 0; i < errors_.size(); ++i) {
        allocation.samples.push_back(stepOf(i, std::exp(low)).samples);
        allocation.cost += weightOf(i) * (allocation.samples.back() - errors_[i].samples) * errors_[i].rays;
    }
    return allocation;
}

void PictureNoise::decide(const std::vector<Index> &controls, const std::vector<double> &variances) {
    measure(controls, variances);
    active_.clear();
    if (decisions_ >= kReach.size() || reached_.error <= aim()) return;
    const bool isFirst = decisions_ == 0;
    const std::vector<Guide> guides = guidesOf(kReach[decisions_++]);
    Guide all;
    for (const Guide &guide : guides) {
        all.variance += guide.variance / static_cast<double>(guides.size());
        all.rays += guide.rays / static_cast<double>(guides.size());
    }
    Allocation wanted = cheapest(guides);
    Allocation even = cheapest({all});
    if (wanted.cost > (1 - kWorthwhile) * even.cost) wanted = std::move(even);
    for (Index i = 0; i < errors_.size(); ++i) {
        int to = wanted.samples[i];
        if (isFirst && to >= 2 * kPartOfTheWay * errors_[i].samples)
            for (to = errors_[i].samples; nextSampleCount(to) <= wanted.samples[i] / kPartOfTheWay;) to = nextSampleCount(to);
        targets_[i] = to;
        if (to > errors_[i].samples) active_.push_back(i);
    }
    if (active_.empty()) decisions_ = kReach.size();
}

double PictureNoise::done() const {
    double made = 0;
    double asked = 0;
    for (Index i = 0; i < errors_.size(); ++i) {
        made += errors_[i].samples;
        asked += targets_[i];
    }
    const double passes = static_cast<double>(kReach.size()) + 1;
    return active_.empty() ? 1 : (static_cast<double>(decisions_) + made / asked) / passes;
}

void PictureNoise::save(std::ostream &out) const {
    const std::array<std::int64_t, 3> numbers{static_cast<std::int64_t>(decisions_), static_cast<std::int64_t>(errors_.size()),
                                              static_cast<std::int64_t>(active_.size())};
    out.write(reinterpret_cast<const char *>(numbers.data()), sizeof numbers);
    const std::array<double, 5> whole{factor_, reached_.error, reached_.spread, static_cast<double>(reached_.controls), reached_.exponent};
    out.write(reinterpret_cast<const char *>(whole.data()), sizeof whole);
    for (Index i = 0; i < errors_.size(); ++i) {
        const BlockError &e = errors_[i];
        const std::array<double, 5> values{static_cast<double>(e.samples), e.variance, e.square, e.rays, static_cast<double>(targets_[i])};
        out.write(reinterpret_cast<const char *>(values.data()), sizeof values);
    }
    out.write(reinterpret_cast<const char *>(active_.data()), static_cast<std::streamsize>(active_.size() * sizeof(Index)));
}

void PictureNoise::load(std::istream &in) {
    const auto read = [&](void *to, std::size_t bytes) {
        if (!in.read(static_cast<char *>(to), static_cast<std::streamsize>(bytes)))
            throw InputError("saved frame: found its end early, expected the noise of its blocks");
    };
    const auto readNumbers = [&](auto &values) {
        read(values.data(), sizeof values);
        for (const double value : values)
            if (!std::isfinite(value) || value < 0) throw InputError("saved frame: found a block's noise that is none, expected finite numbers");
    };
    std::array<std::int64_t, 3> numbers{};
    read(numbers.data(), sizeof numbers);
    const auto [decisions, blocks, active] = numbers;
    if (blocks != static_cast<std::int64_t>(errors_.size()) || active < 0 || active > blocks || decisions < 0 ||
        decisions > static_cast<std::int64_t>(kReach.size()))
        throw InputError("saved frame: found blocks of another frame, expected those of this one");
    std::array<double, 5> whole{};
    readNumbers(whole);
    factor_ = std::max(whole[0], kLeastFactor);
    reached_ = {whole[1], whole[2], static_cast<int>(std::min(whole[3], 1e9)), whole[4]};
    for (Index i = 0; i < errors_.size(); ++i) {
        std::array<double, 5> values{};
        readNumbers(values);
        if (!(values[0] <= values[4] && values[4] <= most_))
            throw InputError("saved frame: found a block's samples that are none, expected at most " + std::to_string(most_));
        errors_[i] = {static_cast<int>(values[0]), values[1], values[2], values[3]};
        targets_[i] = static_cast<int>(values[4]);
    }
    active_.resize(static_cast<std::size_t>(active));
    read(active_.data(), active_.size() * sizeof(Index));
    for (const Index block : active_)
        if (block >= errors_.size()) throw InputError("saved frame: found a block that is none, expected one of its window");
    decisions_ = static_cast<std::size_t>(decisions);
}

void ColourSums::fill(const Film &film, const Window &window, std::vector<double> &sums) {
    sums.clear();
    for (int y = window.y0; y < window.y1; ++y)
        for (int x = window.x0; x < window.x1; ++x)
            for (std::size_t channel = 0; channel < 3; ++channel) sums.push_back(film.sumAt(x, y, channel).value());
}

BlockError blockErrorOf(const Window &block, const Window &window, const ColourSums &sums, int middle, int last) {
    const double before = middle;
    const double added = last - middle;
    const double difference = meanOver(block, window, [&](std::size_t i) {
        const double d = sums.half[i] / before - (sums.all[i] - sums.half[i]) / added;
        return d * d;
    });
    const double square = meanOver(block, window, [&](std::size_t i) { return sums.all[i] * sums.all[i]; });
    const double n = last;
    return {last, difference * before * added / (n * n), square / (n * n), 0};
}

} // namespace taut
