#include "taut/render/adaptive.h"

#include "taut/base/error.h"

#include <algorithm>
#include <cmath>
#include <istream>
#include <ostream>

namespace taut {

namespace {

/// Blocks darker than this share of the mean need not be quieter in absolute terms.
constexpr double kDark = 0.1;

} // namespace

AdaptiveBlocks::AdaptiveBlocks(const Window &window, double noise, int most)
    : grid_(window), level_(noise), most_(most), growth_(std::max(2.0, std::pow(static_cast<double>(most) / kPilot, 1.0 / kDecisions))),
      last_(std::min(most, kPilot)), noise_(grid_.size()) {
    for (Index i = 0; i < noise_.size(); ++i) active_.push_back(i);
}

bool AdaptiveBlocks::isQuiet(Index block) const {
    const auto guideColour = static_cast<std::size_t>((grid_.colourOf(block) + 1) % BlockGrid::kColours);
    bool guided = false;
    for (const std::optional<Index> &next : grid_.nextOnRing(block)) {
        if (!next) continue;
        guided = true;
        const BlockNoise &guide = noise_[*next];
        // What a guide that has stopped would have with as many samples.
        const double variance = guide.variance * guide.samples / last_;
        const double allowed = level_ * std::max(guide.luminance, floor_[guideColour]);
        if (!(variance <= allowed * allowed)) return false;
    }
    return guided;
}

void AdaptiveBlocks::decide() {
    if (decisions_ == 0) {
        std::array<double, BlockGrid::kColours> sums{};
        std::array<double, BlockGrid::kColours> counts{};
        for (Index i = 0; i < noise_.size(); ++i) {
            const auto colour = static_cast<std::size_t>(grid_.colourOf(i));
            sums[colour] += noise_[i].luminance;
            counts[colour] += 1;
        }
        for (std::size_t c = 0; c < BlockGrid::kColours; ++c) floor_[c] = counts[c] > 0 ? kDark * sums[c] / counts[c] : 0;
    }
    first_ = last_;
    if (last_ >= most_) {
        active_.clear();
        return;
    }
    if (decisions_ < kDecisions) {
        std::vector<Index> louder;
        for (const Index block : active_)
            if (!isQuiet(block)) louder.push_back(block);
        active_.swap(louder);
    }
    ++decisions_;
    last_ = decisions_ < kDecisions ? std::min(most_, static_cast<int>(std::lround(first_ * growth_))) : most_;
}

void AdaptiveBlocks::save(std::ostream &out) const {
    const std::array<std::int64_t, 5> numbers{first_, last_, decisions_, static_cast<std::int64_t>(noise_.size()),
                                              static_cast<std::int64_t>(active_.size())};
    out.write(reinterpret_cast<const char *>(numbers.data()), sizeof numbers);
    out.write(reinterpret_cast<const char *>(floor_.data()), sizeof floor_);
    for (const BlockNoise &noise : noise_) {
        const std::array<double, 3> values{noise.variance, noise.luminance, static_cast<double>(noise.samples)};
        out.write(reinterpret_cast<const char *>(values.data()), sizeof values);
    }
    out.write(reinterpret_cast<const char *>(active_.data()), static_cast<std::streamsize>(active_.size() * sizeof(Index)));
}

void AdaptiveBlocks::load(std::istream &in) {
    std::array<std::int64_t, 5> numbers{};
    const auto read = [&](void *to, std::size_t bytes) {
        if (!in.read(static_cast<char *>(to), static_cast<std::streamsize>(bytes)))
            throw InputError("saved frame: found its end early, expected the noise of its blocks");
    };
    read(numbers.data(), sizeof numbers);
    const auto [first, last, decisions, blocks, active] = numbers;
    if (blocks != static_cast<std::int64_t>(noise_.size()) || active < 0 || active > blocks || first < 0 || first > last || last > most_ ||
        decisions < 0 || decisions > kDecisions)
        throw InputError("saved frame: found blocks of another frame, expected those of this one");
    read(floor_.data(), sizeof floor_);
    for (BlockNoise &noise : noise_) {
        std::array<double, 3> values{};
        read(values.data(), sizeof values);
        const bool isNoise = std::isfinite(values[0]) && std::isfinite(values[1]) && values[2] >= 0 && values[2] <= most_;
        if (!isNoise) throw InputError("saved frame: found a block's noise that is none, expected finite numbers");
        noise = {values[0], values[1], static_cast<int>(values[2])};
    }
    active_.resize(static_cast<std::size_t>(active));
    read(active_.data(), active_.size() * sizeof(Index));
    for (const Index block : active_)
        if (block >= noise_.size()) throw InputError("saved frame: found a block that is none, expected one of its window");
    first_ = static_cast<int>(first);
    last_ = static_cast<int>(last);
    decisions_ = static_cast<int>(decisions);
}

double AdaptiveBlocks::done() const {
    const double share = static_cast<double>(active_.size()) / static_cast<double>(noise_.size());
    return 1 - share * (1 - static_cast<double>(first_) / most_);
}

void BlockScratch::fill(const Film &film, const Window &block, std::vector<double> &sums) {
    sums.clear();
    for (int y = block.y0; y < block.y1; ++y)
        for (int x = block.x0; x < block.x1; ++x) sums.push_back(film.luminanceSum(x, y));
}

BlockNoise noiseOf(const std::vector<double> &sumsBefore, int before, const std::vector<double> &sumsAfter, int after) {
    BlockNoise noise;
    noise.samples = after;
    const double added = after - before;
    for (std::size_t i = 0; i < sumsAfter.size(); ++i) {
        const double difference = sumsBefore[i] / before - (sumsAfter[i] - sumsBefore[i]) / added;
        noise.variance += difference * difference;
        noise.luminance += sumsAfter[i] / after;
    }
    const auto pixels = static_cast<double>(sumsAfter.size());
    noise.variance *= before * added / (static_cast<double>(after) * after * pixels);
    noise.luminance /= pixels;
    return noise;
}

} // namespace taut
