#pragma once
/// Fibres on a surface, as KHR_materials_sheen defines them: Estevez & Kulla 2017, "Production Friendly Microfacet Sheen BRDF". Charlie's
/// distribution D = (2 + 1/alpha) sin^(1/alpha) / 2 pi with its fitted shadowing, and the albedo by which what lies below is scaled.

#include "taut/base/vec.h"

#include <algorithm>
#include <array>

namespace taut::sheen {

/// Below it the distribution is one of the horizon alone, which floats do not resolve.
inline constexpr float kLeastAlpha = 0.005F;

/// alpha = roughness^2.
inline float alphaOf(float roughness) {
    return std::max(roughness * roughness, kLeastAlpha);
}

/// Eq. 4 of the paper: ln of the shadowing's lambda below 60 degrees, a fit in alpha.
inline float fitted(float x, float alpha) {
    const float u = sqr(1 - alpha);
    const float a = glm::mix(21.5473F, 25.3245F, u);
    const float b = glm::mix(3.82987F, 3.32435F, u);
    const float c = glm::mix(0.19823F, 0.16801F, u);
    const float d = glm::mix(-1.97760F, -1.27393F, u);
    const float e = glm::mix(-4.32054F, -4.85967F, u);
    return a / (1 + b * std::pow(x, c)) + d * x + e;
}
inline float lambda(float cosine, float alpha) {
    return std::exp(cosine < 0.5F ? fitted(cosine, alpha) : 2 * fitted(0.5F, alpha) - fitted(1 - cosine, alpha));
}

/// D V cos: the lobe of white fibres times the cosine of wi; both above the horizon. `cosH` of the half vector.
inline float lobe(float cosO, float cosI, float cosH, float alpha) {
    const float sine2 = std::max(1 - cosH * cosH, 0.0F);
    const float density = (2 + 1 / alpha) * std::pow(sine2, 0.5F / alpha) * (0.5F * kInvPi);
    return density / ((1 + lambda(cosO, alpha) + lambda(cosI, alpha)) * 4 * std::max(cosO, 1e-4F));
}

/// Albedo of white fibres by quadrature, [alpha][cosine].
class AlbedoTable {
  public:
    static constexpr int kAlphas = 24, kCosines = 32;

    AlbedoTable() {
        for (int a = 0; a < kAlphas; ++a)
            for (int c = 0; c < kCosines; ++c) values_[static_cast<std::size_t>(a * kCosines + c)] = integral(cosineAt(c), alphaAt(a));
    }
    /// Bilinear; cosine above 0.
    [[nodiscard]] float operator()(float cosine, float alpha) const {
        const float x = std::sqrt(glm::clamp(cosine, 0.0F, 1.0F)) * (kCosines - 1);
        const float y = std::sqrt(glm::clamp(alpha, 0.0F, 1.0F)) * (kAlphas - 1);
        const int c = std::min(static_cast<int>(x), kCosines - 2);
        const int a = std::min(static_cast<int>(y), kAlphas - 2);
        const auto at = [&](int i, int j) { return values_[static_cast<std::size_t>(i * kCosines + j)]; };
        const float u = x - static_cast<float>(c);
        return glm::mix(glm::mix(at(a, c), at(a, c + 1), u), glm::mix(at(a + 1, c), at(a + 1, c + 1), u), y - static_cast<float>(a));
    }

  private:
    static float cosineAt(int i) { return std::max(sqr(static_cast<float>(i) / (kCosines - 1)), 1e-3F); }
    static float alphaAt(int i) { return std::max(sqr(static_cast<float>(i) / (kAlphas - 1)), kLeastAlpha); }

    /// Midpoint rule in (cosine, azimuth): 32 x 32 nodes.
    static float integral(float cosO, float alpha) {
        constexpr int kNodes = 32;
        const float sinO = std::sqrt(1 - cosO * cosO);
        float sum = 0;
        for (int i = 0; i < kNodes; ++i) {
            const float z = (static_cast<float>(i) + 0.5F) / kNodes;
            const float r = std::sqrt(1 - z * z);
            for (int j = 0; j < kNodes; ++j) {
                const float x = r * std::cos(kPi * (static_cast<float>(j) + 0.5F) / kNodes);
                // |wo + wi|^2 = 2 (1 + <wo, wi>).
                const float h = std::sqrt(std::max(2 * (1 + sinO * x + cosO * z), 1e-12F));
                sum += lobe(cosO, z, std::min((cosO + z) / h, 1.0F), alpha);
            }
        }
        return sum * (2 * kPi / (kNodes * kNodes));
    }

    std::array<float, static_cast<std::size_t>(kAlphas *kCosines)> values_{};
};

inline float albedo(float cosine, float alpha) {
    static const AlbedoTable table;
    return table(cosine, alpha);
}

} // namespace taut::sheen
