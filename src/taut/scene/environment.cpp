#include "taut/scene/environment.h"

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

/// Vose's alias method (1991) for weights of which at least one is positive; entries of weight 0 are never drawn.
void buildAlias(const std::vector<double> &weights, Environment::AliasEntry *out) {
    const std::size_t count = weights.size();
    const double total = std::accumulate(weights.begin(), weights.end(), 0.0);
    std::vector<double> scaled(count);
    std::vector<Index> small;
    std::vector<Index> large;
    for (std::size_t i = 0; i < count; ++i) {
        out[i].density = static_cast<float>(weights[i] / total);
        scaled[i] = weights[i] / total * static_cast<double>(count);
        (scaled[i] < 1 ? small : large).push_back(static_cast<Index>(i));
    }
    while (!small.empty() && !large.empty()) {
        const Index s = small.back();
        const Index l = large.back();
        small.pop_back();
        out[s].threshold = static_cast<float>(scaled[s]);
        out[s].other = l;
        scaled[l] -= 1 - scaled[s];
        if (scaled[l] < 1) {
            large.pop_back();
            small.push_back(l);
        }
    }
    // What rounding left over is 1 up to rounding, unless its weight is zero.
    const Index heaviest = static_cast<Index>(std::max_element(weights.begin(), weights.end()) - weights.begin());
    for (const Index i : large) out[i] = {1, i, out[i].density};
    for (const Index i : small)
        out[i] = weights[i] > 0 ? Environment::AliasEntry{1, i, out[i].density} : Environment::AliasEntry{0, heaviest, 0};
}

struct Drawn {
    int index;
    double remainder; ///< uniform again in [0, 1)
};

Drawn draw(const Environment::AliasEntry *table, int count, float u) {
    const double scaled = static_cast<double>(u) * count;
    const int i = std::clamp(static_cast<int>(scaled), 0, count - 1);
    const double fraction = std::clamp(scaled - i, 0.0, static_cast<double>(kOneMinusEpsilon));
    const double threshold = table[i].threshold;
    if (fraction < threshold) return {i, fraction / threshold};
    return {static_cast<int>(table[i].other), (fraction - threshold) / (1 - threshold)};
}

const Environment::AliasEntry *columnsOfRow(const Environment &e, int row) {
    return e.alias.data() + e.height + static_cast<std::ptrdiff_t>(row) * e.width;
}

/// Map coordinates (u, v) in [0, 1] of a world direction. theta from atan2, which keeps its digits at the poles.
DVec2 mapCoordinates(const Environment &e, const Vec3 &world) {
    const double azimuth = std::atan2(static_cast<double>(world.y), static_cast<double>(world.x)) - e.rotation;
    const double u = 0.5 - azimuth / kTwoPi;
    const double theta = std::atan2(std::hypot(static_cast<double>(world.x), static_cast<double>(world.y)), static_cast<double>(world.z));
    return {u - std::floor(u), theta / (kTwoPi / 2)};
}

float densityOfTexel(const Environment &e, int column, int row) {
    return e.alias[static_cast<std::size_t>(row)].density * columnsOfRow(e, row)[column].density;
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
    e.alias.clear();
    if (e.constant) return;
    const std::size_t width = static_cast<std::size_t>(e.width);
    std::vector<double> rows(static_cast<std::size_t>(e.height));
    std::vector<double> columns(width);
    e.alias.resize(rows.size() * (width + 1));
    for (int row = 0; row < e.height; ++row) {
        for (int column = 0; column < e.width; ++column)
            columns[static_cast<std::size_t>(column)] = std::max(0.0F, luminance(bilinearMean(e, column, row)));
        const double sum = std::accumulate(columns.begin(), columns.end(), 0.0);
        rows[static_cast<std::size_t>(row)] = sum * solidAngleOfTexel(e, row);
        Environment::AliasEntry *out = e.alias.data() + e.height + static_cast<std::ptrdiff_t>(row) * e.width;
        if (sum > 0)
            buildAlias(columns, out);
        else
            std::fill_n(out, e.width, Environment::AliasEntry{1, 0, 0});
    }
    if (std::accumulate(rows.begin(), rows.end(), 0.0) > 0) {
        buildAlias(rows, e.alias.data());
        for (int row = 0; row < e.height; ++row)
            e.alias[static_cast<std::size_t>(row)].density /= static_cast<float>(solidAngleOfTexel(e, row));
    } else { // black: nothing to aim at
        e.width = e.height = 1;
        e.texels.assign(1, Vec3(0));
        e.constant = true;
        e.alias.clear();
    }
}

Vec3 radiance(const Environment &e, const Vec3 &w) {
    if (e.constant) return e.texels[0];
    const DVec2 uv = mapCoordinates(e, w);
    const double x = uv.x * e.width - 0.5;
    const double y = uv.y * e.height - 0.5;
    const int column = static_cast<int>(std::floor(x));
    const int row = static_cast<int>(std::floor(y));
    const float fx = static_cast<float>(x - column);
    const float fy = static_cast<float>(y - row);
    const Vec3 upper = glm::mix(texelAt(e, column, row), texelAt(e, column + 1, row), fx);
    const Vec3 lower = glm::mix(texelAt(e, column, row + 1), texelAt(e, column + 1, row + 1), fx);
    return glm::mix(upper, lower, fy);
}

float samplePdf(const Environment &e, const Vec3 &w) {
    if (e.constant) return kUniformPdf;
    const DVec2 uv = mapCoordinates(e, w);
    const int column = std::clamp(static_cast<int>(uv.x * e.width), 0, e.width - 1);
    const int row = std::clamp(static_cast<int>(uv.y * e.height), 0, e.height - 1);
    return densityOfTexel(e, column, row);
}

EnvironmentSample sample(const Environment &e, const Vec2 &u) {
    const auto directionAt = [](double z, double azimuth) {
        const double r = std::sqrt(std::max(0.0, (1 - z) * (1 + z)));
        return Vec3(static_cast<float>(r * std::cos(azimuth)), static_cast<float>(r * std::sin(azimuth)), static_cast<float>(z));
    };
    if (e.constant) return {directionAt(1 - 2 * static_cast<double>(u.y), kTwoPi * u.x), e.texels[0], kUniformPdf};
    const Drawn row = draw(e.alias.data(), e.height, u.y);
    const Drawn column = draw(columnsOfRow(e, row.index), e.width, u.x);
    const double z = glm::mix(cosAtRow(row.index, e.height), cosAtRow(row.index + 1, e.height), row.remainder);
    const double azimuth = e.rotation + kTwoPi * (0.5 - (column.index + column.remainder) / e.width);
    const Vec3 direction = directionAt(z, azimuth);
    // The density of the direction as rounded, so that it agrees with what samplePdf() says of it; on the far side of a
    // texel's edge that may be zero.
    const float rounded = samplePdf(e, direction);
    return {direction, radiance(e, direction), rounded > 0 ? rounded : densityOfTexel(e, column.index, row.index)};
}

Vec3 meanRadiance(const Environment &e) {
    if (e.constant) return e.texels[0];
    DVec3 sum(0);
    for (int row = 0; row < e.height; ++row) {
        DVec3 rowSum(0);
        for (int column = 0; column < e.width; ++column) rowSum += DVec3(bilinearMean(e, column, row));
        sum += rowSum * solidAngleOfTexel(e, row);
    }
    return Vec3(sum / (2 * kTwoPi));
}

} // namespace taut
