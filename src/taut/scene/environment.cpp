#include "taut/scene/environment.h"

#include "taut/scene/texture.h"

#include <algorithm>
#include <numeric>
#include <optional>

namespace taut {

namespace {

/// cos(theta) at the upper edge of row `row` of `height`.
double cosAtRow(int row, int height) {
    return std::cos(kTwoPi / 2 * row / height);
}

double solidAngleOfTexel(const Environment &e, int row) {
    return (cosAtRow(row, e.height) - cosAtRow(row + 1, e.height)) * kTwoPi / e.width;
}

/// Texel of a column that wraps and a row that is clamped at the poles.
const Vec3 &texelAt(const Environment &e, int column, int row) {
    const int x = column < 0 ? column + e.width : column >= e.width ? column - e.width : column;
    const int y = std::clamp(row, 0, e.height - 1);
    return e.texels[static_cast<std::size_t>(y) * static_cast<std::size_t>(e.width) + static_cast<std::size_t>(x)];
}

/// Mean of the bilinear radiance over a texel's (u, v) square: each axis mixes 1/8, 3/4, 1/8. Positive wherever the bilinear
/// radiance is positive anywhere in the texel.
Vec3 bilinearMean(const Environment &e, int column, int row) {
    constexpr float kWeights[3] = {0.125F, 0.75F, 0.125F};
    Vec3 sum(0);
    for (int dy = -1; dy <= 1; ++dy)
        for (int dx = -1; dx <= 1; ++dx) sum += kWeights[dx + 1] * kWeights[dy + 1] * texelAt(e, column + dx, row + dy);
    return sum;
}

/// Cumulative sums and probabilities of weights, and the guide to them; returns their total. All zero where the total is.
double buildCumulative(const std::vector<double> &weights, Environment::TableEntry *out, Index *guide) {
    const double total = std::accumulate(weights.begin(), weights.end(), 0.0);
    const std::size_t count = weights.size();
    double sum = 0;
    float below = 0;
    for (std::size_t i = 0; i < count; ++i) {
        sum += weights[i];
        out[i].cumulative = total > 0 ? std::min(1.0F, static_cast<float>(sum / total)) : 0;
        out[i].density = out[i].cumulative - below; // as numbers are drawn; what is rounded away is left to scattered rays
        below = out[i].cumulative;
    }
    if (total > 0) { // the last with any weight ends at 1
        std::size_t last = count - 1;
        while (weights[last] == 0) --last;
        out[last].density += 1 - out[last].cumulative;
        for (std::size_t i = last; i < count; ++i) out[i].cumulative = 1;
    }
    Index entry = 0;
    for (std::size_t i = 0; i < count; ++i) {
        while (entry + 1 < count && out[entry].cumulative <= static_cast<float>(i) / static_cast<float>(count)) ++entry;
        guide[i] = entry;
    }
    return total;
}

} // namespace

Environment constantEnvironment(const Vec3 &radiance) {
    Environment e;
    e.texels[0] = radiance;
    buildSampling(e);
    return e;
}

Environment readEnvironment(const std::string &path, double rotation, const Vec3 &scale, Warnings &warnings, Budget *budget) {
    std::optional<Budget> own;
    Budget &account = budget != nullptr ? *budget : own.emplace();
    const Texture image = readRadiance(path, warnings, &account);
    constexpr double kTables = sizeof(Vec3) + sizeof(Environment::TableEntry) + sizeof(Index);
    account.take(kTables * (static_cast<double>(image.width) + 1) * image.height, path, "a map of radiance");
    Environment e;
    e.width = image.width;
    e.height = image.height;
    e.rotation = rotation;
    e.constant = false;
    e.texels.resize(static_cast<std::size_t>(e.width) * static_cast<std::size_t>(e.height));
    const std::size_t channels = static_cast<std::size_t>(image.channels);
    for (std::size_t i = 0; i < e.texels.size(); ++i) {
        const float *t = &image.texels[i * channels];
        const Vec3 rgb = channels == 1 ? Vec3(t[0]) : Vec3(t[0], t[1], t[2]);
        e.texels[i] = rgb * scale;
        if (isFinite(e.texels[i])) continue;
        const std::string place = " in column " + std::to_string(i % static_cast<std::size_t>(e.width)) + ", row " +
                                  std::to_string(i / static_cast<std::size_t>(e.width));
        failInput({path, 0, 0, -1}, "a radiance that is not finite when scaled" + place, "finite radiance");
    }
    buildSampling(e);
    return e;
}

void buildSampling(Environment &e) {
    e.table.clear();
    e.mean = e.texels[0];
    e.coverage = 1;
    if (e.constant) return;
    const std::size_t width = static_cast<std::size_t>(e.width);
    std::vector<double> rows(static_cast<std::size_t>(e.height));
    std::vector<double> columns(width);
    e.table.resize(rows.size() * (width + 1));
    e.guide.resize(e.table.size());
    e.rowHeight.resize(rows.size() + 1);
    for (std::size_t row = 0; row <= rows.size(); ++row) // 1 - cos, without cancellation
        e.rowHeight[row] = 2 * sqr(std::sin(kTwoPi / 4 * static_cast<double>(row) / static_cast<double>(rows.size())));
    DVec3 sum(0);
    double squares = 0; // of luminances
    for (int row = 0; row < e.height; ++row) {
        DVec3 rowSum(0);
        double rowSquares = 0;
        for (int column = 0; column < e.width; ++column) {
            const Vec3 mean = bilinearMean(e, column, row);
            rowSum += DVec3(mean);
            columns[static_cast<std::size_t>(column)] = std::max(0.0F, luminance(mean));
            rowSquares += sqr(columns[static_cast<std::size_t>(column)]);
        }
        sum += rowSum * solidAngleOfTexel(e, row);
        squares += rowSquares * solidAngleOfTexel(e, row);
        const std::ptrdiff_t first = e.height + static_cast<std::ptrdiff_t>(row) * e.width;
        rows[static_cast<std::size_t>(row)] =
            buildCumulative(columns, e.table.data() + first, e.guide.data() + first) * solidAngleOfTexel(e, row);
    }
    e.mean = Vec3(sum / (2 * kTwoPi));
    if (squares > 0)
        e.coverage = static_cast<float>(std::min(1.0, sqr(static_cast<double>(luminance(Vec3(sum)))) / (squares * 2 * kTwoPi)));
    if (buildCumulative(rows, e.table.data(), e.guide.data()) > 0) {
        for (int row = 0; row < e.height; ++row)
            e.table[static_cast<std::size_t>(row)].density /= static_cast<float>(solidAngleOfTexel(e, row));
    } else { // black: nothing to aim at
        e.width = e.height = 1;
        e.texels.assign(1, Vec3(0));
        e.mean = Vec3(0);
        e.constant = true;
        e.table.clear();
        e.guide.clear();
        e.rowHeight.clear();
    }
}

} // namespace taut
