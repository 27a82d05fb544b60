#pragma once
/// Samplers of directions against their densities: bins in (cos theta, phi) about the surface normal, so that the horizon is an edge,
/// expected counts by adaptive quadrature, chi-squared over all. A last bin holds the samples that are rejected.

#include "running_mean.h"
#include "statistics.h"

#include "taut/microsurface/random_walk.h"

#include <array>

namespace taut::test {

inline constexpr double kPiD = 3.14159265358979323846;

class Uniform {
  public:
    explicit Uniform(std::uint64_t seed) : random_(seed) {}
    float number() { return random_.uniform(); }
    Vec2 pair() {
        const float x = number();
        return {x, number()};
    }

  private:
    walk::Random random_;
};

inline constexpr std::array<double, 3> kNodes{-0.7745966692414834, 0, 0.7745966692414834};
inline constexpr std::array<double, 3> kWeights{5.0 / 18, 8.0 / 18, 5.0 / 18};

/// Integral over z in [z0, z1], phi in [phi0, phi1] by panels of three Gauss points a side.
template <class F> double integrate(const F &f, double z0, double z1, double phi0, double phi1, int panels) {
    double sum = 0;
    const double hz = (z1 - z0) / panels;
    const double hp = (phi1 - phi0) / panels;
    for (int i = 0; i < panels * 3; ++i) {
        const double z = z0 + hz * (i / 3 + 0.5 + 0.5 * kNodes[static_cast<std::size_t>(i % 3)]);
        const double r = std::sqrt(std::max(0.0, 1 - z * z));
        for (int j = 0; j < panels * 3; ++j) {
            const double phi = phi0 + hp * (j / 3 + 0.5 + 0.5 * kNodes[static_cast<std::size_t>(j % 3)]);
            sum += kWeights[static_cast<std::size_t>(i % 3)] * kWeights[static_cast<std::size_t>(j % 3)] *
                   static_cast<double>(f(Vec3(r * std::cos(phi), r * std::sin(phi), z)));
        }
    }
    return sum * hz * hp;
}

/// The integral with panels halved until the three-point rule is sure of each to `error`.
template <class F> double integrateAdaptively(const F &f, double z0, double z1, double phi0, double phi1, double error, int depth) {
    const double whole = integrate(f, z0, z1, phi0, phi1, 1);
    const double halves = integrate(f, z0, z1, phi0, phi1, 2);
    if (depth == 0 || std::fabs(whole - halves) < error) return halves;
    const double z = 0.5 * (z0 + z1);
    const double phi = 0.5 * (phi0 + phi1);
    const auto part = [&](double a, double b, double c, double d) { return integrateAdaptively(f, a, b, c, d, 0.5 * error, depth - 1); };
    return part(z0, z, phi0, phi) + part(z0, z, phi, phi1) + part(z, z1, phi0, phi) + part(z, z1, phi, phi1);
}

/// Integral of f(unit direction in double) over the hemisphere around `axis`: where (M^T m).z > 0, that is m.(M z) > 0, D has its edge.
template <class F> double integrateHemisphere(const F &f, const DVec3 &axis) {
    const DVec3 n = glm::normalize(axis);
    const DVec3 s = glm::normalize(glm::cross(n, std::fabs(n.x) < 0.5 ? DVec3(1, 0, 0) : DVec3(0, 1, 0)));
    const DVec3 t = glm::cross(n, s);
    const auto turned = [&](const Vec3 &w) { return f(glm::normalize(double(w.x) * s + double(w.y) * t + double(w.z) * n)); };
    constexpr int kParts = 40; // fewer would have corners cut off by an edge that no node sees
    double sum = 0;
    for (int i = 0; i < kParts * kParts; ++i) {
        const double z = i / kParts / double(kParts);
        const double phi = 2 * kPiD * (i % kParts) / kParts;
        sum += integrateAdaptively(turned, z, z + 1.0 / kParts, phi, phi + 2 * kPiD / kParts, 1e-8, 10);
    }
    return sum;
}

inline float azimuthOf(const Vec3 &w) {
    const float phi = std::atan2(w.y, w.x);
    return phi < 0 ? phi + 2 * kPi : phi;
}

/// Bin edges at the ends given, at the quantiles of `values` and a little beyond their extremes, where little is left that would be hard
/// to find in a wide bin; equal ones are merged.
inline std::vector<double> quantileEdges(std::vector<double> values, int bins, double low, double high) {
    std::vector<double> edges{low};
    const auto add = [&](double x) {
        if (x > edges.back() + 1e-9 && x < high) edges.push_back(x);
    };
    if (values.size() < 200) { // too few to tell where they are
        for (int i = 1; i < bins; ++i) add(low + (high - low) * i / bins);
    } else {
        std::sort(values.begin(), values.end());
        const double span = values.back() - values.front();
        for (const double beyond : {0.3, 0.06, 0.01}) add(values.front() - beyond * span);
        for (int i = 0; i <= bins; ++i) add(values[(values.size() - 1) * static_cast<std::size_t>(i) / static_cast<std::size_t>(bins)]);
        for (const double beyond : {0.01, 0.06, 0.3}) add(values.back() + beyond * span);
    }
    edges.push_back(high);
    return edges;
}

/// p-value of 1e6 samples of draw() (an optional wi with cosine in [low, high]) against the quadrature of pdf(wi). Edges follow a
/// pilot run. `bend` is an exponent on the azimuth of every sample: 1.02 is a sampler that is wrong by two per cent.
template <class Draw, class Pdf> double chiSquaredOf(const Draw &draw, const Pdf &pdf, double low, double high, double bend = 1) {
    constexpr int kSamples = 1000000;
    constexpr int kPilot = 20000;
    constexpr int kBins = 16;
    std::vector<double> zs;
    std::vector<double> phis;
    for (int i = 0; i < kPilot; ++i)
        if (const auto wi = draw()) {
            zs.push_back(static_cast<double>(wi->z));
            phis.push_back(static_cast<double>(azimuthOf(*wi)));
        }
    const std::vector<double> zEdges = quantileEdges(zs, kBins, low, high);
    const std::vector<double> phiEdges = quantileEdges(phis, kBins, 0, 2 * kPiD);
    const std::size_t nz = zEdges.size() - 1;
    const std::size_t np = phiEdges.size() - 1;
    std::vector<double> observed(nz * np + 1);
    std::vector<double> expected(nz * np + 1);
    const auto binOf = [](const std::vector<double> &edges, double x) {
        const auto after = std::upper_bound(edges.begin() + 1, edges.end() - 1, x);
        return static_cast<std::size_t>(after - edges.begin()) - 1;
    };
    for (int i = 0; i < kSamples; ++i) {
        const auto wi = draw();
        if (!wi) {
            ++observed.back();
            continue;
        }
        double phi = static_cast<double>(azimuthOf(*wi));
        if (bend != 1) phi = 2 * kPiD * std::pow(phi / (2 * kPiD), bend);
        ++observed[binOf(zEdges, static_cast<double>(wi->z)) * np + binOf(phiEdges, phi)];
    }
    double total = 0;
    for (std::size_t i = 0; i < nz; ++i)
        for (std::size_t j = 0; j < np; ++j) {
            double share = 0;
            constexpr int kParts = 12; // a side: at 4, edges of D that a lean tilts were cut short, which a million samples tell
            const double height = (zEdges[i + 1] - zEdges[i]) / kParts;
            const double width = (phiEdges[j + 1] - phiEdges[j]) / kParts;
            for (int part = 0; part < kParts * kParts; ++part) {
                const double z = zEdges[i] + part / kParts * height;
                const double phi = phiEdges[j] + part % kParts * width;
                share += integrateAdaptively(pdf, z, z + height, phi, phi + width, 1e-7, 8);
            }
            total += share;
            expected[i * np + j] = share * kSamples;
        }
    expected.back() = std::max(0.0, 1 - total) * kSamples;
    return chiSquaredP(observed, expected);
}

} // namespace taut::test
