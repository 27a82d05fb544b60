#pragma once
/// A ball under a sky, as the talk shows it, one bounce by sampling the surface alone: what a sampler, masking or a formulation does to a
/// picture. A Scatter answers `scatter(wo, u, wi)`: the weight f cos / pdf at F = 1 and wi, local; 0 for a rejected sample.

#include "study/chart.h"
#include "study/microsurface/reference.h"
#include "study/microsurface/reflection_tally.h"

#include "taut/base/frame.h"
#include "taut/base/parallel.h"
#include "taut/base/sobol.h"
#include "taut/scene/environment.h"

namespace taut::chart {

/// By a sampler of reflections, height-correlated masking; `masking` false: none, as if every facet were seen and lit.
template <class S> struct SampledBy {
    MicroTransform m;
    bool masking = true;
    float operator()(const Vec3 &wo, const Vec2 &u, Vec3 &wi) const {
        const S sampler(m, wo);
        const auto sampled = sampler.sample(u);
        if (!sampled) return 0;
        wi = *sampled;
        const Reflection r = evaluateReflection(sampler, m, wo, ggx::stretchedLength(m, wo), wi);
        const float fCos = masking ? r.fCos : ggx::distribution(m, wo, wi) / (4 * wo.z);
        return r.pdf > 0 ? fCos / r.pdf : 0.0F;
    }
};

/// Walter et al. 2007 as printed: normals by eq. 35 and 36 (with alphaX, alphaY), D and G1 by eq. 33 and 34, masking G1 G1.
struct WalterBy {
    float alphaX, alphaY;
    float operator()(const Vec3 &wo, const Vec2 &u, Vec3 &wi) const {
        const reference::Walter<float> walter(alphaX, alphaY, 0);
        const float slope = std::sqrt(u.x / (1 - u.x));
        const float phi = 2 * kPi * u.y;
        const Vec3 wm = glm::normalize(Vec3(alphaX * slope * std::cos(phi), alphaY * slope * std::sin(phi), 1));
        const float cosine = glm::dot(wo, wm);
        wi = 2 * cosine * wm - wo;
        if (!(cosine > 0) || !(wi.z > 0)) return 0;
        return walter.G1(wo) * walter.G1(wi) * cosine / (wo.z * wm.z);
    }
};

/// Reflection by M: the disk, M^-T, the masking of M^-1 w, and the talk's Jacobians.
struct TransformBy {
    MicroTransform m;
    float operator()(const Vec3 &wo, const Vec2 &u, Vec3 &wi) const {
        const reference::JacobianChain<float> chain(m);
        const Vec3 wm = glm::normalize(m.inverseTransposed(squareToCosineHemisphere(u)));
        const float cosine = glm::dot(wo, wm);
        wi = 2 * cosine * wm - wo;
        if (!(cosine > 0) || !(wi.z > 0)) return 0;
        const float pdf = chain.normalPdf(wm) * chain.reflectionJacobian(wm, wi);
        return chain.G1(wo) * chain.G1(wi) * chain.D(wm) / (4 * wo.z) / pdf;
    }
};

/// size x size pixels; brushed around the upright axis.
template <class Scatter> Pixels renderBall(const Scatter &scatter, const Environment &sky, int size, int spp, std::uint32_t seed) {
    Pixels pixels(3 * static_cast<std::size_t>(size) * static_cast<std::size_t>(size), 1.0F);
    parallelFor(pixels.size() / 3, 64, [&](std::size_t i) {
        const std::uint32_t name = hash(static_cast<std::uint32_t>(i), seed);
        const Vec2 corner(static_cast<float>(i % static_cast<std::size_t>(size)), static_cast<float>(i / static_cast<std::size_t>(size)));
        DVec3 sum(0);
        for (std::uint32_t k = 0; k < static_cast<std::uint32_t>(spp); ++k) {
            const Vec2 at = (corner + sobol2(k, name)) * (2.1F / static_cast<float>(size)) - 1.05F;
            const float rr = glm::dot(at, at);
            if (rr >= 0.999F) {
                sum += DVec3(0.05);
                continue;
            }
            const Vec3 n(at.x, -std::sqrt(1 - rr), -at.y);
            const Frame frame = frameFromNormalTangent(n, Vec3(-n.y, n.x, 0));
            Vec3 wi;
            const float weight = scatter(frame.toLocal(Vec3(0, -1, 0)), sobol2(k, hash(name, 1)), wi);
            if (weight > 0) sum += static_cast<double>(weight) * DVec3(lookUpEnvironment(sky, frame.fromLocal(wi)).radiance);
        }
        for (int c = 0; c < 3; ++c) pixels[3 * i + static_cast<std::size_t>(c)] = static_cast<float>(sum[c] / spp);
    });
    return pixels;
}

} // namespace taut::chart
