#pragma once
/// What scatters at a hit, as plain data, and what scattering answers. The functions are in bsdf.h.

#include "taut/base/frame.h"
#include "taut/bsdf/bsdf_table.h"
#include "taut/bsdf/multiscatter_choice.h"

namespace taut {

/// Share of reflections that may be lost to the horizon before the sampler that loses none is worth its preparation.
inline constexpr float kBearableWaste = 0.02F;

/// A film whose interference colours what is reflected (thin_film.h).
struct ThinFilm {
    float share = 0; ///< of the surface that has one
    float ior = 1.3F;
    float thickness = 400; ///< nanometres
};

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

    // Metallic-roughness alone.
    float f90 = 1;         ///< reflectance at grazing, f0 that at normal incidence
    float coverF0 = 0;     ///< what its dielectric part reflects, and layers below do not get, in the brightest channel
    float coverF90 = 0;    ///< and at grazing
    bool refracts = false; ///< what passes enters a volume; else it goes straight on
    float metallic = 0;    ///< share of the metal
    Vec3 dielectricF0{0};  ///< of that part alone
    Vec3 metalF0{0};       ///< and of this
    ThinFilm film;
    float coat = 0;           ///< share of a clear coat
    MicroTransform coatMicro; ///< and its microsurface, in
    Frame coatFrame;          ///< its own frame, seen from that of the base, which a map tilts
    bool coatTilted = false;  ///< else they are the same
    Vec3 sheenColor{0};       ///< of fibres on the surface
    float sheenAlpha = 1;     ///< sheen.h
};

/// Whether light may leave on the other side of the surface.
inline bool mayTransmit(const Bsdf &bsdf) {
    const BsdfInfo &info = bsdfInfo(bsdf.type);
    return info.transmits && (!info.reads(kMetallicKey) || bsdf.tint != Vec3(0));
}

/// A material's numbers at a hit, textures looked up: what a Bsdf is made from.
struct MaterialValues {
    Vec3 color{1};
    float ior = 1.5F;
    float metallic = 0;
    float coatEscape = 1; ///< coatEscape(ior), worked out once
    Vec3 conductorEta{1}, conductorK{0};
    // Metallic-roughness, as in Material.
    float specular = 1;
    Vec3 specularColor{1};
    float transmission = 0;
    bool thinWalled = true;
    float clearcoat = 0;
    Vec3 sheenColor{0};
    float sheenAlpha = 1;
    ThinFilm film;
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

/// What is done about light of several facets for one wo.
struct MultipleScattering {
    Multiscatter treatment = Multiscatter::Off; ///< Off, Compensation or Walk
    float loss = 0;                             ///< share of energy that meets more than one facet, F = 1
    float lossMean = 0;                         ///< its cosine-weighted mean over the hemisphere; of walks between reflecting facets too
    float probability = 0;                      ///< compensation: of sampling the compensating lobe
    Vec3 color{0};                              ///< compensation: of the lobe
};

/// A direction sampled among many at once: no answer but where `usable` > 0.
struct LaneSample {
    Vec3 wi;
    float usable;
    float coin; ///< what is left, in [0, 1), of the number that chose the lobe of reflecting facets; below 0 where it is another
};

} // namespace taut
