#include "taut/render/shared_sums.h"

#include "taut/base/error.h"

#include <algorithm>
#include <cmath>
#include <istream>
#include <ostream>

namespace taut {

namespace {

/// Pixels that are read at once: a damaged head asks for no more memory than its file is worth.
constexpr std::size_t kSumBlock = 4096;
constexpr std::size_t kSaved = 9; ///< of kShares: those that are shares
constexpr bool isShare(std::size_t k) {
    return k % 4 < 3;
}

/// A sample that sums don't overflow by, as exact sums are held.
float held(float value) {
    return std::clamp(value, -0x1p63F, 0x1p63F);
}

std::array<float, 4> meanOf(const std::array<float, SharedSums::kValues> &sums) {
    if (!(sums[4] > 0)) return {};
    return {sums[0] / sums[4], sums[1] / sums[4], sums[2] / sums[4], sums[3] / sums[4]};
}

} // namespace

SharedSums::SharedSums(const Window &window) : window_(window) {
    if (!window.empty()) pixels_.resize(static_cast<std::size_t>(window.width()) * static_cast<std::size_t>(window.height()));
}

void SharedSums::add(int x, int y, const SharedSample &sample, const Vec3 &radiance, float alpha) {
    Shares &shares = pixels_[pixelAt(x, y)];
    const std::array<float, kValues> values{held(radiance.x), held(radiance.y), held(radiance.z), alpha, 1};
    std::array<float, kShares> weights{};
    for (std::size_t row = 0; row < 3; ++row)
        for (std::size_t column = 0; column < 3; ++column) weights[4 * row + column] = sample.down[row] * sample.across[column];
    for (std::size_t i = 0; i < kValues; ++i)
        for (std::size_t k = 0; k < kShares; ++k) shares[i][k] += weights[k] * values[i];
}

std::vector<std::array<float, 4>> SharedSums::resolve(std::span<const std::uint32_t> counts) const {
    if (window_.empty()) return {};
    constexpr std::size_t kColumns = 4; // that a row of shares gives to at once
    const auto width = static_cast<std::size_t>(window_.width());
    const auto height = static_cast<std::size_t>(window_.height());
    const std::size_t stride = width + kColumns; // a column before and what a row's fourth, always 0, reaches after
    using Row = std::vector<float>;
    std::vector<std::array<float, 4>> colours(width * height);
    std::array<std::array<Row, kValues>, 3> rows; // of what has been given to y - 1, y and y + 1
    for (auto &row : rows)
        for (Row &sums : row) sums.assign(stride, 0.0F);
    const auto take = [&](std::array<Row, kValues> &row, std::size_t y) { // nothing more is given to it
        for (std::size_t x = 0; x < width; ++x) {
            std::array<float, kValues> sums{};
            for (std::size_t i = 0; i < kValues; ++i) sums[i] = row[i][x + 1];
            colours[y * width + x] = meanOf(sums);
        }
    };
    for (std::size_t y = height; y-- > 0;) {
        for (std::size_t x = width; x-- > 0;) {
            const std::size_t from = y * width + x;
            if (counts[from] == 0) continue;
            const float inverse = 1 / static_cast<float>(counts[from]);
            for (std::size_t down = 0; down < 3; ++down)
                for (std::size_t i = 0; i < kValues; ++i) {
                    const float *shares = &pixels_[from][i][kColumns * down];
                    float *sums = &rows[down][i][x];
                    for (std::size_t k = 0; k < kColumns; ++k) sums[k] += shares[k] * inverse;
                }
        }
        if (y + 1 < height) take(rows[2], y + 1);
        std::rotate(rows.begin(), rows.begin() + 2, rows.end());
        for (Row &sums : rows[0]) std::fill(sums.begin(), sums.end(), 0.0F);
    }
    take(rows[2], 0);
    return colours;
}

void SharedSums::copy(const SharedSums &from, const Window &part) {
    for (int y = part.y0; y < part.y1; ++y)
        std::copy_n(&from.pixels_[from.pixelAt(part.x0, y)], part.width(), &pixels_[pixelAt(part.x0, y)]);
}

void SharedSums::save(std::ostream &out) const {
    std::vector<float> values;
    for (std::size_t first = 0; first < pixels_.size(); first += kSumBlock) {
        values.clear();
        for (std::size_t p = first; p < std::min(first + kSumBlock, pixels_.size()); ++p)
            for (const auto &shares : pixels_[p])
                for (std::size_t k = 0; k < kShares; ++k)
                    if (isShare(k)) values.push_back(shares[k]);
        out.write(reinterpret_cast<const char *>(values.data()), static_cast<std::streamsize>(values.size() * sizeof(float)));
    }
}

SharedSums SharedSums::load(std::istream &in, const Window &window) {
    SharedSums sums;
    sums.window_ = window;
    const std::size_t pixels = window.empty() ? 0 : static_cast<std::size_t>(window.width()) * static_cast<std::size_t>(window.height());
    std::vector<float> values;
    while (sums.pixels_.size() < pixels) {
        const std::size_t count = std::min(kSumBlock, pixels - sums.pixels_.size());
        values.resize(count * kValues * kSaved);
        if (!in.read(reinterpret_cast<char *>(values.data()), static_cast<std::streamsize>(values.size() * sizeof(float))))
            throw InputError("film: found its end early, expected what its pixels share");
        if (!std::all_of(values.begin(), values.end(), [](float value) { return std::isfinite(value); }))
            throw InputError("film: found a share that is not finite, expected numbers");
        auto next = values.begin();
        for (std::size_t p = 0; p < count; ++p)
            for (auto &shares : sums.pixels_.emplace_back())
                for (std::size_t k = 0; k < kShares; ++k)
                    if (isShare(k)) shares[k] = *next++;
    }
    return sums;
}

} // namespace taut
