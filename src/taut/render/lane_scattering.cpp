#include "taut/bsdf/tilted_facet.h"
#include "taut/render/lane_kinds.h"
#include "taut/render/roulette.h"

namespace taut {

namespace {

template <class Kind, bool kCorrelated> TAUT_INLINE LobeView lobeViewOf(const HitLanes &l, std::size_t i, const Bsdf &bsdf) {
    const bool correlated = Kind::kInfo.refracts ? kCorrelated : l.correlated[i] != 0;
    LobeView view{l.length[i], l.area[i], l.pdfScale[i], correlated, relativeIndex<Kind>(l, i, bsdf), {}};
    if constexpr (kHasShares<Kind>) view.shares.facets = l.facets[i];
    if constexpr (kHasShares<Kind> && Kind::kInfo.reads(kMetallicKey)) {
        view.shares.diffuse = l.diffuse[i];
        view.shares.kept = l.kept[i];
    }
    if constexpr (kLayered<Kind>) {
        view.shares.coat = l.coated[i];
        view.shares.under = l.under[i];
    }
    return view;
}

/// A direction of the base's frame in the coat's, and back.
TAUT_INLINE Vec3 toCoat(const HitLanes &coat, std::size_t i, const Vec3 &w) {
    return selected(coat.tilted[i] != 0, Vec3(glm::dot(w, coat.s.at(i)), glm::dot(w, coat.t.at(i)), glm::dot(w, coat.n.at(i))), w);
}
TAUT_INLINE Vec3 fromCoat(const HitLanes &coat, std::size_t i, const Vec3 &w) {
    return selected(coat.tilted[i] != 0, coat.s.at(i) * w.x + coat.t.at(i) * w.y + coat.n.at(i) * w.z, w);
}
TAUT_INLINE clear_coat::Seen coatOf(const HitLanes &l, std::size_t i) {
    const HitLanes &coat = *l.coat;
    return {microOf<true>(coat, i),
            {coat.length[i], coat.area[i], coat.pdfScale[i], l.correlated[i] != 0, 1, {}},
            l.coatReflected[i],
            coat.woLocal.at(i)};
}

/// fCos and density for wi, local; `compensation`: multiple::compensation() towards it. Where the density is 0, as below the horizon of
/// what only reflects, fCos means nothing: selecting it would put square roots behind a branch.
template <class Kind, bool kCorrelated, bool kSeveral>
TAUT_INLINE BsdfEval evaluateLane(const HitLanes &l, std::size_t i, const Bsdf &bsdf, const Vec3 &wi, float compensation) {
    const LobeView view = lobeViewOf<Kind, kCorrelated>(l, i, bsdf);
    const MicroTransform m = microOf<kLeans<Kind>>(l, i);
    BsdfEval above;
    if constexpr (kLayered<Kind>) {
        above = Kind::Class::aboveCoated(bsdf, m, view, coatOf(l, i), l.woLocal.at(i), wi, toCoat(*l.coat, i, wi));
    } else {
        above = Kind::Class::above(bsdf, m, view, l.woLocal.at(i), wi);
    }
    if constexpr (kSeveral) {
        const Vec3 several = l.severalColor.at(i) * compensation;
        const float chance = l.chance[i];
        const float pdf = (1 - chance) * above.pdf + chance * (kInvPi * wi.z);
        return {Vec3(above.fCos.x + several.x, above.fCos.y + several.y, above.fCos.z + several.z), wi.z > 0 ? pdf : 0.0F};
    } else if constexpr (kPasses<Kind>) {
        const BsdfEval below = Kind::Class::below(bsdf, m, view, l.woLocal.at(i), wi);
        const bool up = wi.z > 0;
        return {Vec3(up ? above.fCos.x : below.fCos.x, up ? above.fCos.y : below.fCos.y, up ? above.fCos.z : below.fCos.z),
                up ? above.pdf : below.pdf};
    } else {
        return {byComponents(above.fCos), wi.z > 0 ? above.pdf : 0.0F};
    }
}

TAUT_INLINE Vec3 toLocal(const HitLanes &l, std::size_t i, const Vec3 &w) {
    return {glm::dot(w, l.s.at(i)), glm::dot(w, l.t.at(i)), glm::dot(w, l.n.at(i))};
}

/// How far along the geometric normal a ray starts that leaves to its `side`.
template <class Kind> TAUT_INLINE float awayFrom(const HitLanes &l, std::size_t i, float side) {
    if constexpr (kPasses<Kind>)
        return side > 0 ? l.clearance[i] : -l.clearance[i];
    else
        return l.clearance[i];
}

/// Towards render-space directions, or local ones.
template <bool kLocal> TAUT_INLINE void compensationLoop(HitLanes &l, const HitLanes::Vectors &directions) {
    constexpr std::size_t kBlock = HitLanes::kStep;
    const auto count = static_cast<std::size_t>(l.padded());
    for (std::size_t first = 0; first < count; first += kBlock) {
        energy::CoordinateLanes<kBlock> at;
        float z[kBlock];
        float albedo[kBlock];
#pragma GCC ivdep
        for (std::size_t k = 0; k < kBlock; ++k) {
            const Vec3 w = kLocal ? directions.at(first + k) : toLocal(l, first + k, directions.at(first + k));
            at.set(k, energy::coordinates(microOf<false>(l, first + k), w)); // by its block alone
            z[k] = w.z;
        }
        energy::singleScatterAlbedos<kBlock>(at, albedo, energy::table::kAlbedo.data());
        for (std::size_t k = 0; k < kBlock; ++k)
            l.compensation[first + k] = energy::multipleLobe(l.loss[first + k], 1 - albedo[k], l.lossMean[first + k], z[k]);
    }
}

/// What a light sample brings by what is scattered of it.
TAUT_INLINE Vec3 broughtBy(const HitLanes &l, std::size_t i, const BsdfEval &scattered) {
    const float lightPdf = l.lightPdf[i];
    const float mis = l.lightWeighted[i] != 0 ? powerHeuristic(lightPdf, scattered.pdf) : 1.0F;
    return l.throughput.at(i) * scattered.fCos * l.lightRadiance.at(i) * (mis / lightPdf);
}

template <class Kind, bool kCorrelated, bool kSeveral> TAUT_INLINE void connectLoop(HitLanes &l, const LaneMaterial &material) {
    const MaterialValues alike = material.values; // no store can change these
    const int count = l.padded();
#pragma GCC ivdep
    for (int i = 0; i < count; ++i) {
        const Bsdf bsdf = bsdfAt<Kind>(l, i, alike);
        const Vec3 direction = l.lightDirection.at(i);
        const Vec3 wi = toLocal(l, i, direction);
        const float side = glm::dot(direction, l.geometricNormal.at(i));
        const BsdfEval scattered = evaluateLane<Kind, kCorrelated, kSeveral>(l, i, bsdf, wi, kSeveral ? l.compensation[i] : 0.0F);
        const float lightPdf = l.lightPdf[i];
        const Vec3 contribution = broughtBy(l, i, scattered);
        l.contribution.set(i, contribution);
        l.shadowOrigin.set(i, l.position.at(i) + l.geometricNormal.at(i) * awayFrom<Kind>(l, i, side));
        // Nothing below the horizon of what only reflects; nor where shading and geometric normal disagree about the side: no light
        // leaks.
        const float agreed = kPasses<Kind> ? side * wi.z : side;
        const float least = std::min(std::min(lightPdf, agreed), std::min(scattered.pdf, maxComponent(contribution)));
        l.connects[i] = least;
    }
}

/// What tilted facets send to the light by way of its mirror image in the mesh's plane (FacetScattering): in few lanes, one by one.
template <class Kind, bool kCorrelated, bool kSeveral> TAUT_INLINE void mirrorLoop(HitLanes &l, const LaneMaterial &material) {
    for (std::size_t i = 0; i < static_cast<std::size_t>(l.count); ++i) {
        if (l.tilted[i] == 0 || !(l.lightPdf[i] > 0)) continue;
        const Vec3 direction = l.lightDirection.at(i);
        const Vec3 plane = l.geometricNormal.at(i);
        const float side = glm::dot(direction, plane);
        const Vec3 wi = toLocal(l, i, tilted::mirrored(direction, side, plane));
        if (!tilted::agree(wi.z, side) || (!kPasses<Kind> && !(side > 0))) continue;
        float compensation = 0;
        if constexpr (kSeveral) compensation = multiple::compensation(l.micro(i), l.loss[i], l.lossMean[i], wi);
        const BsdfEval e = evaluateLane<Kind, kCorrelated, kSeveral>(l, i, bsdfAt<Kind>(l, i, material.values), wi, compensation);
        if (!(e.pdf > 0)) continue;
        const Vec3 straight = l.connects[i] > 0 ? l.contribution.at(i) : Vec3(0);
        l.contribution.set(i, straight + broughtBy(l, i, e));
        l.connects[i] = maxComponent(l.contribution.at(i));
    }
}

template <class Kind, bool kSeveral> TAUT_INLINE void directionLoop(HitLanes &l, const LaneMaterial &material) {
    const MaterialValues alike = material.values;
    const int count = l.padded();
#pragma GCC ivdep
    for (int i = 0; i < count; ++i) {
        const Bsdf bsdf = bsdfAt<Kind>(l, i, alike);
        const Vec2 u(l.scatterU[i], l.scatterV[i]);
        const LobeView view = lobeViewOf<Kind, true>(l, i, bsdf);
        // What is left of the number that chose the lobe is uniform again.
        const float chance = kSeveral ? l.chance[i] : 0.0F;
        const bool several = kSeveral && l.coin[i] < chance;
        const float rest = kSeveral && chance > 0 ? (l.coin[i] - chance) / (1 - chance) : l.coin[i];
        LaneSample sample = Kind::Class::sampleLane(bsdf, microOf<kLeans<Kind>>(l, i), view, l.capBound[i], l.woLocal.at(i), u, rest);
        if constexpr (kLayered<Kind>) {
            const float beside = rest - view.shares.facets;
            const bool coated = !several & (beside >= 0) & (beside < view.shares.coat);
            const float coin = beside / (coated ? view.shares.coat : 1.0F);
            const HitLanes &layer = *l.coat;
            const LaneSample coat = Reflector<typename Kind::Class>::sampleLane(bsdf, microOf<true>(layer, i), view, layer.capBound[i],
                                                                                layer.woLocal.at(i), u, coin);
            const Vec3 wi = selected(coat.wi.z > 0, fromCoat(layer, i, coat.wi), Vec3(0, 0, -1));
            sample.wi = selected(coated, wi, sample.wi);
            l.coatCoin[i] = coated ? coin : -1.0F;
        }
        const Vec3 spread = kSeveral ? squareToCosineHemisphere(u) : Vec3(0);
        l.scatterLocal.set(i, {several ? spread.x : sample.wi.x, several ? spread.y : sample.wi.y, several ? spread.z : sample.wi.z});
        l.facetCoin[i] = several ? -1.0F : sample.coin;
        if constexpr (kPasses<Kind>) l.usable[i] = sample.usable;
    }
}

template <class Kind, bool kCorrelated, bool kSeveral> TAUT_INLINE void scatterLoop(HitLanes &l, const LaneMaterial &material) {
    const MaterialValues alike = material.values;
    const int count = l.padded();
#pragma GCC ivdep
    for (int i = 0; i < count; ++i) {
        const Bsdf bsdf = bsdfAt<Kind>(l, i, alike);
        const Vec3 wi = l.scatterLocal.at(i);
        const BsdfEval e = evaluateLane<Kind, kCorrelated, kSeveral>(l, i, bsdf, wi, kSeveral ? l.compensation[i] : 0.0F);
        const bool sampled = e.pdf > 0;
        const Vec3 weight = e.fCos * (1 / (sampled ? e.pdf : 1.0F));
        Vec3 world = l.s.at(i) * wi.x + l.t.at(i) * wi.y + l.n.at(i) * wi.z;
        if constexpr (kLeans<Kind>) {
            const Vec3 plane = l.geometricNormal.at(i);
            const float height = glm::dot(world, plane);
            const bool straight = (l.tilted[i] == 0) | tilted::agree(wi.z, height);
            world = selected(straight, world, tilted::mirrored(world, height, plane));
        }
        const Vec3 direction = world * (1 / std::sqrt(glm::dot(world, world)));
        const float side = glm::dot(direction, l.geometricNormal.at(i));
        Vec3 throughput = l.throughput.at(i) * weight;
        float etaScale = l.etaScale[i];
        float usable = side;
        if constexpr (Kind::kInfo.refracts) {
            const float eta = relativeIndex<Kind>(l, i, bsdf);
            etaScale *= wi.z < 0 ? eta * eta : 1.0F;
        }
        if constexpr (kPasses<Kind>) usable = std::min(side * wi.z, l.usable[i]);
        l.nextEtaScale[i] = etaScale;
        const float chance = chanceToGoOn(throughput, etaScale);
        throughput *= 1 / (chance > 0 ? chance : 1.0F);
        l.nextThroughput.set(i, throughput);
        l.nextDirection.set(i, direction);
        l.nextOrigin.set(i, l.position.at(i) + l.geometricNormal.at(i) * awayFrom<Kind>(l, i, side));
        l.scatterPdf[i] = e.pdf;
        l.goesOn[i] = std::min(std::min(e.pdf, usable), chance - l.roulette[i]);
    }
}

/// A direction from a lane's cone; pointing down where it leads below the horizon.
TAUT_INLINE Vec3 coneDirection(const HitLanes &l, std::size_t i, const Vec2 &u, float coin) {
    const HitLanes::Cones &from = l.cones;
    ReflectionCone cone;
    cone.axisNormal = from.axisNormal.at(i);
    cone.disk = from.disk.at(i);
    cone.along = Vec2(from.alongX[i], from.alongY[i]);
    cone.tilt = Vec2(from.tiltX[i], from.tiltY[i]);
    cone.inverseAxis = from.inverseAxis[i];
    const Vec3 wo = l.woLocal.at(i);
    const Vec3 wm = cone.normal(u, coin);
    const Vec3 wi = (2 * glm::dot(wo, wm) / glm::dot(wm, wm)) * wm - wo;
    return selected(wi.z > 0, wi, Vec3(0, 0, -1));
}
TAUT_INLINE void conesLoop(HitLanes &l) {
    const int count = l.padded();
#pragma GCC ivdep
    for (int i = 0; i < count; ++i) {
        const Vec3 wi = coneDirection(l, i, Vec2(l.scatterU[i], l.scatterV[i]), l.facetCoin[i]);
        l.scatterLocal.set(i, selected((l.cone[i] != 0) & (l.facetCoin[i] >= 0), wi, l.scatterLocal.at(i)));
    }
}
TAUT_INLINE void coatConesLoop(HitLanes &l) {
    const HitLanes &coat = *l.coat;
    const int count = l.padded();
#pragma GCC ivdep
    for (int i = 0; i < count; ++i) {
        const Vec3 wi = coneDirection(coat, i, Vec2(l.scatterU[i], l.scatterV[i]), l.coatCoin[i]);
        const Vec3 world = selected(wi.z > 0, fromCoat(coat, i, wi), Vec3(0, 0, -1));
        l.scatterLocal.set(i, selected((coat.cone[i] != 0) & (l.coatCoin[i] >= 0), world, l.scatterLocal.at(i)));
    }
}

/// Also with whether light of several facets is given back.
template <class Loop> TAUT_INLINE void bySeveral(const HitLanes &lanes, const LaneMaterial &material, const Loop &loop) {
    byKind(lanes, material, [&](auto kind) {
        if constexpr (decltype(kind)::kInfo.compensates())
            if (lanes.compensates) return loop(kind, std::true_type());
        loop(kind, std::false_type());
    });
}

/// Also with how facets mask each other, where that takes a loop of its own: what refracts needs other functions for correlated heights;
/// others select (HitLanes::correlated).
template <class Kind, bool kSeveral, class Loop> TAUT_INLINE void byMasking(const LaneMaterial &material, const Loop &loop) {
    if constexpr (Kind::kInfo.refracts && !kSeveral)
        if (!material.bsdf.correlated) return loop(std::false_type());
    loop(std::true_type());
}

#define TAUT_LOOPS(NAME, ...)                                                                                                              \
    struct NAME {                                                                                                                          \
        template <class Kind, bool kSeveral>[[gnu::flatten __VA_ARGS__]] static void connect(HitLanes &l, const LaneMaterial &m) {         \
            byMasking<Kind, kSeveral>(m, [&](auto correlated) { connectLoop<Kind, correlated(), kSeveral>(l, m); });                       \
        }                                                                                                                                  \
        template <class Kind, bool kSeveral>[[gnu::flatten __VA_ARGS__]] static void mirror(HitLanes &l, const LaneMaterial &m) {          \
            byMasking<Kind, kSeveral>(m, [&](auto correlated) { mirrorLoop<Kind, correlated(), kSeveral>(l, m); });                        \
        }                                                                                                                                  \
        template <class Kind, bool kSeveral>[[gnu::flatten __VA_ARGS__]] static void direction(HitLanes &l, const LaneMaterial &m) {       \
            directionLoop<Kind, kSeveral>(l, m);                                                                                           \
        }                                                                                                                                  \
        template <class Kind, bool kSeveral>[[gnu::flatten __VA_ARGS__]] static void scatter(HitLanes &l, const LaneMaterial &m) {         \
            byMasking<Kind, kSeveral>(m, [&](auto correlated) { scatterLoop<Kind, correlated(), kSeveral>(l, m); });                       \
        }                                                                                                                                  \
        [[gnu::flatten __VA_ARGS__]] static void cones(HitLanes &l) { conesLoop(l); }                                                      \
        [[gnu::flatten __VA_ARGS__]] static void coatCones(HitLanes &l) { coatConesLoop(l); }                                              \
        template <bool kLocal>[[gnu::flatten __VA_ARGS__]] static void compensation(HitLanes &l, const HitLanes::Vectors &w) {             \
            compensationLoop<kLocal>(l, w);                                                                                                \
        }                                                                                                                                  \
    };
TAUT_FOR_INSTRUCTION_SETS(TAUT_LOOPS)

} // namespace

namespace lanes {

void connect(HitLanes &lanes, const LaneMaterial &material, Instructions instructions) {
    onInstructions(instructions, [&](auto loops) {
        using Loops = decltype(loops);
        if (lanes.compensates) Loops::template compensation<false>(lanes, lanes.lightDirection);
        bySeveral(lanes, material, [&](auto kind, auto several) {
            Loops::template connect<decltype(kind), several()>(lanes, material);
            if constexpr (kLeans<decltype(kind)>) Loops::template mirror<decltype(kind), several()>(lanes, material);
        });
    });
}

void scatter(HitLanes &lanes, const LaneMaterial &material, Instructions instructions) {
    onInstructions(instructions, [&](auto loops) {
        using Loops = decltype(loops);
        bySeveral(lanes, material, [&](auto kind, auto several) { Loops::template direction<decltype(kind), several()>(lanes, material); });
        if (bsdfInfo(material.bsdf.type).microsurface && hasCones(lanes)) Loops::cones(lanes);
        if (material.layered && hasCones(*lanes.coat)) Loops::coatCones(lanes);
        if (lanes.compensates) Loops::template compensation<true>(lanes, lanes.scatterLocal);
        bySeveral(lanes, material, [&](auto kind, auto several) { Loops::template scatter<decltype(kind), several()>(lanes, material); });
    });
}

} // namespace lanes
} // namespace taut
