#include "taut/scene/environment.h"

#include "taut/base/warp.h"
#include "taut/scene/texture.h"

#include <algorithm>
#include <numeric>

namespace taut {

namespace {

constexpr double kTwoPi = 6.283185307179586;

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

struct Drawn {
    int index;
    float remainder; ///< uniform again in [0, 1)
};

/// The entry that u falls into; entries of weight 0 are never drawn.
Drawn draw(const Environment::TableEntry *entries, const Index *guide, int count, float u) {
    int i = static_cast<int>(guide[std::min(static_cast<int>(u * static_cast<float>(count)), count - 1)]);
    while (i > 0 && entries[i - 1].cumulative > u) --i; // the share that u falls into was rounded up
    while (i + 1 < count && entries[i].cumulative <= u) ++i;
    const float below = i == 0 ? 0 : entries[i - 1].cumulative;
    const float share = entries[i].cumulative - below;
    return {i, share > 0 ? std::clamp((u - below) / share, 0.0F, kOneMinusEpsilon) : 0.5F};
}

const Environment::TableEntry *columnsOfRow(const Environment &e, int row) {
    return e.table.data() + e.height + static_cast<std::ptrdiff_t>(row) * e.width;
}

const Index *guideOfRow(const Environment &e, int row) {
    return e.guide.data() + e.height + static_cast<std::ptrdiff_t>(row) * e.width;
}

/// Map coordinates (u, v) in [0, 1] of a world direction. theta by its tangent, which keeps its digits at the poles.
Vec2 mapCoordinates(const Environment &e, const Vec3 &world) {
    const float u = 0.5F - turnsOf(world.x, world.y) + static_cast<float>(e.rotation) / (2 * kPi);
    return {u - std::floor(u), 2 * turnsOf(world.z, std::sqrt(world.x * world.x + world.y * world.y))};
}

/// Radiance at map coordinates, bilinear between texel centres.
Vec3 bilinear(const Environment &e, const Vec2 &uv) {
    const float x = uv.x * static_cast<float>(e.width) - 0.5F;
    const float y = uv.y * static_cast<float>(e.height) - 0.5F;
    const int column = static_cast<int>(std::floor(x));
    const int row = static_cast<int>(std::floor(y));
    const float fx = x - static_cast<float>(column);
    const float fy = y - static_cast<float>(row);
    const Vec3 upper = glm::mix(texelAt(e, column, row), texelAt(e, column + 1, row), fx);
    const Vec3 lower = glm::mix(texelAt(e, column, row + 1), texelAt(e, column + 1, row + 1), fx);
    return glm::mix(upper, lower, fy);
}

float densityOfTexel(const Environment &e, int column, int row) {
    return e.table[static_cast<std::size_t>(row)].density * columnsOfRow(e, row)[column].density;
}

float densityAt(const Environment &e, const Vec2 &uv) {
    const int column = std::clamp(static_cast<int>(uv.x * static_cast<float>(e.width)), 0, e.width - 1);
    const int row = std::clamp(static_cast<int>(uv.y * static_cast<float>(e.height)), 0, e.height - 1);
    return densityOfTexel(e, column, row);
}

constexpr float kUniformPdf = 0.25F * kInvPi;

} // namespace

Environment constantEnvironment(const Vec3 &radiance) {
    Environment e;
    e.texels[0] = radiance;
    buildSampling(e);
    return e;
}

Environment readEnvironment(const std::string &path, double rotation, const Vec3 &scale) {
    const Texture image = readTexture(path, ColorSpace::Auto);
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
        const bool negative = std::min({rgb.x, rgb.y, rgb.z}) < 0;
        if (!negative && isFinite(e.texels[i])) continue;
        const std::string place = " in column " + std::to_string(i % static_cast<std::size_t>(e.width)) + ", row " +
                                  std::to_string(i / static_cast<std::size_t>(e.width));
        failInput({path, 0, 0, -1}, (negative ? "a negative radiance" : "a radiance that is not finite when scaled") + place,
                  "finite radiance of at least 0");
    }
    buildSampling(e);
    return e;
}

void buildSampling(Environment &e) {
    e.table.clear();
    e.mean = e.texels[0];
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
    for (int row = 0; row < e.height; ++row) {
        DVec3 rowSum(0);
        for (int column = 0; column < e.width; ++column) {
            const Vec3 mean = bilinearMean(e, column, row);
            rowSum += DVec3(mean);
            columns[static_cast<std::size_t>(column)] = std::max(0.0F, luminance(mean));
        }
        sum += rowSum * solidAngleOfTexel(e, row);
        const std::ptrdiff_t first = e.height + static_cast<std::ptrdiff_t>(row) * e.width;
        rows[static_cast<std::size_t>(row)] =
            buildCumulative(columns, e.table.data() + first, e.guide.data() + first) * solidAngleOfTexel(e, row);
    }
    e.mean = Vec3(sum / (2 * kTwoPi));
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

Vec3 radiance(const Environment &e, const Vec3 &w) {
    return e.constant ? e.texels[0] : bilinear(e, mapCoordinates(e, w));
}

float samplePdf(const Environment &e, const Vec3 &w) {
    return e.constant ? kUniformPdf : densityAt(e, mapCoordinates(e, w));
}

EnvironmentLookup lookup(const Environment &e, const Vec3 &w) {
    if (e.constant) return {e.texels[0], kUniformPdf};
    const Vec2 uv = mapCoordinates(e, w);
    return {bilinear(e, uv), densityAt(e, uv)};
}

EnvironmentSample sample(const Environment &e, const Vec2 &u) {
    if (e.constant) {
        const float z = 1 - 2 * u.y;
        return {Vec3(std::sqrt(std::max(0.0F, (1 - z) * (1 + z))) * unitCircle(u.x), z), e.texels[0], kUniformPdf};
    }
    const Drawn row = draw(e.table.data(), e.guide.data(), e.height, u.y);
    const Drawn column = draw(columnsOfRow(e, row.index), guideOfRow(e, row.index), e.width, u.x);
    const double height = glm::mix(e.rowHeight[static_cast<std::size_t>(row.index)], e.rowHeight[static_cast<std::size_t>(row.index) + 1],
                                   static_cast<double>(row.remainder));
    const float r = static_cast<float>(std::sqrt(height * (2 - height)));
    const auto z = static_cast<float>(1 - height);
    const float across = (static_cast<float>(column.index) + column.remainder) / static_cast<float>(e.width);
    const float turns = static_cast<float>(e.rotation) / (2 * kPi) + 0.5F - across;
    const Vec3 direction(r * unitCircle(turns - std::floor(turns)), z);
    return {direction, bilinear(e, {across, 2 * turnsOf(z, r)}), densityOfTexel(e, column.index, row.index)};
}

} // namespace taut
