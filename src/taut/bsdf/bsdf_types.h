#pragma once
/// What scatters at a hit, as plain data, and what scattering answers. The functions are in bsdf.h.

#include "taut/bsdf/bsdf_table.h"
#include "taut/bsdf/multiscatter_choice.h"

namespace taut {

/// Share of reflections that may be lost to the horizon before the sampler that loses none is worth its preparation.
inline constexpr float kBearableWaste = 0.1F;

/// Everything needed to scatter at a hit. What a field means depends on the type.
struct Bsdf {
    BsdfType type = BsdfType::Diffuse;
    bool correlated = true;                        ///< height-correlated G2, else separable
    Multiscatter multiscatter = Multiscatter::Off; ///< what the type can; needs `correlated`; Auto is Off here
    float eta = 1.5F;                              ///< index beyond / index on the viewer's side; of a layer: its own
    float diffuseEscape = 1;                       ///< coats: (1 - internal diffuse reflectance), from coatEscape()
    MicroTransform micro;
    float bearableWaste = kBearableWaste; ///< ReflectionSampler: 0: never bounded caps; 1: always
    Vec3 f0{1};                           ///< Schlick types
    Vec3 albedo{0};                       ///< diffuse part
    Vec3 tint{1};                         ///< of what passes
    Vec3 conductorEta{1};
    Vec3 conductorK{0};
};

/// A material's numbers at a hit, textures looked up: what a Bsdf is made from.
struct MaterialValues {
    Vec3 color{1};
    float ior = 1.5F;
    float metallic = 0;
    float coatEscape = 1; ///< coatEscape(ior), worked out once
    Vec3 conductorEta{1}, conductorK{0};
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

/// A direction sampled among many at once: no answer but where `usable` > 0.
struct LaneSample {
    Vec3 wi;
    float usable;
};

} // namespace taut
