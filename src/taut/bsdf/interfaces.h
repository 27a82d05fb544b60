#pragma once
/// What one facet does to light: the interfaces that BSDFs are made of and the random walk (microsurface/random_walk.h) bounces between.

#include "taut/bsdf/fresnel.h"

namespace taut {

/// A metal of complex index eta + i k.
struct ConductorInterface {
    static constexpr bool kTransmits = false;
    Vec3 eta, k;
    [[nodiscard]] Vec3 reflectance(float cosine, bool /*beyond*/ = false) const { return fresnel::conductor(cosine, eta, k); }
    /// Over diffuse light.
    [[nodiscard]] Vec3 meanReflectance() const {
        return fresnel::diffuseMean([&](float cosine) { return reflectance(cosine); });
    }
};

/// Schlick's reflectance.
struct SchlickInterface {
    static constexpr bool kTransmits = false;
    Vec3 f0{1};
    [[nodiscard]] Vec3 reflectance(float cosine, bool /*beyond*/ = false) const { return fresnel::schlick(cosine, f0); }
    [[nodiscard]] Vec3 meanReflectance() const { return f0 + (Vec3(1) - f0) / 21.0F; }
};

/// A clear interface; eta = index beyond / index on the viewer's side.
struct DielectricInterface {
    static constexpr bool kTransmits = true;
    float eta = 1.5F;
    [[nodiscard]] float relativeIndex(bool beyond) const { return beyond ? 1 / eta : eta; }
    [[nodiscard]] Vec3 reflectance(float cosine, bool beyond = false) const {
        return Vec3(fresnel::dielectric(cosine, relativeIndex(beyond)));
    }
    [[nodiscard]] bool refract(const Vec3 &v, const Vec3 &wm, float cosine, bool beyond, Vec3 &w) const {
        return fresnel::refract(v, wm, cosine, relativeIndex(beyond), w);
    }
};

} // namespace taut
