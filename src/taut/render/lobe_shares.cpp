#include "taut/render/lane_kinds.h"

#include <algorithm>

namespace taut {

namespace {

/// Shares of samples of a kind with several lobes, in steps: what costs much is left out where no lane wants it.
template <class Kind> TAUT_INLINE void normalLoop(HitLanes &l, const LaneMaterial &material) {
    const MaterialValues alike = material.values;
    const int count = l.padded();
#pragma GCC ivdep
    for (int i = 0; i < count; ++i) {
        const Bsdf bsdf = bsdfAt<Kind>(l, i, alike);
        const Vec3 wo = l.woLocal.at(i);
        l.dark[i] = Kind::Class::isSurelyDark(bsdf, microOf<kLeans<Kind>>(l, i), wo) ? 1 : 0;
        const auto reflected = Kind::Class::reflectedAtNormal(bsdf, wo);
        const bool dark = l.dark[i] != 0;
        l.reflected.set(i, {dark ? reflected.all.x : 0.0F, dark ? reflected.all.y : 0.0F, dark ? reflected.all.z : 0.0F});
        l.cover[i] = dark ? reflected.cover : 0.0F;
        l.kept[i] = 1;
        l.suffices[i] = 1;
    }
}
template <class Kind> TAUT_INLINE void visibleLoop(HitLanes &l, const LaneMaterial &material, std::size_t node) {
    const MaterialValues alike = material.values;
    const int count = l.padded();
#pragma GCC ivdep
    for (int i = 0; i < count; ++i) {
        const Bsdf bsdf = bsdfAt<Kind>(l, i, alike);
        typename Kind::Class::Reflected mean{l.reflected.at(i), l.cover[i]};
        const bool dark = l.dark[i] != 0;
        const auto before = mean;
        Kind::Class::addVisible(bsdf, microOf<kLeans<Kind>>(l, i), l.woLocal.at(i), node, mean);
        l.reflected.set(i, {dark ? before.all.x : mean.all.x, dark ? before.all.y : mean.all.y, dark ? before.all.z : mean.all.z});
        l.cover[i] = dark ? before.cover : mean.cover;
    }
}
template <class Kind> TAUT_INLINE void roomLoop(HitLanes &l, const LaneMaterial &material) {
    const MaterialValues alike = material.values;
    const int count = l.padded();
#pragma GCC ivdep
    for (int i = 0; i < count; ++i) {
        const auto room = Kind::Class::roomFor(bsdfAt<Kind>(l, i, alike), l.woLocal.at(i), {l.reflected.at(i), l.cover[i]});
        l.suffices[i] = (l.dark[i] != 0) | room.suffices() ? 1 : 0;
    }
}
template <class Kind> TAUT_INLINE void keptLoop(HitLanes &l, const LaneMaterial &material) {
    const MaterialValues alike = material.values;
    const int count = l.padded();
#pragma GCC ivdep
    for (int i = 0; i < count; ++i) {
        const auto room = Kind::Class::roomFor(bsdfAt<Kind>(l, i, alike), l.woLocal.at(i), {l.reflected.at(i), l.cover[i]});
        const float kept = Kind::Class::keptIn(room, l.viewLoss[i], l.severalColor.at(i));
        l.kept[i] = l.suffices[i] != 0 ? 1.0F : kept;
    }
}
template <class Kind> TAUT_INLINE void shareLoop(HitLanes &l, const LaneMaterial &material) {
    const MaterialValues alike = material.values;
    const int count = l.padded();
#pragma GCC ivdep
    for (int i = 0; i < count; ++i) {
        const Bsdf bsdf = bsdfAt<Kind>(l, i, alike);
        if constexpr (Kind::kInfo.reads(kMetallicKey)) {
            LobeShares shares;
            shares.kept = l.kept[i];
            float coat = 0;
            if constexpr (kLayered<Kind>) {
                coat = clear_coat::reflectance(l.clearcoat[i], l.coat->woLocal.at(i));
                shares.under -= coat;
            }
            MultipleScattering several;
            several.loss = l.loss[i];
            several.probability = l.chance[i];
            several.color = l.severalColor.at(i);
            Kind::Class::divide(bsdf, {l.reflected.at(i), l.cover[i]}, 0, coat, shares, several);
            if constexpr (kLayered<Kind>) {
                l.coatReflected[i] = coat;
                l.coated[i] = shares.coat;
                l.under[i] = shares.under;
            }
            l.facets[i] = shares.facets;
            l.diffuse[i] = shares.diffuse;
            l.chance[i] = several.probability;
            l.severalColor.set(i, several.color);
        } else {
            l.facets[i] = Kind::Class::split(bsdf, l.woLocal.at(i));
        }
    }
}

using Views = energy::CoordinateLanes<HitLanes::kStep>;

#define TAUT_LOOPS(NAME, ...)                                                                                                              \
    struct NAME {                                                                                                                          \
        template <class Kind>[[gnu::flatten __VA_ARGS__]] static void normal(HitLanes &l, const LaneMaterial &m) {                         \
            normalLoop<Kind>(l, m);                                                                                                        \
        }                                                                                                                                  \
        template <class Kind>[[gnu::flatten __VA_ARGS__]] static void visible(HitLanes &l, const LaneMaterial &m, std::size_t node) {      \
            visibleLoop<Kind>(l, m, node);                                                                                                 \
        }                                                                                                                                  \
        template <class Kind>[[gnu::flatten __VA_ARGS__]] static void room(HitLanes &l, const LaneMaterial &m) { roomLoop<Kind>(l, m); }   \
        [[gnu::flatten __VA_ARGS__]] static void albedos(const Views &at, float *albedo) {                                                 \
            energy::singleScatterAlbedos<HitLanes::kStep>(at, albedo, energy::table::kAlbedo.data());                                      \
        }                                                                                                                                  \
        template <class Kind>[[gnu::flatten __VA_ARGS__]] static void kept(HitLanes &l, const LaneMaterial &m) { keptLoop<Kind>(l, m); }   \
        template <class Kind>[[gnu::flatten __VA_ARGS__]] static void share(HitLanes &l, const LaneMaterial &m) { shareLoop<Kind>(l, m); } \
    };
TAUT_FOR_INSTRUCTION_SETS(TAUT_LOOPS)

/// What is done about light of several facets, where the material asks for it.
template <class Loops, class Kind> void setSeveral(HitLanes &l, const LaneMaterial &material) {
    const auto count = static_cast<std::size_t>(l.padded());
    const PreparedMaterial &prepared = *material.prepared;
    const bool asks = multiscatterOf(*prepared.material, prepared.multiscatter.model) != Multiscatter::Off;
    for (std::size_t i = 0; i < count; ++i) {
        MultipleScattering several;
        bool walks = false;
        if (asks) {
            Bsdf bsdf = bsdfAt<Kind>(l, i, material.values);
            bsdf.type = material.bsdf.type;
            bsdf.micro = l.micro(i);
            bsdf.multiscatter = treatmentAt(prepared, l.metallic[i], bsdf.micro, l.leans && l.tilted[i] != 0);
            walks = bsdf.multiscatter == Multiscatter::Walk;
            if (bsdf.multiscatter == Multiscatter::Compensation) several = multiple::prepare(bsdf, l.woLocal.at(i));
            if constexpr (Kind::kInfo.reads(kMetallicKey)) Kind::Class::color(bsdf, several);
        }
        l.several[i] = several.treatment == Multiscatter::Compensation ? 1 : 0;
        l.scattersAlone[i] = walks ? 1 : 0;
        l.compensates |= l.several[i] != 0;
        l.loss[i] = several.loss;
        l.lossMean[i] = several.lossMean;
        l.chance[i] = several.probability;
        l.severalColor.set(i, several.color);
    }
}

/// Of the lanes whose diffuse part has to know, as few as they are, side by side.
template <class Loops> void setViewLoss(HitLanes &l) {
    std::size_t asking[HitLanes::kSize];
    std::size_t count = 0;
    for (std::size_t i = 0; i < static_cast<std::size_t>(l.padded()); ++i) {
        l.viewLoss[i] = 0;
        if (l.suffices[i] == 0 && l.woLocal.z[i] > 0 && l.micro(i).upright()) asking[count++] = i;
    }
    for (std::size_t first = 0; first < count; first += HitLanes::kStep) {
        Views at;
        float albedo[HitLanes::kStep];
        for (std::size_t k = 0; k < HitLanes::kStep; ++k) {
            const std::size_t i = asking[std::min(first + k, count - 1)];
            at.set(k, energy::coordinates(l.micro(i), l.woLocal.at(i)));
        }
        Loops::albedos(at, albedo);
        for (std::size_t k = 0; first + k < std::min(count, first + HitLanes::kStep); ++k) l.viewLoss[asking[first + k]] = 1 - albedo[k];
    }
}

/// Shares of the lobes, where there are several.
template <class Loops, class Kind> void setLobes(HitLanes &l, const LaneMaterial &material) {
    if constexpr (Kind::kInfo.reads(kMetallicKey)) {
        Loops::template normal<Kind>(l, material);
        const auto all = [&](const int *flags) { return std::all_of(flags, flags + l.count, [](int flag) { return flag != 0; }); };
        if (!all(l.dark)) {
            for (std::size_t node = 0; node < Kind::Class::kMeanNodes; ++node) Loops::template visible<Kind>(l, material, node);
            Loops::template room<Kind>(l, material);
        }
        if (!all(l.suffices)) {
            setViewLoss<Loops>(l);
            Loops::template kept<Kind>(l, material);
        }
    }
    Loops::template share<Kind>(l, material);
}

} // namespace

void lanes::setShares(HitLanes &lanes, const LaneMaterial &material, Instructions instructions) {
    onInstructions(instructions, [&](auto loops) {
        byKind(lanes, material, [&](auto kind) {
            using Kind = decltype(kind);
            if constexpr (Kind::kInfo.manyFacets) setSeveral<decltype(loops), Kind>(lanes, material);
            if (lanes.allAlone()) return;
            if constexpr (kHasShares<Kind>) setLobes<decltype(loops), Kind>(lanes, material);
        });
    });
}

} // namespace taut
