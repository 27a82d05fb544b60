#pragma once
/// What every BSDF is held to: integrals over directions, and its sampler against its density.

#include "direction_bins.h"

#include "taut/base/frame.h"
#include "taut/bsdf/bsdf.h"

#include <random>

namespace taut::test {

/// Integral over the upper (or whole) sphere by the midpoint rule in (z, phi) after z = 1 - s^2, which crowds nodes at the pole.
template <class F> double integrate(const F &f, bool wholeSphere, int n = 700) {
    double sum = 0;
    const double span = wholeSphere ? std::sqrt(2.0) : 1.0;
    for (int i = 0; i < n; ++i) {
        const double s = span * (i + 0.5) / n;
        const double z = 1 - s * s;
        const double r = std::sqrt(std::max(0.0, 1 - z * z));
        for (int j = 0; j < n; ++j) {
            const double phi = 2 * 3.141592653589793 * (j + 0.5) / n;
            sum += 2 * s * static_cast<double>(f(Vec3(r * std::cos(phi), r * std::sin(phi), z)));
        }
    }
    return sum * span / n * 2 * 3.141592653589793 / n;
}

/// Integral over the sphere with nodes crowded at both poles.
template <class F> double integrateSphere(const F &f, int n = 700) {
    return integrate([&](const Vec3 &w) { return f(w) + f(-w); }, false, n);
}

/// Chi-squared of ScatteringPoint::sample against its pdf. `distort` bends the sampler, to see that the test would notice.
inline double chiSquaredOf(const Bsdf &bsdf, const Vec3 &wo, std::uint32_t seed, int samples = 200000, float distort = 1) {
    constexpr int kZ = 24;
    constexpr int kPhi = 32;
    constexpr int kSubZ = 40;
    constexpr int kSub = 24;
    const ScatteringPoint point(bsdf, wo);
    std::vector<double> observed(kZ * kPhi + 1);
    std::vector<double> expected(kZ * kPhi + 1);
    std::mt19937 random(seed);
    std::uniform_real_distribution<float> uniform(0, kOneMinusEpsilon);
    // Bins are uniform on the sphere after turning the mirror direction to the pole, where lobes are narrow.
    const Vec3 axis(-wo.x, -wo.y, std::fabs(wo.z));
    const Frame frame = smoothFrameFromNormal(axis);
    // Bins are equal in t with theta = pi smoothstep(t): crowded at both poles, where mirror and refracted lobes are, and with a
    // boundary at the equator.
    for (int i = 0; i < samples; ++i) {
        const auto s = point.sample({uniform(random), uniform(random)}, uniform(random));
        if (!s) {
            ++observed.back();
            continue;
        }
        const Vec3 local = frame.toLocal(s->wi);
        float azimuth = std::atan2(local.y, local.x);
        azimuth = azimuth < 0 ? azimuth + 2 * kPi : azimuth;
        azimuth = 2 * kPi * std::pow(azimuth / (2 * kPi), distort);
        const double theta = std::acos(std::clamp(static_cast<double>(local.z), -1.0, 1.0)) / 3.141592653589793;
        const double t = 0.5 - std::sin(std::asin(1 - 2 * theta) / 3); // inverse of smoothstep
        const int iz = std::min(kZ - 1, static_cast<int>(t * kZ));
        const int ip = std::min(kPhi - 1, static_cast<int>(azimuth / (2 * kPi) * kPhi));
        ++observed[static_cast<std::size_t>(iz * kPhi + ip)];
    }
    double total = 0;
    for (int iz = 0; iz < kZ; ++iz)
        for (int ip = 0; ip < kPhi; ++ip) {
            double sum = 0;
            for (int a = 0; a < kSubZ; ++a)
                for (int b = 0; b < kSub; ++b) {
                    const double t = (iz + (a + 0.5) / kSubZ) / kZ;
                    const double polar = 3.141592653589793 * t * t * (3 - 2 * t);
                    const double z = std::cos(polar);
                    const double phi = 2 * 3.141592653589793 * (ip + (b + 0.5) / kSub) / kPhi;
                    const double r = std::sin(polar);
                    const Vec3 w = frame.fromLocal(Vec3(r * std::cos(phi), r * std::sin(phi), z));
                    sum += static_cast<double>(point.evaluate(glm::normalize(w)).pdf) * r * 6 * t * (1 - t) * 3.141592653589793;
                }
            sum *= 2 * 3.141592653589793 / (kZ * kPhi * kSubZ * kSub);
            total += sum;
            expected[static_cast<std::size_t>(iz * kPhi + ip)] = sum * samples;
        }
    expected.back() = std::max(0.0, 1 - total) * samples;
    return chiSquaredP(observed, expected);
}

} // namespace taut::test
