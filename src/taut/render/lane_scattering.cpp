#include "taut/render/lane_kinds.h"
#include "taut/render/roulette.h"

namespace taut {

namespace {

template <class Kind, bool kCorrelated> TAUT_INLINE LobeView lobeViewOf(const HitLanes &l, std::size_t i, const Bsdf &bsdf) {
    LobeView view{l.length[i], l.area[i], l.pdfScale[i], kCorrelated, relativeIndex<Kind>(l, i, bsdf), {}};
    if constexpr (kHasShares<Kind>) view.shares.facets = l.facets[i];
    if constexpr (kHasShares<Kind> && Kind::kInfo.reads(kMetallicKey)) {
        view.shares.diffuse = l.diffuse[i];
        view.shares.kept = l.kept[i];
    }
    return view;
}

/// fCos and density for wi, local. Where the density is 0, as below the horizon of what only reflects, fCos means nothing: selecting it
/// would put square roots behind a branch.
template <class Kind, bool kCorrelated, bool kSeveral>
TAUT_INLINE BsdfEval evaluateLane(const HitLanes &l, std::size_t i, const Bsdf &bsdf, const Vec3 &wi) {
    const LobeView view = lobeViewOf<Kind, kCorrelated>(l, i, bsdf);
    const BsdfEval above = Kind::Class::above(bsdf, l.micro(i), view, l.woLocal.at(i), wi);
    if constexpr (kSeveral) {
        const Vec3 several = l.severalColor.at(i) * l.compensation[i];
        const float chance = l.chance[i];
        const float pdf = (1 - chance) * above.pdf + chance * (kInvPi * wi.z);
        return {Vec3(above.fCos.x + several.x, above.fCos.y + several.y, above.fCos.z + several.z), wi.z > 0 ? pdf : 0.0F};
    } else if constexpr (kPasses<Kind>) {
        const BsdfEval below = Kind::Class::below(bsdf, l.micro(i), view, l.woLocal.at(i), wi);
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
            at.set(k, energy::coordinates(l.micro(first + k), w));
            z[k] = w.z;
        }
        energy::singleScatterAlbedos<kBlock>(at, albedo, energy::table::kAlbedo.data());
        for (std::size_t k = 0; k < kBlock; ++k)
            l.compensation[first + k] = energy::multipleLobe(l.loss[first + k], 1 - albedo[k], l.lossMean[first + k], z[k]);
    }
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
        const BsdfEval scattered = evaluateLane<Kind, kCorrelated, kSeveral>(l, i, bsdf, wi);
        const float lightPdf = l.lightPdf[i];
        const float mis = l.lightWeighted[i] != 0 ? powerHeuristic(lightPdf, scattered.pdf) : 1.0F;
        const Vec3 contribution = l.throughput.at(i) * scattered.fCos * l.lightRadiance.at(i) * (mis / lightPdf);
        l.contribution.set(i, contribution);
        l.shadowOrigin.set(i, l.position.at(i) + l.geometricNormal.at(i) * awayFrom<Kind>(l, i, side));
        // Nothing below the horizon of what only reflects; nor where shading and geometric normal disagree about the side: no light
        // leaks.
        const float agreed = kPasses<Kind> ? side * wi.z : side;
        const float least = std::min(std::min(lightPdf, agreed), std::min(scattered.pdf, maxComponent(contribution)));
        l.connects[i] = least;
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
        const LaneSample sample = Kind::Class::sampleLane(bsdf, l.micro(i), view, l.capBound[i], l.woLocal.at(i), u, rest);
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
        const BsdfEval e = evaluateLane<Kind, kCorrelated, kSeveral>(l, i, bsdf, wi);
        const bool sampled = e.pdf > 0;
        const Vec3 weight = e.fCos * (1 / (sampled ? e.pdf : 1.0F));
        const Vec3 world = l.s.at(i) * wi.x + l.t.at(i) * wi.y + l.n.at(i) * wi.z;
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

/// Also with whether light of several facets is given back.
template <class Loop> TAUT_INLINE void bySeveral(const HitLanes &lanes, const LaneMaterial &material, const Loop &loop) {
    byKind(material, [&](auto kind) {
        if constexpr (decltype(kind)::kInfo.compensates())
            if (lanes.compensates) return loop(kind, std::true_type());
        loop(kind, std::false_type());
    });
}

#define TAUT_LOOPS(NAME, ...)                                                                                                              \
    struct NAME {                                                                                                                          \
        template <class Kind, bool kSeveral>[[gnu::flatten __VA_ARGS__]] static void connect(HitLanes &l, const LaneMaterial &m) {         \
            m.bsdf.correlated ? connectLoop<Kind, true, kSeveral>(l, m) : connectLoop<Kind, false, kSeveral>(l, m);                        \
        }                                                                                                                                  \
        template <class Kind, bool kSeveral>[[gnu::flatten __VA_ARGS__]] static void direction(HitLanes &l, const LaneMaterial &m) {       \
            directionLoop<Kind, kSeveral>(l, m);                                                                                           \
        }                                                                                                                                  \
        template <class Kind, bool kSeveral>[[gnu::flatten __VA_ARGS__]] static void scatter(HitLanes &l, const LaneMaterial &m) {         \
            m.bsdf.correlated ? scatterLoop<Kind, true, kSeveral>(l, m) : scatterLoop<Kind, false, kSeveral>(l, m);                        \
        }                                                                                                                                  \
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
        bySeveral(lanes, material, [&](auto kind, auto several) { Loops::template connect<decltype(kind), several()>(lanes, material); });
    });
}

void scatter(HitLanes &lanes, const LaneMaterial &material, Instructions instructions) {
    onInstructions(instructions, [&](auto loops) {
        using Loops = decltype(loops);
        bySeveral(lanes, material, [&](auto kind, auto several) { Loops::template direction<decltype(kind), several()>(lanes, material); });
        if (bsdfInfo(material.bsdf.type).microsurface)
            for (int i = 0; i < lanes.count; ++i) {
                if (lanes.cone[i] == 0 || lanes.facetCoin[i] < 0) continue;
                const ReflectionSampler &sampler = lanes.cones[static_cast<std::size_t>(lanes.cone[i] - 1)];
                const auto wi = sampler.sample({lanes.scatterU[i], lanes.scatterV[i]}, lanes.facetCoin[i]);
                lanes.scatterLocal.set(static_cast<std::size_t>(i), wi.value_or(Vec3(0, 0, -1)));
            }
        if (lanes.compensates) Loops::template compensation<true>(lanes, lanes.scatterLocal);
        bySeveral(lanes, material, [&](auto kind, auto several) { Loops::template scatter<decltype(kind), several()>(lanes, material); });
    });
}

} // namespace lanes
} // namespace taut
