#pragma once
/// A plate under a light, each sample with its own hit: what samplers of reflections come to in a picture. No ray is traced, so a rejected
/// sample saves nothing but its own arithmetic.

#include "study/microsurface/reflection_tally.h"

#include "taut/base/sobol.h"
#include "taut/scene/environment.h"

namespace taut::chart {

/// Radiance one from everywhere: nothing to aim at.
struct FurnaceLight {
    static constexpr bool kSampled = false;
    [[nodiscard]] float radianceFrom(const Vec3 & /*position*/, const Vec3 & /*wi*/) const { return 1; }
};

struct LightSample {
    Vec3 wi;
    float radiance, pdf; ///< pdf in solid angle; 0: nothing
};

/// A small square lamp that the plate reflects towards the eye, seen from both sides.
struct LampLight {
    static constexpr bool kSampled = true;
    Vec3 corner{-0.12F, 1.4F, 1.0F}, u{0.24F, 0, 0}, v{0, 0.1F, 0.22F};

    [[nodiscard]] float radianceFrom(const Vec3 &position, const Vec3 &wi) const { return pdf(position, wi) > 0 ? 10.0F : 0.0F; }
    [[nodiscard]] float pdf(const Vec3 &position, const Vec3 &wi) const {
        const Vec3 n = glm::cross(u, v);
        const float facing = glm::dot(n, wi);
        if (facing == 0) return 0;
        const float distance = glm::dot(n, corner - position) / facing;
        const Vec3 at = position + distance * wi - corner;
        const float x = glm::dot(at, u) / glm::dot(u, u);
        const float y = glm::dot(at, v) / glm::dot(v, v);
        return distance > 0 && x >= 0 && x < 1 && y >= 0 && y < 1 ? distance * distance / std::fabs(facing) : 0.0F;
    }
    [[nodiscard]] LightSample sample(const Vec3 &position, const Vec2 &number) const {
        const Vec3 to = corner + number.x * u + number.y * v - position;
        const float length = glm::length(to);
        const Vec3 wi = to / length;
        return {wi, 10, length * length / std::fabs(glm::dot(glm::cross(u, v), wi))};
    }
};

/// A map of the sky.
struct SkyLight {
    static constexpr bool kSampled = true;
    Environment map = studioEnvironment();

    [[nodiscard]] float radianceFrom(const Vec3 & /*position*/, const Vec3 &wi) const { return lookUpEnvironment(map, wi).radiance.y; }
    [[nodiscard]] float pdf(const Vec3 & /*position*/, const Vec3 &wi) const { return lookUpEnvironment(map, wi).pdf; }
    [[nodiscard]] LightSample sample(const Vec3 & /*position*/, const Vec2 &number) const {
        const EnvironmentSample s = sampleEnvironment(map, number);
        return {s.direction, s.radiance.y, s.pdf};
    }
};

/// What a round over the plate found.
struct PlateRound {
    double mean = 0;     ///< radiance
    double variance = 0; ///< of one sample within its pixel, over the mean square of the pixels
};

/// Width x height pixels of the plate z = 0 seen from above its edge, `spp` samples each from random numbers named by `seed`: one
/// direction of the sampler and, where the light can be aimed at, one of the light's, joined by the power heuristic.
template <class S, class L> PlateRound renderPlate(const MicroTransform &m, const L &light, int spp, std::uint32_t seed) {
    constexpr int kWidth = 32;
    constexpr int kHeight = 18;
    const Vec3 eye(0, -2.0F, 1.1F);
    double sum = 0;
    double spread = 0;
    double squares = 0;
    for (int pixel = 0; pixel < kWidth * kHeight; ++pixel) {
        double pixelSum = 0;
        double pixelSquares = 0;
        for (int i = 0; i < spp; ++i) {
            std::uint32_t state = hash(hash(static_cast<std::uint32_t>(pixel), static_cast<std::uint32_t>(i)), seed);
            const auto number = [&state] { return toUnitFloat(state = hash(state + 0x9e3779b9U)); };
            const float px = (static_cast<float>(pixel % kWidth) + number()) / kWidth;
            const float py = (static_cast<float>(pixel / kWidth) + number()) / kHeight;
            const Vec3 position(1.6F * (px - 0.5F), 1.6F * (py - 0.5F), 0);
            const Vec3 wo = glm::normalize(eye - position);
            const S sampler(m, wo);
            const float length = ggx::stretchedLength(m, wo);
            const Vec2 u(number(), number());
            float value = 0;
            if (const auto wi = sampler.sample(u)) {
                const Reflection r = evaluateReflection(sampler, m, wo, length, *wi);
                if (r.pdf > 0) {
                    float weight = 1;
                    if constexpr (L::kSampled) weight = r.pdf * r.pdf / (r.pdf * r.pdf + sqr(light.pdf(position, *wi)));
                    value += weight * r.fCos / r.pdf * light.radianceFrom(position, *wi);
                }
            }
            if constexpr (L::kSampled) {
                const LightSample s = light.sample(position, {number(), number()});
                if (s.wi.z > 0 && s.pdf > 0) {
                    const Reflection r = evaluateReflection(sampler, m, wo, length, s.wi);
                    value += s.pdf / (s.pdf * s.pdf + r.pdf * r.pdf) * r.fCos * s.radiance;
                }
            }
            pixelSum += static_cast<double>(value);
            pixelSquares += sqr(static_cast<double>(value));
        }
        const double mean = pixelSum / spp;
        sum += mean;
        squares += mean * mean;
        spread += (pixelSquares / spp - mean * mean) * spp / (spp - 1);
    }
    return {sum / (kWidth * kHeight), spread / squares};
}

/// Samples of a round.
inline double plateSamples(int spp) {
    return 32.0 * 18.0 * spp;
}

} // namespace taut::chart
