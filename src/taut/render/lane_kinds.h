#pragma once
/// What loops over the lanes of one kind of BSDF share. Internal to hit_lanes.h's sources.

#include "taut/bsdf/bsdf.h"
#include "taut/render/hit_lanes.h"

namespace taut {

#define TAUT_INLINE [[gnu::always_inline]] inline

/// Whether lanes of a kind send light to the other side.
template <class Kind> constexpr bool kPasses = requires {
    &Kind::Class::below;
};
/// And whether what it reflects lies beside other lobes.
template <class Kind> constexpr bool kHasShares = requires(const Bsdf &bsdf, const Vec3 &wo) {
    Kind::Class::split(bsdf, wo);
}
|| Kind::kInfo.reads(kMetallicKey);

/// A copy of the whole would keep it in memory, and the loop scalar.
TAUT_INLINE Vec3 byComponents(const Vec3 &v) {
    return {v.x, v.y, v.z};
}

/// What a lane scatters by, seen from the outside. Of metallic-roughness without what laneMaterial() refuses, so that nothing of it is
/// asked for.
template <class Kind> TAUT_INLINE Bsdf bsdfAt(const HitLanes &l, std::size_t i, const MaterialValues &alike) {
    MaterialValues values;
    values.color = l.color.at(i);
    values.metallic = l.metallic[i];
    values.ior = alike.ior;
    values.coatEscape = alike.coatEscape;
    values.conductorEta = byComponents(alike.conductorEta);
    values.conductorK = byComponents(alike.conductorK);
    values.specular = alike.specular;
    values.specularColor = byComponents(alike.specularColor);
    Bsdf bsdf;
    bsdf.eta = alike.ior;
    Kind::Class::make(values, bsdf);
    return bsdf;
}

/// Bsdf::eta from the lane's side.
template <class Kind> TAUT_INLINE float relativeIndex(const HitLanes &l, std::size_t i, const Bsdf &bsdf) {
    if constexpr (Kind::kInfo.refracts)
        return l.facing[i] > 0 ? bsdf.eta : 1 / bsdf.eta;
    else
        return bsdf.eta;
}

/// Calls `loop` with the kind of a material.
template <class Loop> TAUT_INLINE void byKind(const LaneMaterial &material, const Loop &loop) {
    onBsdf(material.bsdf.type, [&](auto kind) {
        if constexpr (decltype(kind)::kInfo.lanes) loop(kind);
    });
}

namespace lanes {

/// A part of view(): shares of the lobes of kinds that have several, and what is done about light of several facets.
void setShares(HitLanes &lanes, const LaneMaterial &material, Instructions instructions);

} // namespace lanes
} // namespace taut
