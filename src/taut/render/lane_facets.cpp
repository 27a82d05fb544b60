#include "taut/bsdf/tilted_facet.h"
#include "taut/render/lane_kinds.h"

#include <algorithm>

namespace taut {

namespace {

/// What rest blocks of M0 in the facets' frames are kept in.
struct RestBlocks {
    double a[HitLanes::kSize], b[HitLanes::kSize], c[HitLanes::kSize], d[HitLanes::kSize];
    [[nodiscard]] BasicBlock<double> at(std::size_t i) const { return {a[i], b[i], c[i], d[i]}; }
    void set(std::size_t i, const BasicBlock<double> &block) {
        a[i] = block.a;
        b[i] = block.b;
        c[i] = block.c;
        d[i] = block.d;
    }
};

TAUT_INLINE void restLoop(const HitLanes &l, RestBlocks &blocks) {
    const int count = l.padded();
#pragma GCC ivdep
    for (int i = 0; i < count; ++i) {
        const Vector2<double> axis(l.cosine[i], l.sine[i]);
        blocks.set(i, restBlock<double>(static_cast<double>(l.alphaX[i]), static_cast<double>(l.alphaY[i]), axis));
    }
}

/// Of a map, on the viewer's side.
TAUT_INLINE Vec2 slopeOf(const HitLanes &l, std::size_t i) {
    return {l.slopeX[i] * l.facing[i], l.slopeY[i] * l.facing[i]};
}
/// `lean`: of the mesh.
TAUT_INLINE DMat3 facetMatrix(const HitLanes &l, std::size_t i, const RestBlocks &blocks, const Vec2 &lean) {
    const DMat3 mesh = surfaceDeformation(DVec3(l.stretch.at(i)), DVec2(l.tangentX[i], l.tangentY[i]), static_cast<double>(l.sense[i]),
                                          l.inverseLambda[i], DVec2(lean));
    return mappedMatrix(mesh, DVec2(slopeOf(l, i)), blocks.at(i));
}

/// facetAt(): the frame of what scatters, and where `kMicro` its M too.
template <bool kMicro> TAUT_INLINE void facetLoop(HitLanes &l, const RestBlocks &blocks) {
    const int count = l.padded();
#pragma GCC ivdep
    for (int i = 0; i < count; ++i) {
        const GeneralForm form = generalForm(facetMatrix(l, i, blocks, Vec2(l.p[i], l.q[i])));
        const Vec3 spread = l.slopeSpread.at(i);
        const bool flat = (l.slopeX[i] == 0) & (l.slopeY[i] == 0) & (spread.x == 0) & (spread.y == 0) & (spread.z == 0);
        const bool tilted = !flat & form.hasInverse & (form.n.z > kLeastFacing);
        l.tilted[i] = tilted ? 1 : 0;
        if constexpr (kMicro) {
            const TriangularForm<double> upper = triangularForm(form.block.a, form.block.b, form.block.c, form.block.d);
            const MicroTransform m = canonicalTransform<float>(upper.across, upper.along, upper.length, form.p, form.q);
            const MicroTransform plain = microOf<true>(l, i);
            l.a[i] = tilted ? m.a : plain.a;
            l.b[i] = tilted ? m.b : plain.b;
            l.d[i] = tilted ? m.d : plain.d;
            l.p[i] = tilted ? m.p : plain.p;
            l.q[i] = tilted ? m.q : plain.q;
            l.inverseA[i] = tilted ? m.inverseA : plain.inverseA;
            l.inverseD[i] = tilted ? m.inverseD : plain.inverseD;
            l.det[i] = tilted ? m.det : plain.det;
            l.inRange[i] = !tilted | upper.inRange ? 1 : 0;
        }
        const Vec3 s = l.s.at(i);
        const Vec3 t = l.t.at(i);
        const Vec3 n = l.n.at(i);
        const auto placed = [&](const Vec3 &w) __attribute__((always_inline)) {
            return s * w.x + t * w.y + n * w.z;
        };
        const Vec3 facetS = selected(tilted, placed(form.s), s);
        const Vec3 facetT = selected(tilted, placed(form.t), t);
        const Vec3 facetN = selected(tilted, placed(form.n), n);
        l.s.set(i, facetS);
        l.t.set(i, facetT);
        l.n.set(i, facetN);
        const Vec3 wo = l.wo.at(i);
        const Vec3 local(glm::dot(wo, facetS), glm::dot(wo, facetT), glm::dot(wo, facetN));
        l.woLocal.set(i, selected(tilted, tilted::seen(local), local));
    }
}

/// The coat's frame and what it is seen from, in the frame of the base.
TAUT_INLINE void coatLoop(const HitLanes &base, HitLanes &coat) {
    const int count = base.padded();
#pragma GCC ivdep
    for (int i = 0; i < count; ++i) {
        const Vec3 s = base.s.at(i);
        const Vec3 t = base.t.at(i);
        const Vec3 n = base.n.at(i);
        const auto seen = [&](const Vec3 &w) __attribute__((always_inline)) {
            return Vec3(glm::dot(w, s), glm::dot(w, t), glm::dot(w, n));
        };
        const Vec3 coatS = seen(coat.s.at(i));
        const Vec3 coatT = seen(coat.t.at(i));
        const Vec3 coatN = seen(coat.n.at(i));
        const bool tilted = (base.tilted[i] != 0) | (coat.tilted[i] != 0);
        const Vec3 wo = base.woLocal.at(i);
        const Vec3 local(glm::dot(wo, coatS), glm::dot(wo, coatT), glm::dot(wo, coatN));
        coat.s.set(i, coatS);
        coat.t.set(i, coatT);
        coat.n.set(i, coatN);
        coat.tilted[i] = tilted ? 1 : 0;
        coat.woLocal.set(i, selected(tilted, local, wo));
    }
}

#define TAUT_LOOPS(NAME, ...)                                                                                                              \
    struct NAME {                                                                                                                          \
        [[gnu::flatten __VA_ARGS__]] static void rest(const HitLanes &l, RestBlocks &blocks) { restLoop(l, blocks); }                      \
        template <bool kMicro>[[gnu::flatten __VA_ARGS__]] static void facet(HitLanes &l, const RestBlocks &blocks) {                      \
            facetLoop<kMicro>(l, blocks);                                                                                                  \
        }                                                                                                                                  \
        [[gnu::flatten __VA_ARGS__]] static void coat(const HitLanes &base, HitLanes &coat) { coatLoop(base, coat); }                      \
    };
TAUT_FOR_INSTRUCTION_SETS(TAUT_LOOPS)

} // namespace

namespace lanes {

void setFacets(HitLanes &l, FacetModel model, bool glossy, Instructions instructions) {
    const auto count = static_cast<std::size_t>(l.padded());
    onInstructions(instructions, [&](auto loops) {
        using Loops = decltype(loops);
        RestBlocks blocks;
        Loops::rest(l, blocks);
        for (std::size_t i = 0; i < count; ++i)
            if (l.slopeSpread.at(i) != Vec3(0)) blocks.set(i, broadenedBlock(blocks.at(i), {slopeOf(l, i), l.slopeSpread.at(i)}));
        if (!glossy || model == FacetModel::Bends) return Loops::template facet<false>(l, blocks);
        Loops::template facet<true>(l, blocks);
        for (std::size_t i = 0; i < count; ++i)
            if (l.inRange[i] == 0) setMicro(l, i, generalTransform(facetMatrix(l, i, blocks, leanOf(l, i)))->micro);
    });
}

void startCoat(HitLanes &base) {
    HitLanes &coat = *base.coat;
    const auto padded = static_cast<std::size_t>(base.padded());
    coat.count = base.count;
    coat.leans = true;
    coat.wo = base.wo;
    coat.s = base.s;
    coat.t = base.t;
    coat.n = base.n;
    coat.stretch = base.stretch;
    std::copy_n(base.facing, padded, coat.facing);
    std::copy_n(base.sense, padded, coat.sense);
    std::copy_n(base.tangentX, padded, coat.tangentX);
    std::copy_n(base.tangentY, padded, coat.tangentY);
    std::copy_n(base.inverseLambda, padded, coat.inverseLambda);
    coat.hasOthers = base.hasOthers;
    if (!coat.hasOthers) return;
    std::copy_n(base.other, padded, coat.other);
    std::copy_n(base.otherLean, padded, coat.otherLean);
    std::copy_n(base.strain, padded, coat.strain);
    std::copy_n(base.stored, padded, coat.stored);
}

void setCoat(HitLanes &base, const LaneMaterial &material, Instructions instructions) {
    HitLanes &coat = *base.coat;
    const Material &m = *material.prepared->material;
    setLeans(coat);
    setMicrosurface(coat, instructions);
    if (m.coatSlopes.isGiven()) setFacets(coat, m.facets, true, instructions);
    roughen(coat, m);
    onInstructions(instructions, [&](auto loops) { decltype(loops)::coat(base, coat); });
    setView(coat, material.bsdf.bearableWaste, false, instructions);
}

} // namespace lanes
} // namespace taut
