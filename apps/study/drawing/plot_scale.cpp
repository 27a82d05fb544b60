#include "study/drawing/plot_scale.h"

#include "study/text.h"

#include <algorithm>
#include <cmath>

namespace taut::chart {

namespace {

using Tics = std::vector<std::pair<std::string, double>>;

std::string shortNumber(double value) {
    return digits(value, 6);
}

/// Whether a power of ten is written out.
bool isPlain(int exponent) {
    return exponent >= -2 && exponent <= 4;
}

/// Multiples of 1, 2 or 5 times a power of ten, about five of them.
Tics linearTics(double low, double high) {
    const double rough = (high - low) / 5;
    const double power = std::pow(10.0, std::floor(std::log10(rough)));
    const double step = power * (rough < 1.5 * power ? 1 : rough < 3.5 * power ? 2 : rough < 7.5 * power ? 5 : 10);
    Tics tics;
    for (double k = std::ceil(low / step); k * step <= high; ++k) {
        const double at = k == 0 ? 0 : k * step; // not -0
        tics.emplace_back(shortNumber(at), at);
    }
    return tics;
}

Tics logarithmicTics(double low, double high) {
    const double decades = std::log10(high / low);
    if (decades < 0.8) return linearTics(low, high);
    Tics tics;
    const int first = static_cast<int>(std::floor(std::log10(low)));
    const int last = static_cast<int>(std::ceil(std::log10(high)));
    const int step = std::max(1, static_cast<int>(std::ceil(decades / 8)));
    for (int exponent = first; exponent <= last; ++exponent) {
        const double power = std::pow(10.0, exponent);
        const auto add = [&](double value, const std::string &text) {
            if (value >= low * 0.999 && value <= high * 1.001) tics.emplace_back(text, value);
        };
        if (exponent % step == 0) add(power, powerOfTen(exponent));
        if (decades > 2.2) continue;
        for (const int factor : {2, 5})
            add(factor * power, isPlain(exponent) ? shortNumber(factor * power) : std::to_string(factor) + "·" + powerOfTen(exponent));
    }
    return tics;
}

} // namespace

std::string powerOfTen(int exponent) {
    if (isPlain(exponent)) return shortNumber(std::pow(10.0, exponent));
    static constexpr const char *kDigits[] = {"⁰", "¹", "²", "³", "⁴", "⁵", "⁶", "⁷", "⁸", "⁹"};
    std::string text = exponent < 0 ? "10⁻" : "10";
    for (const char c : std::to_string(std::abs(exponent))) text += kDigits[c - '0'];
    return text;
}

PlotScale::PlotScale(const Axis &axis, const std::vector<Measured> &values) : logarithmic_(axis.logarithmic) {
    double low = INFINITY;
    double high = -INFINITY;
    bool zeros = false;
    bool infinities = false;
    for (const Measured &m : values) {
        if (!std::isfinite(m.value)) {
            infinities = true;
        } else if (logarithmic_ && m.value <= 0) {
            zeros = true;
        } else {
            const double below = m.value - m.spread;
            low = std::min(low, logarithmic_ ? std::max(below, m.value / 2) : below);
            high = std::max(high, m.value + m.spread);
        }
    }
    if (low > high) low = high = 1;
    if (logarithmic_) {
        const double room = std::max(1.2, std::pow(high / low, 0.08));
        low_ = zeroAt_ = low / room;
        high_ = infiniteAt_ = high * room;
        tics_ = logarithmicTics(low_, high_);
        if (zeros) {
            low_ = zeroAt_ / (room * room);
            zeroAt_ /= std::sqrt(room);
            std::erase_if(tics_, [&](const auto &tic) { return tic.second < zeroAt_ * std::pow(room, 0.8); });
            tics_.emplace_back("0", zeroAt_);
        }
        if (infinities) {
            high_ = infiniteAt_ * room * room;
            infiniteAt_ *= std::sqrt(room);
            std::erase_if(tics_, [&](const auto &tic) { return tic.second > infiniteAt_ / std::pow(room, 0.8); });
        }
    } else {
        const double room = std::max((high - low) * 0.08, 1e-3 * std::fabs(high) + 1e-30);
        low_ = zeroAt_ = low > 0 && low < 0.4 * high ? 0 : low - room; // a mark at 0 keeps clear of the other axis
        high_ = infiniteAt_ = high + room;
        tics_ = linearTics(low_, high_);
        if (infinities) high_ += 2 * room;
    }
    if (infinities) tics_.emplace_back("∞", infiniteAt_);
}

double PlotScale::place(double value) const {
    if (!std::isfinite(value)) return infiniteAt_;
    if (logarithmic_ && value <= 0) return zeroAt_;
    return std::clamp(value, low_, high_);
}

double PlotScale::share(double value) const {
    const double at = place(value);
    return logarithmic_ ? std::log(at / low_) / std::log(high_ / low_) : (at - low_) / (high_ - low_);
}

} // namespace taut::chart
