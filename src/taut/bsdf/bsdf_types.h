#pragma once
/// What scatters at a hit, as plain data, and what scattering answers. The functions are in bsdf.h.

#include "taut/bsdf/fresnel.h"
#include "taut/bsdf/multiscatter.h"

namespace taut {

enum class BsdfType : std::uint8_t { Conductor, SchlickConductor, Dielectric, Diffuse, Coated, MetallicRoughness };

/// Share of reflections that may be lost to the horizon before the sampler that loses none is worth its preparation.
inline constexpr float kBearableWaste = 0.1F;

/// Everything needed to scatter at a hit. What a field means depends on the type, as in scene.h's Material.
struct Bsdf {
    BsdfType type = BsdfType::Diffuse;
    bool correlated = true;                        ///< height-correlated G2, else separable
    Multiscatter multiscatter = Multiscatter::Off; ///< conductors, and dielectrics with Walk; needs `correlated`; Auto is Off here
    float eta = 1.5F;                              ///< index beyond / index on the viewer's side
    float diffuseEscape = 1;                       ///< coats: (1 - internal diffuse reflectance), from coatEscape()
    MicroTransform micro;
    float bearableWaste = kBearableWaste; ///< ReflectionSampler: 0: never bounded caps; 1: always
    Vec3 f0{1};                           ///< Schlick types
    Vec3 albedo{0};                       ///< diffuse part
    Vec3 tint{1};                         ///< dielectric transmission
    Vec3 conductorEta{1};
    Vec3 conductorK{0};
};

struct BsdfEval {
    Vec3 fCos{0};
    float pdf = 0; ///< solid-angle density with which sample() returns wi (walk: about)
};

struct BsdfSample {
    Vec3 wi;     ///< local, unit
    Vec3 weight; ///< fCos / pdf (walk: the throughput)
    float pdf = 0;
    float etaScale = 1; ///< square of the relative index crossed (radiance scaling), for Russian roulette
    bool transmitted = false;
};

/// Reflectance of one facet.
inline Vec3 facetReflectance(const Bsdf &bsdf, float cosine) {
    switch (bsdf.type) {
    case BsdfType::Conductor: return fresnel::conductor(cosine, bsdf.conductorEta, bsdf.conductorK);
    case BsdfType::SchlickConductor:
    case BsdfType::MetallicRoughness: return fresnel::schlick(cosine, bsdf.f0);
    default: return Vec3(fresnel::dielectric(cosine, bsdf.eta));
    }
}

} // namespace taut
