#pragma once
/// What loops over the lanes of one kind of BSDF share. Internal to hit_lanes.h's sources.

#include "taut/bsdf/bsdf.h"
#include "taut/render/hit_lanes.h"

namespace taut {

#define TAUT_INLINE [[gnu::always_inline]] inline

/// A kind in lanes whose M may lean and whose facets a map may tilt.
template <class Kind> struct LeaningKind : Kind { static constexpr bool kLeaning = true; };
template <class Kind> constexpr bool kLeans = requires {
    Kind::kLeaning;
};
/// And one with layers on top of such facets: metallic-roughness.
template <class Kind> struct LayeredKind : LeaningKind<Kind> { static constexpr bool kLayers = true; };
template <class Kind> constexpr bool kLayered = requires {
    Kind::kLayers;
};
/// M in a loop over such lanes, or over others.
template <bool kLean> TAUT_INLINE MicroTransform microOf(const HitLanes &l, std::size_t i) {
    return {l.a[i], l.b[i], l.d[i], kLean ? l.p[i] : 0.0F, kLean ? l.q[i] : 0.0F, l.inverseA[i], l.inverseD[i], l.det[i]};
}

/// Whether any lane samples its cone of reflections.
inline bool hasCones(const HitLanes &l) {
    return std::any_of(l.cone, l.cone + l.count, [](int cone) { return cone != 0; });
}

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

TAUT_INLINE void setMicro(HitLanes &l, std::size_t i, const MicroTransform &m) {
    l.a[i] = m.a;
    l.b[i] = m.b;
    l.d[i] = m.d;
    l.inverseA[i] = m.inverseA;
    l.inverseD[i] = m.inverseD;
    l.det[i] = m.det;
}

/// Of a mesh that leans, in the shading frame.
TAUT_INLINE Vec2 leanOf(const HitLanes &l, std::size_t i) {
    const bool leans = l.hasOthers && l.other[i] != 0;
    return {leans ? l.otherLean[i].x : 0.0F, leans ? l.otherLean[i].y : 0.0F};
}

TAUT_INLINE Vec3 selected(bool first, const Vec3 &a, const Vec3 &b) {
    return {first ? a.x : b.x, first ? a.y : b.y, first ? a.z : b.z};
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
    values.specular = kLayered<Kind> ? l.specular[i] : alike.specular;
    values.specularColor = kLayered<Kind> ? l.specularColor.at(i) : byComponents(alike.specularColor);
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
template <class Loop> TAUT_INLINE void byKind(const HitLanes &lanes, const LaneMaterial &material, const Loop &loop) {
    onBsdf(material.bsdf.type, [&](auto kind) {
        if constexpr (decltype(kind)::kInfo.lanes) {
            if constexpr (decltype(kind)::kInfo.reads(kMetallicKey))
                if (material.layered) return loop(LayeredKind<decltype(kind)>());
            if (lanes.leans) return loop(LeaningKind<decltype(kind)>());
            loop(kind);
        }
    });
}

namespace lanes {

// Parts of view(), in their order.

/// Leans of the mesh, for M.
void setLeans(HitLanes &lanes);
/// M of the mesh.
void setMicrosurface(HitLanes &lanes, Instructions instructions);
/// Facets that a map tilts, instead of the frame and the M of the mesh. `glossy`: they have an M.
void setFacets(HitLanes &lanes, FacetModel model, bool glossy, Instructions instructions);
/// Strain of meshes that roughen.
void roughen(HitLanes &lanes, const Material &material);
/// What is seen of M.
void setView(HitLanes &lanes, float bearableWaste, bool refracts, Instructions instructions);
/// The coat: before the facets of the base are tilted, and after.
void startCoat(HitLanes &lanes);
void setCoat(HitLanes &lanes, const LaneMaterial &material, Instructions instructions);

/// Shares of the lobes of kinds that have several, and what is done about light of several facets.
void setShares(HitLanes &lanes, const LaneMaterial &material, Instructions instructions);

} // namespace lanes
} // namespace taut
