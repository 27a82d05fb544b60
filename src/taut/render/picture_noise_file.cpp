/// What has been decided about a picture's samples, saved and loaded.

#include "taut/base/error.h"
#include "taut/render/picture_noise.h"

#include <cmath>
#include <istream>
#include <ostream>

namespace taut {

void PictureNoise::save(std::ostream &out) const {
    const auto write = [&](const auto &values) { out.write(reinterpret_cast<const char *>(values.data()), sizeof values); };
    write(std::array<std::int64_t, 5>{static_cast<std::int64_t>(decisions_), static_cast<std::int64_t>(errors_.size()),
                                      static_cast<std::int64_t>(active_.size()), static_cast<std::int64_t>(guides_.size()),
                                      static_cast<std::int64_t>(controls_.size())});
    write(std::array<double, 5>{factor_, reached_.error, reached_.spread, static_cast<double>(reached_.controls), reached_.exponent});
    for (Index i = 0; i < errors_.size(); ++i) {
        const BlockError &e = errors_[i];
        write(std::array<double, 6>{static_cast<double>(e.samples), e.variance, e.spread, e.square, e.cost,
                                    static_cast<double>(targets_[i])});
    }
    for (const Guide &guide : guides_) write(std::array<double, 2>{guide.variance, guide.cost});
    for (const Control &control : controls_) {
        const Window &w = control.window;
        write(std::array<double, 6>{static_cast<double>(control.block), static_cast<double>(w.x0), static_cast<double>(w.y0),
                                    static_cast<double>(w.x1), static_cast<double>(w.y1), control.chance});
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
            if (!std::isfinite(value) || value < 0)
                throw InputError("saved frame: found a block's noise that is none, expected finite numbers");
    };
    std::array<std::int64_t, 5> numbers{};
    read(numbers.data(), sizeof numbers);
    const auto [decisions, blocks, active, guides, controls] = numbers;
    if (blocks != static_cast<std::int64_t>(errors_.size()) || active < 0 || active > blocks || decisions < 0 ||
        decisions > static_cast<std::int64_t>(kReach.size()) || (guides != 0 && guides != blocks) || (decisions > 0 && guides == 0) ||
        controls < 0 || controls > blocks)
        throw InputError("saved frame: found blocks of another frame, expected those of this one");
    std::array<double, 5> whole{};
    readNumbers(whole);
    factor_ = std::max(whole[0], kLeastFactor);
    reached_ = {whole[1], whole[2], static_cast<int>(std::min(whole[3], 1e9)), whole[4]};
    for (Index i = 0; i < errors_.size(); ++i) {
        std::array<double, 6> values{};
        readNumbers(values);
        if (!(values[0] <= values[5] && values[5] <= most_))
            throw InputError("saved frame: found a block's samples that are none, expected at most " + std::to_string(most_));
        errors_[i] = {static_cast<int>(values[0]), values[1], values[2], values[3], values[4]};
        targets_[i] = static_cast<int>(values[5]);
    }
    guides_.clear();
    for (std::int64_t i = 0; i < guides; ++i) {
        std::array<double, 2> values{};
        readNumbers(values);
        guides_.push_back({values[0], values[1]});
    }
    controls_.clear();
    for (std::int64_t i = 0; i < controls; ++i) {
        std::array<double, 6> values{};
        readNumbers(values);
        const bool isBlock = values[0] < static_cast<double>(errors_.size());
        const Window block = isBlock ? grid_.windowOf(static_cast<Index>(values[0])) : Window{};
        const auto within = [&](double value, int from, int to) { return value >= from && value <= to; };
        if (!within(values[1], block.x0, block.x1) || !within(values[3], block.x0, block.x1) || !within(values[2], block.y0, block.y1) ||
            !within(values[4], block.y0, block.y1) || !(values[1] < values[3]) || !(values[2] < values[4]) || !(values[5] > 0))
            throw InputError("saved frame: found a control that is none, expected a part of a block");
        const Window part{static_cast<int>(values[1]), static_cast<int>(values[2]), static_cast<int>(values[3]),
                          static_cast<int>(values[4])};
        controls_.push_back({static_cast<Index>(values[0]), part, values[5]});
    }
    active_.resize(static_cast<std::size_t>(active));
    read(active_.data(), active_.size() * sizeof(Index));
    for (const Index block : active_)
        if (block >= errors_.size()) throw InputError("saved frame: found a block that is none, expected one of its window");
    decisions_ = static_cast<std::size_t>(decisions);
}

} // namespace taut
