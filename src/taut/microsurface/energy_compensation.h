#pragma once
/// What single scattering on the transformed GGX microsurface loses, for every upright M, and a reciprocal lobe that gives it back
/// (the form of Kulla & Conty 2017 with the albedo of the transformed surface in it instead of an isotropic one).
///
/// The albedo E(w; M) of the height-correlated lobe (F = 1) is a function of four numbers: the direction's elevation and the slope
/// tensor Sigma = (M M^T)^-1 in the direction's own azimuth, standard deviations along and across it and their squared correlation.
/// Written as E = 1 / (1 + y^2) and y = s / (1 - s), s is smooth in
///     elevation    sqrt(c) / (sqrt(c) + sqrt(1 - c)),  c the standard cosine w.z / |M^-1 w|
///     along, across  alpha / (1 + alpha) of the roughness in the plane of the direction and across it
///     correlation  rho^2
/// and a low-degree Chebyshev product (energy_table.h, fitted by taut_tables) is within 0.012 of quadrature, 0.002 typically, for alpha
/// in [0.02, 2] and aspects to 1:20. M outside alpha <= 10 is taken as if at that end. A lean is ignored: walk those
/// (random_walk.h).

#include "taut/microsurface/energy_table.h"
#include "taut/microsurface/ggx.h"

#include <array>

namespace taut::energy {

/// Greatest alpha in the fit.
inline constexpr float kGreatestAlpha = 10;

/// Where E is looked up; all in [0, 1].
struct Coordinates {
    float elevation, along, across, correlation;
};

/// alpha / (1 + alpha), scaled so that the fit's range is [0, 1].
inline float roughnessCoordinate(float alpha) {
    const float a = alpha < kGreatestAlpha ? alpha : kGreatestAlpha;
    return a / (1 + a) * ((1 + kGreatestAlpha) / kGreatestAlpha);
}

/// For a direction above the horizon. No branches: loops are vectorised.
[[gnu::always_inline]] inline Coordinates coordinates(const MicroTransform &m, const Vec3 &w) {
    const float horizontal = std::sqrt(w.x * w.x + w.y * w.y);
    const bool slanted = horizontal > 0;
    const float divisor = slanted ? horizontal : 1.0F;
    const Vec2 azimuth(slanted ? w.x / divisor : 1.0F, slanted ? w.y / divisor : 0.0F);
    const auto standard = [&](const Vec2 &v) {
        const float y = v.y * m.inverseD;
        return Vec2((v.x - m.b * y) * m.inverseA, y);
    };
    const Vec2 along = standard(azimuth);
    const Vec2 across = standard({-azimuth.y, azimuth.x});
    const float varianceAlong = glm::dot(along, along);
    const float varianceAcross = glm::dot(across, across);
    const float covariance = glm::dot(along, across);
    const float xy2 = varianceAlong * horizontal * horizontal;
    const float length = std::sqrt(xy2 + w.z * w.z);
    const float up = std::sqrt(w.z * (length + w.z)); // sqrt(c) : sqrt(1 - c) without cancellation
    const float down = std::sqrt(xy2);
    const float correlation = covariance * covariance / (varianceAlong * varianceAcross);
    return {up / (up + down), roughnessCoordinate(std::sqrt(varianceAlong)), roughnessCoordinate(std::sqrt(varianceAcross)),
            correlation < 1 ? correlation : 1.0F};
}

/// Chebyshev polynomials T_0 .. T_(N-1) of 2 u - 1.
template <std::size_t N> std::array<float, N> chebyshev(float u) {
    std::array<float, N> t{};
    const float x = 2 * u - 1;
    t[0] = 1;
    t[1] = x;
    for (std::size_t i = 2; i < N; ++i) t[i] = 2 * x * t[i - 1] - t[i - 2];
    return t;
}

/// s -> E.
[[gnu::always_inline]] inline float albedoFromFit(float s) {
    const float limited = glm::clamp(s, 0.0F, 0.999F);
    const float y = limited / (1 - limited);
    return 1 / (1 + y * y);
}

/// Coordinates of several directions, an array each.
template <std::size_t kCount> struct CoordinateLanes {
    float elevation[kCount], along[kCount], across[kCount], correlation[kCount];
    [[gnu::always_inline]] void set(std::size_t i, const Coordinates &c) {
        elevation[i] = c.elevation;
        along[i] = c.along;
        across[i] = c.across;
        correlation[i] = c.correlation;
    }
};

/// Directional albedo of single scattering, F = 1, for kCount directions: the same sums for each, in the same order, whatever kCount is.
template <std::size_t kCount>
[[gnu::always_inline]] inline void singleScatterAlbedos(const CoordinateLanes<kCount> &at, float *albedo, const float *coefficients) {
    constexpr std::size_t kInner = 2 * table::kAcross;
    float elevation[table::kElevation][kCount];
    float along[table::kAlong][kCount];
    float across[table::kAcross][kCount];
    for (std::size_t i = 0; i < kCount; ++i) {
        const auto e = chebyshev<table::kElevation>(at.elevation[i]);
        const auto a = chebyshev<table::kAlong>(at.along[i]);
        const auto b = chebyshev<table::kAcross>(at.across[i]);
        for (std::size_t k = 0; k < e.size(); ++k) elevation[k][i] = e[k];
        for (std::size_t k = 0; k < a.size(); ++k) along[k][i] = a[k];
        for (std::size_t k = 0; k < b.size(); ++k) across[k][i] = b[k];
    }
    // Innermost over what lies side by side, coefficients or directions, which compilers turn into vector arithmetic.
    float inner[kInner][kCount] = {};
    const float *c = coefficients;
    for (const auto &e : elevation)
        for (const auto &a : along) {
            float weight[kCount];
            for (std::size_t i = 0; i < kCount; ++i) weight[i] = e[i] * a[i];
            for (std::size_t k = 0; k < kInner; ++k)
                for (std::size_t i = 0; i < kCount; ++i) inner[k][i] += weight[i] * c[k];
            c += kInner;
        }
    float sum[kCount] = {};
    for (std::size_t k = 0; k < table::kAcross; ++k)
        for (std::size_t i = 0; i < kCount; ++i) {
            const float x = 2 * at.correlation[i] - 1;
            sum[i] += across[k][i] * (inner[k][i] + x * inner[table::kAcross + k][i]);
        }
    for (std::size_t i = 0; i < kCount; ++i) albedo[i] = albedoFromFit(sum[i]);
}

/// Of one direction, w.z > 0.
inline float singleScatterAlbedo(const MicroTransform &m, const Vec3 &w, const float *coefficients = table::kAlbedo.data()) {
    CoordinateLanes<1> at;
    at.set(0, coordinates(m, w));
    float albedo = 0;
    singleScatterAlbedos<1>(at, &albedo, coefficients);
    return albedo;
}

/// Cosine-weighted hemispherical mean of the above: the share of diffuse light that leaves after one bounce. Fitted to the mean of
/// the fit, so that the compensating lobe returns all that the fit finds lost.
inline float averageAlbedo(const MicroTransform &m) {
    const Vec2 sigma = singularValues(m);
    const float rougher = roughnessCoordinate(1 / sigma.y);
    const float smoother = roughnessCoordinate(1 / sigma.x);
    const auto x = chebyshev<table::kAverageDegree>(rougher);
    const auto y = chebyshev<table::kAverageDegree>(smoother);
    float sum = 0;
    for (std::size_t i = 0; i < x.size(); ++i)
        for (std::size_t j = 0; j < y.size(); ++j) sum += table::kAverage[i * y.size() + j] * x[i] * y[j];
    return albedoFromFit(sum);
}

/// Colour of all light of two and more bounces where a facet reflects `f` on average: with a share e of it leaving at every facet
/// the series f^2 e (1 + f (1 - e) + ...). Light leaves the sooner the higher it has come: e = averageAlbedo^(3/4) follows the walk
/// where averageAlbedo itself is too dark (by 15 % at alpha = 2, f = 0.8).
inline Vec3 multipleColor(const Vec3 &f, float averageAlbedo) {
    const float e = std::sqrt(averageAlbedo * std::sqrt(averageAlbedo));
    return f * f * e / (Vec3(1) - f * (1 - e));
}

/// The lobe of two and more bounces at F = 1 from the losses 1 - E of both directions and their mean: f cos.
[[gnu::always_inline]] inline float multipleLobe(float lossO, float lossI, float lossMean, float wiZ) {
    return lossMean > 1e-6F ? lossO * lossI / lossMean * (kInvPi * wiZ) : 0.0F;
}

} // namespace taut::energy
