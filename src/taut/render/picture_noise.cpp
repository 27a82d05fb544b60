#include "taut/render/picture_noise.h"

#include "taut/base/sobol.h"

#include <cmath>

namespace taut {

namespace {

constexpr int kBisections = 24;
/// A block whose guides saw no noise may have some all the same: it is taken for this share of the mean.
constexpr double kLeastShare = 0.01;
/// Guides are looked for so many blocks around. Their standard deviations are averaged, with weights that fall to a fourth from block to
/// block: one with rare light counts for less than by its variance.
constexpr int kGuideDistance = 4;
constexpr std::array<double, kGuideDistance + 1> kGuideWeights{4, 1, 0x1p-2, 0x1p-4, 0x1p-6};
/// Samples that differ from block to block are worth their while where they save this share of the cost.
constexpr double kWorthwhile = 0.05;
/// The first decision goes this part of the way, where that is twice as far as the first pass at least, and no further than would do if the
/// variance fell with the square of the number of samples.
constexpr int kPartOfTheWay = 4;
/// The second goes to where the noise is so much above the aim: what it knows of the factor is of fewer samples.
constexpr double kAlmost = 1.04;
/// Controls are parts of so many pixels a side. Their number is the two thirds power of that of the pixels over kPixels, where what they
/// cost and the reserve for what they leave unknown are least together, and at most one for kPixelsAControl.
constexpr int kControlSide = 2;
constexpr double kPixels = 16;
constexpr double kPixelsAControl = 128;
/// They are drawn once the noise by halves is at most this times the level.
constexpr double kNear = 2.5;
/// A block's chance to hold a control grows with this power of its variance: once samples are where they are needed, noise and time of all
/// blocks are more alike than they were.
constexpr double kChancePower = 0.75;
/// Variance that every block is taken to have beside its own, over the mean, when controls are drawn.
constexpr double kLeastChance = 0.1;
/// Of 2, 4, 8, ... and of 3, 6, 12, ... samples; of more than those the last (usualFactor).
constexpr std::array kUsualOfPowers{0.70, 0.66, 0.72, 0.60, 0.63, 0.80, 0.76, 0.82, 0.90};
constexpr std::array kUsualOfThirds{0.68, 0.63, 0.60, 0.61, 0.63, 0.68, 0.77, 0.80};
/// Standard deviation of the scene's factor, beforehand 1, over the scenes of `taut chart plan` at 2 to 512 samples. One control with rare
/// light cannot make it ten.
constexpr double kUsualSpread = 0.25;
constexpr double kGreatestFactor = 2;
/// Standard errors of the noise that are kept in reserve, and the most that is, of the noise.
constexpr double kNoiseMargin = 2;
constexpr double kMostReserve = 0.25;

/// A number of samples n, and n^-p.
struct Step {
    int samples = 0;
    double power = 0;
};

} // namespace

int nextSampleCount(int samples) {
    int power = 1;
    while (2 * power <= samples) power *= 2;
    return samples < power + power / 2 ? power + power / 2 : 2 * power;
}

double usualFactor(int samples) {
    std::size_t power = 0; // of two, the greatest that is no more, above the first
    while (power + 1 < kUsualOfPowers.size() && samples >> (power + 2) != 0) ++power;
    const bool isPower = samples < (3 << power);
    return isPower || power >= kUsualOfThirds.size() ? kUsualOfPowers[power] : kUsualOfThirds[power];
}

double exponentOf(double factor) {
    return std::clamp(std::log2(1 + 1 / std::max(factor, 1e-3)), 1.0, 2.0);
}

PictureNoise::PictureNoise(const Window &window, double level, int first, int most, std::uint32_t seed)
    : grid_(window), level_(level), most_(most), seed_(seed), errors_(grid_.size()),
      targets_(grid_.size(), std::min(std::max(first, 2), most)) {
    for (Index i = 0; i < grid_.size(); ++i) active_.push_back(i);
}

double PictureNoise::weightOf(Index block) const {
    const Window window = grid_.windowOf(block);
    return static_cast<double>(window.width()) * window.height();
}

std::vector<double> PictureNoise::variancesOfOne() const {
    const double p = exponent();
    int samples = 0;
    double power = 0; // of them; many blocks have as many
    std::vector<double> variances;
    variances.reserve(errors_.size());
    for (Index i = 0; i < errors_.size(); ++i) {
        if (errors_[i].samples != samples) {
            samples = errors_[i].samples;
            power = std::pow(samples, p);
        }
        variances.push_back(factor_ * usualOf(i) * power);
    }
    return variances;
}

void PictureNoise::noteSquares(const Film &film) {
    const std::vector<std::array<float, 4>> colours = film.colours();
    const Window &all = film.window();
    for (Index i = 0; i < errors_.size(); ++i) {
        const Window window = grid_.windowOf(i);
        double sum = 0;
        for (int y = window.y0; y < window.y1; ++y)
            for (int x = window.x0; x < window.x1; ++x) {
                const auto &colour = colours[static_cast<std::size_t>(y - all.y0) * static_cast<std::size_t>(all.width()) +
                                             static_cast<std::size_t>(x - all.x0)];
                for (std::size_t channel = 0; channel < 3; ++channel) sum += sqr(static_cast<double>(colour[channel]));
            }
        errors_[i].square = sum / (3 * weightOf(i));
    }
}

/// Sum over pixels of the square of what the picture is without noise.
double PictureNoise::squares() const {
    double sum = 0;
    for (Index i = 0; i < errors_.size(); ++i) sum += weightOf(i) * std::max(0.0, errors_[i].square - factor_ * usualOf(i));
    return sum;
}

double PictureNoise::told() const {
    double sum = 0;
    for (Index i = 0; i < errors_.size(); ++i) sum += weightOf(i) * usualOf(i);
    return sum;
}

double PictureNoise::exponent() const {
    double asIndependent = 0;
    for (Index i = 0; i < errors_.size(); ++i) asIndependent += weightOf(i) * errors_[i].variance;
    return exponentOf(asIndependent > 0 ? factor_ * told() / asIndependent : kUsualOfPowers.front());
}

std::vector<double> PictureNoise::toldAround() const {
    std::vector<double> around(errors_.size());
    for (Index i = 0; i < errors_.size(); ++i) {
        double count = 0;
        for (int dy = -1; dy <= 1; ++dy)
            for (int dx = -1; dx <= 1; ++dx)
                if (const std::optional<Index> other = grid_.beside(i, dx, dy)) {
                    around[i] += usualOf(*other);
                    ++count;
                }
        around[i] /= count;
    }
    return around;
}

/// One of the parts of a block, all equally likely.
Window PictureNoise::partOf(Index block, std::uint32_t random) const {
    const Window window = grid_.windowOf(block);
    const auto across = static_cast<std::uint32_t>((window.width() + kControlSide - 1) / kControlSide);
    const auto down = static_cast<std::uint32_t>((window.height() + kControlSide - 1) / kControlSide);
    const int x = window.x0 + kControlSide * static_cast<int>(random % across);
    const int y = window.y0 + kControlSide * static_cast<int>((random >> 16) % down);
    return {x, y, std::min(x + kControlSide, window.x1), std::min(y + kControlSide, window.y1)};
}

const std::vector<Control> &PictureNoise::drawControls() {
    const double told = this->told();
    if (!controls_.empty() || !(told > 0) || std::sqrt(told / squares()) > kNear * level_) return controls_;
    double pixels = 0;
    for (Index i = 0; i < errors_.size(); ++i) pixels += weightOf(i);
    const std::vector<double> around = toldAround();
    const auto chance = [&](Index i) { return weightOf(i) * std::pow(around[i] + kLeastChance * told / pixels, kChancePower); };
    double all = 0;
    for (Index i = 0; i < errors_.size(); ++i) all += chance(i);
    const auto count = static_cast<std::size_t>(std::min(std::pow(pixels / kPixels, 2.0 / 3), pixels / kPixelsAControl));
    // Systematic: at equal distances along the sum, from one random place.
    const double step = all / static_cast<double>(count);
    double next = step * static_cast<double>(hash(seed_, static_cast<std::uint32_t>(decisions_))) * 0x1p-32;
    double sum = 0;
    for (Index i = 0; i < errors_.size(); ++i) {
        sum += chance(i);
        for (; next < sum && controls_.size() < count; next += step)
            controls_.push_back(
                {i, partOf(i, hash(hash(seed_, i), static_cast<std::uint32_t>(controls_.size()))), chance(i) / weightOf(i)});
    }
    return controls_;
}

/// The factor, and what it says of the picture as it stands.
void PictureNoise::measure(const std::vector<double> &variances) {
    const double told = this->told();
    const std::vector<double> around = toldAround(); // known better than of a block alone, and of the same sum
    double found = 0;
    double halves = 0;
    for (std::size_t k = 0; k < variances.size(); ++k) {
        found += variances[k] / controls_[k].chance;
        halves += around[controls_[k].block] / controls_[k].chance;
    }
    double ofPixels = 0;
    for (Index i = 0; i < errors_.size(); ++i) ofPixels += sqr(weightOf(i) * usualFactor(errors_[i].samples)) * errors_[i].spread;
    const double ofHalves = told > 0 ? ofPixels / sqr(told) : 0; // relative variance of their sum: few pixels may have it all
    // Of the factor: what was measured (Cochran 1977, ratio estimator) and what is usual, each by how well it is known.
    double spread = kUsualSpread;
    factor_ = 1;
    const auto count = static_cast<double>(variances.size());
    if (count > 1 && halves > 0) {
        const double ratio = found / halves;
        double residuals = 0;
        for (std::size_t k = 0; k < variances.size(); ++k)
            residuals += sqr((variances[k] - ratio * around[controls_[k].block]) / controls_[k].chance);
        // Its variance. Pixels that have much of the noise are hardly among the controls, and may have another factor.
        const double measured = std::max(sqr(1e-3 * ratio), residuals * count / (count - 1) / sqr(halves)) + ofHalves * sqr(ratio);
        const double weight = sqr(kUsualSpread) / (sqr(kUsualSpread) + measured);
        factor_ = std::clamp(weight * ratio + 1 - weight, kLeastFactor, kGreatestFactor);
        spread = std::sqrt(weight * measured);
    }
    const double all = squares();
    const double error = all > 0 ? std::sqrt(factor_ * told / all) : 0;
    reached_ = {error, 0.5 * error * std::sqrt(sqr(spread / factor_) + ofHalves), static_cast<int>(count), exponent()};
}

/// The level, less what is not known of the noise: whoever stops when an estimate is low enough stops at one that is too low.
double PictureNoise::aim() const {
    return level_ / (1 + (reached_.error > 0 ? std::min(kMostReserve, kNoiseMargin * reached_.spread / reached_.error) : 0));
}

std::vector<PictureNoise::Guide> PictureNoise::guidesOf(int reach) const {
    const std::vector<double> variances = variancesOfOne();
    Guide all;
    double pixels = 0;
    for (Index i = 0; i < errors_.size(); ++i) {
        all.variance += weightOf(i) * variances[i];
        all.cost += weightOf(i) * errors_[i].cost;
        pixels += weightOf(i);
    }
    all = {all.variance / pixels, all.cost / pixels};
    std::vector<Guide> guides(errors_.size());
    std::vector<double> deviations;
    for (const double variance : variances) deviations.push_back(std::sqrt(variance));
    std::array<std::vector<BlockGrid::Neighbour>, BlockGrid::kColours> around;
    for (int colour = 0; colour < BlockGrid::kColours; ++colour)
        around[static_cast<std::size_t>(colour)] = BlockGrid::followers(colour, reach, kGuideDistance);
    for (Index i = 0; i < errors_.size(); ++i) {
        double deviation = 0;
        double cost = 0;
        double weights = 0;
        for (const auto &[dx, dy] : around[static_cast<std::size_t>(grid_.colourOf(i))]) {
            const std::optional<Index> other = grid_.beside(i, dx, dy);
            if (!other) continue;
            const double weight = kGuideWeights[static_cast<std::size_t>(std::max(std::abs(dx), std::abs(dy)))];
            deviation += weight * deviations[*other];
            cost += weight * errors_[*other].cost;
            weights += weight;
        }
        guides[i] = weights > 0 ? Guide{std::max(sqr(deviation / weights), kLeastShare * all.variance), cost / weights} : all;
    }
    return guides;
}

/// The cheapest numbers of samples with which the picture has so much noise, none below those that there are. Blocks choose by
/// `choosing`, one for all or one for each.
PictureNoise::Allocation PictureNoise::cheapest(const std::vector<Guide> &choosing, double noiseWanted) const {
    const double p = exponent();
    std::vector<Step> steps; // of good numbers of samples
    for (int n = 1; n <= most_; n = nextSampleCount(n)) steps.push_back({n, std::pow(n, -p)});
    struct Start {
        Step step;            ///< that a block has made
        std::size_t next = 0; ///< of the good numbers beyond it
        double least =
            0; ///< cost of a sample, dithered: blocks of one kind go on one after another, in an order that depends on their place alone
        double own = 0; ///< v, over pixels
    };
    const std::vector<double> variances = variancesOfOne();
    std::vector<Start> starts; // [blocks]
    starts.reserve(errors_.size());
    for (Index i = 0; i < errors_.size(); ++i) {
        const int samples = errors_[i].samples;
        const auto next = std::upper_bound(steps.begin(), steps.end(), samples, [](int n, const Step &step) { return n < step.samples; });
        const Guide &guide = choosing.size() == 1 ? choosing.front() : choosing[i];
        const double dither = std::exp2(0.5 * (static_cast<double>(hash(i, 7U)) * 0x1p-32 - 0.5));
        starts.push_back({{samples, std::pow(samples, -p)},
                          static_cast<std::size_t>(next - steps.begin()),
                          dither * std::max(guide.cost, 1.0),
                          weightOf(i) * variances[i]});
    }
    const auto stepOf = [&](Index i, double lambda) {
        const double variance = (choosing.size() == 1 ? choosing.front() : choosing[i]).variance;
        Step step = starts[i].step;
        for (std::size_t k = starts[i].next; k < steps.size(); ++k) {
            if (variance * (step.power - steps[k].power) < lambda * starts[i].least * (steps[k].samples - step.samples)) break;
            step = steps[k];
        }
        return step;
    };
    const auto noise = [&](double lambda) { // sum of variances
        double sum = 0;
        for (Index i = 0; i < errors_.size(); ++i) sum += starts[i].own * stepOf(i, lambda).power;
        return sum;
    };
    const double allowed = sqr(noiseWanted) * squares();
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
        allocation.cost += weightOf(i) * (allocation.samples.back() - errors_[i].samples) * errors_[i].cost;
    }
    return allocation;
}

void PictureNoise::decide(const std::vector<double> &variances) {
    measure(variances);
    active_.clear();
    if (decisions_ >= kReach.size() || reached_.error <= aim()) return;
    const std::size_t decision = decisions_++;
    if (kReach[decision] > 0) guides_ = guidesOf(kReach[decision]);
    Guide all;
    for (const Guide &guide : guides_) {
        all.variance += guide.variance / static_cast<double>(guides_.size());
        all.cost += guide.cost / static_cast<double>(guides_.size());
    }
    const double wantedNoise = decision == 1 && reached_.error > sqr(kAlmost) * aim() ? kAlmost * aim() : aim();
    Allocation wanted = cheapest(guides_, wantedNoise);
    Allocation even = cheapest({all}, wantedNoise);
    if (wanted.cost > (1 - kWorthwhile) * even.cost) wanted = std::move(even);
    for (Index i = 0; i < errors_.size(); ++i) {
        int to = wanted.samples[i];
        if (decision == 0 && to >= 2 * kPartOfTheWay * errors_[i].samples) {
            const double least = errors_[i].samples * std::pow(static_cast<double>(to) / errors_[i].samples, 0.5 * reached_.exponent);
            const double part = std::min(least, static_cast<double>(to) / kPartOfTheWay);
            for (to = errors_[i].samples; nextSampleCount(to) <= part;) to = nextSampleCount(to);
        }
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

} // namespace taut
