#include "taut/render/hit_lanes.h"

#include "taut/base/sobol.h"
#include "taut/bsdf/bsdf.h"
#include "taut/render/roulette.h"
#include "taut/scene/material_gloss.h"

namespace taut {

namespace {

#define TAUT_INLINE [[gnu::always_inline]] inline

TAUT_INLINE void geometryLoop(HitLanes &l) {
    const int count = l.padded();
#pragma GCC ivdep
    for (int i = 0; i < count; ++i) {
        InterpolatedSurface p;
        p.position = l.position.at(i);
        p.e1 = l.e1.at(i);
        p.e2 = l.e2.at(i);
        p.normal = l.normal.at(i);
        p.tangent = Vec4(l.tangent.at(i), l.tangentSense[i]);
        p.corners = l.corners[i];
        const SurfaceGeometry g = surfaceGeometry(p, l.wo.at(i));
        l.geometricNormal.set(i, g.geometricNormal);
        l.s.set(i, g.s);
        l.t.set(i, g.t);
        l.n.set(i, g.n);
        const Vec3 wo = l.wo.at(i);
        l.woLocal.set(i, {glm::dot(wo, g.s), glm::dot(wo, g.t), glm::dot(wo, g.n)});
        l.clearance[i] = g.clearance;
        l.facing[i] = g.facing;
        l.tangentX[i] = g.tangent.x;
        l.tangentY[i] = g.tangent.y;
        l.sense[i] = g.sense;
        const SymmetricTensor v{l.diagonal.at(i), l.offDiagonal.at(i)};
        const Vec3 seen = seenIn(v, g.s, g.t);
        const bool deforms = l.deforms[i] != 0;
        l.stretch.set(i, {deforms ? seen.x : 1.0F, deforms ? seen.y : 0.0F, deforms ? seen.z : 1.0F});
    }
}

/// The 2x2 block of M before it is brought to triangular form.
TAUT_INLINE BasicBlock<double> blockOf(const HitLanes &l, std::size_t i, const PlainMaterial &m) {
    const bool isotropic = m.alphaX == m.alphaY;
    const Vec2 turned = restAxis({l.tangentX[i], l.tangentY[i]}, m.cosine, m.sine, l.sense[i]);
    const BasicBlock<double> rest = restBlock(m.alphaX, m.alphaY, Vec2(isotropic ? 1.0F : turned.x, isotropic ? 0.0F : turned.y));
    const Vec3 v = l.stretch.at(i);
    return {v.x * rest.a + v.y * rest.c, v.x * rest.b + v.y * rest.d, v.y * rest.a + v.z * rest.c, v.y * rest.b + v.z * rest.d};
}

TAUT_INLINE void setMicro(HitLanes &l, std::size_t i, const MicroTransform &m) {
    l.a[i] = m.a;
    l.b[i] = m.b;
    l.d[i] = m.d;
    l.inverseA[i] = m.inverseA;
    l.inverseD[i] = m.inverseD;
    l.det[i] = m.det;
}

TAUT_INLINE void microLoop(HitLanes &l, const PlainMaterial &m) {
    const int count = l.padded();
#pragma GCC ivdep
    for (int i = 0; i < count; ++i) {
        const BasicBlock<double> block = blockOf(l, i, m);
        const TriangularForm<double> form = triangularForm(block.a, block.b, block.c, block.d);
        setMicro(l, i, canonicalTransform<float>(form.across, form.along, form.length));
        l.inRange[i] = form.inRange ? 1 : 0;
    }
}

TAUT_INLINE void viewLoop(HitLanes &l, float bearableWaste, bool refracts) {
    const int count = l.padded();
#pragma GCC ivdep
    for (int i = 0; i < count; ++i) {
        const MicroTransform m = l.micro(i);
        const Vec3 wo = l.woLocal.at(i);
        const float length = ggx::stretchedLength(m, wo);
        const float area = ggx::visibleArea(m, wo, length);
        const float bound = ggx::reflectionBound(m, wo);
        const float k = refracts ? 1.0F : bound; // refraction needs all visible normals
        l.length[i] = length;
        l.area[i] = area;
        l.capBound[i] = k;
        l.pdfScale[i] = 0.5F / ggx::capArea(k, wo.z, length, area);
        const bool cone = ReflectionSampler::prefersCone(m, wo, bearableWaste);
        l.cone[i] = cone && !refracts ? 1 : 0;
    }
}

TAUT_INLINE void numbersLoop(HitLanes &l, const EventNumbers &numbers) {
    const int count = l.padded();
#pragma GCC ivdep
    for (int i = 0; i < count; ++i) {
        const Vec2 light = sobol2(l.sample[i], hash(l.seed[i], numbers.lightPoint));
        l.lightU[i] = light.x;
        l.lightV[i] = light.y;
        l.lightChoice[i] = sobol1(l.sample[i], hash(l.seed[i], numbers.lightChoice));
    }
#pragma GCC ivdep
    for (int i = 0; i < count; ++i) {
        const Vec2 scattered = sobol2(l.sample[i], hash(l.seed[i], numbers.scatterDirection));
        l.scatterU[i] = scattered.x;
        l.scatterV[i] = scattered.y;
        l.coin[i] = sobol1(l.sample[i], hash(l.seed[i], numbers.scatterLobe));
    }
#pragma GCC ivdep
    for (int i = 0; i < count; ++i) l.roulette[i] = sobol1(l.sample[i], hash(l.seed[i], numbers.roulette));
}

/// Bsdf::eta from the lane's side.
template <class Kind> TAUT_INLINE float relativeIndex(const HitLanes &l, std::size_t i, const Bsdf &bsdf) {
    if constexpr (Kind::kInfo.refracts)
        return l.facing[i] > 0 ? bsdf.eta : 1 / bsdf.eta;
    else
        return bsdf.eta;
}

template <class Kind, bool kCorrelated> TAUT_INLINE LobeView lobeViewOf(const HitLanes &l, std::size_t i, const Bsdf &bsdf) {
    return {l.length[i], l.area[i], l.pdfScale[i], kCorrelated, relativeIndex<Kind>(l, i, bsdf)};
}

/// fCos and density for wi, local. Where the density is 0, as below the horizon of what only reflects, fCos means nothing: selecting it
/// would put square roots behind a branch.
template <class Kind, bool kCorrelated>
TAUT_INLINE BsdfEval evaluateLane(const HitLanes &l, std::size_t i, const Bsdf &bsdf, const Vec3 &wi) {
    const LobeView view = lobeViewOf<Kind, kCorrelated>(l, i, bsdf);
    const BsdfEval above = Kind::Class::above(bsdf, l.micro(i), view, l.woLocal.at(i), wi);
    // By components: a copy of the whole would keep it in memory, and the loop scalar.
    if constexpr (Kind::kInfo.transmits) {
        const BsdfEval below = Kind::Class::below(bsdf, l.micro(i), view, l.woLocal.at(i), wi);
        const bool up = wi.z > 0;
        return {Vec3(up ? above.fCos.x : below.fCos.x, up ? above.fCos.y : below.fCos.y, up ? above.fCos.z : below.fCos.z),
                up ? above.pdf : below.pdf};
    } else {
        return {Vec3(above.fCos.x, above.fCos.y, above.fCos.z), wi.z > 0 ? above.pdf : 0.0F};
    }
}

TAUT_INLINE Vec3 toLocal(const HitLanes &l, std::size_t i, const Vec3 &w) {
    return {glm::dot(w, l.s.at(i)), glm::dot(w, l.t.at(i)), glm::dot(w, l.n.at(i))};
}

/// How far along the geometric normal a ray starts that leaves to its `side`.
template <class Kind> TAUT_INLINE float awayFrom(const HitLanes &l, std::size_t i, float side) {
    if constexpr (Kind::kInfo.transmits)
        return side > 0 ? l.clearance[i] : -l.clearance[i];
    else
        return l.clearance[i];
}

template <class Kind, bool kCorrelated> TAUT_INLINE void connectLoop(HitLanes &l, const PlainMaterial &material) {
    const Bsdf bsdf = material.bsdf; // no store can change this one
    const int count = l.padded();
#pragma GCC ivdep
    for (int i = 0; i < count; ++i) {
        const Vec3 direction = l.lightDirection.at(i);
        const Vec3 wi = toLocal(l, i, direction);
        const float side = glm::dot(direction, l.geometricNormal.at(i));
        const BsdfEval scattered = evaluateLane<Kind, kCorrelated>(l, i, bsdf, wi);
        const float lightPdf = l.lightPdf[i];
        const float mis = l.lightWeighted[i] != 0 ? powerHeuristic(lightPdf, scattered.pdf) : 1.0F;
        const Vec3 contribution = l.throughput.at(i) * scattered.fCos * l.lightRadiance.at(i) * (mis / lightPdf);
        l.contribution.set(i, contribution);
        l.shadowOrigin.set(i, l.position.at(i) + l.geometricNormal.at(i) * awayFrom<Kind>(l, i, side));
        // Nothing below the horizon of what only reflects; nor where shading and geometric normal disagree about the side: no light
        // leaks.
        const float agreed = Kind::kInfo.transmits ? side * wi.z : side;
        const float least = std::min(std::min(lightPdf, agreed), std::min(scattered.pdf, maxComponent(contribution)));
        l.connects[i] = least;
    }
}

template <class Kind> TAUT_INLINE void directionLoop(HitLanes &l, const PlainMaterial &material) {
    const Bsdf bsdf = material.bsdf;
    const int count = l.padded();
#pragma GCC ivdep
    for (int i = 0; i < count; ++i) {
        const Vec2 u(l.scatterU[i], l.scatterV[i]);
        const LobeView view = lobeViewOf<Kind, true>(l, i, bsdf);
        const LaneSample sample = Kind::Class::sampleLane(bsdf, l.micro(i), view, l.capBound[i], l.woLocal.at(i), u, l.coin[i]);
        l.scatterLocal.set(i, sample.wi);
        if constexpr (Kind::kInfo.transmits) l.usable[i] = sample.usable;
    }
}

template <class Kind, bool kCorrelated> TAUT_INLINE void scatterLoop(HitLanes &l, const PlainMaterial &material) {
    const Bsdf bsdf = material.bsdf;
    const int count = l.padded();
#pragma GCC ivdep
    for (int i = 0; i < count; ++i) {
        const Vec3 wi = l.scatterLocal.at(i);
        const BsdfEval e = evaluateLane<Kind, kCorrelated>(l, i, bsdf, wi);
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
        if constexpr (Kind::kInfo.transmits) usable = std::min(side * wi.z, l.usable[i]);
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

/// Calls `loop` with the kind of a plain material.
template <class Loop> TAUT_INLINE void byKind(const PlainMaterial &material, const Loop &loop) {
    onBsdf(material.bsdf.type, [&](auto kind) {
        if constexpr (decltype(kind)::kInfo.lanes) loop(kind);
    });
}

#define TAUT_LOOPS(NAME, ...)                                                                                                              \
    struct NAME {                                                                                                                          \
        [[gnu::flatten __VA_ARGS__]] static void geometry(HitLanes &l) { geometryLoop(l); }                                                \
        [[gnu::flatten __VA_ARGS__]] static void micro(HitLanes &l, const PlainMaterial &m) { microLoop(l, m); }                           \
        [[gnu::flatten __VA_ARGS__]] static void view(HitLanes &l, float waste, bool r) { viewLoop(l, waste, r); }                         \
        [[gnu::flatten __VA_ARGS__]] static void numbers(HitLanes &l, const EventNumbers &e) { numbersLoop(l, e); }                        \
        template <class Kind>[[gnu::flatten __VA_ARGS__]] static void connect(HitLanes &l, const PlainMaterial &m) {                       \
            m.bsdf.correlated ? connectLoop<Kind, true>(l, m) : connectLoop<Kind, false>(l, m);                                            \
        }                                                                                                                                  \
        template <class Kind>[[gnu::flatten __VA_ARGS__]] static void direction(HitLanes &l, const PlainMaterial &m) {                     \
            directionLoop<Kind>(l, m);                                                                                                     \
        }                                                                                                                                  \
        template <class Kind>[[gnu::flatten __VA_ARGS__]] static void scatter(HitLanes &l, const PlainMaterial &m) {                       \
            m.bsdf.correlated ? scatterLoop<Kind, true>(l, m) : scatterLoop<Kind, false>(l, m);                                            \
        }                                                                                                                                  \
    };
TAUT_FOR_INSTRUCTION_SETS(TAUT_LOOPS)

} // namespace

PlainMaterial plainMaterial(const PreparedMaterial &prepared) {
    PlainMaterial plain;
    const Material &m = *prepared.material;
    const BsdfInfo &info = bsdfInfo(m.type);
    if (!info.lanes || m.unlit || m.vertexColors || m.color.texture != kNone || m.metallic.texture != kNone || m.poisson != 0) return plain;
    if (m.slopes.isGiven() || m.roughening > 0) return plain;
    if (info.refracts && fresnel::isMatched(m.ior)) return plain; // passes light straight on (bsdf.h)
    plain.bsdf = bsdfOf(prepared, valuesOf(prepared, m.color.value), 1);
    if (info.microsurface) {
        const bool textured = m.alphaX.texture != kNone || m.alphaY.texture != kNone || m.rotation.texture != kNone ||
                              m.anisotropyTexture != kNone || m.anisotropyStrength != 0;
        if (textured || multiscatterOf(m, prepared.multiscatter.model) != Multiscatter::Off) return plain;
        static const Scene kNoTextures;
        const RestRoughness rest = restRoughness(m, kNoTextures, Vec2(0));
        plain.alphaX = rest.alphaX;
        plain.alphaY = rest.alphaY;
        if (rest.rotation != 0) {
            plain.cosine = std::cos(rest.rotation);
            plain.sine = std::sin(rest.rotation);
        }
    }
    plain.isPlain = true;
    return plain;
}

bool isPlain(const RenderObject &object) {
    const Object &source = *object.object;
    const bool stretchAsItIs = object.stretchOnFaces() || object.plan.interpolation == GradientInterpolation::Stretch;
    return !emits(source) && !source.lean && object.storedPoisson.empty() && object.steps.size() == 1 && object.placements.size() <= 1 &&
           stretchAsItIs;
}

namespace lanes {

void view(HitLanes &lanes, const PlainMaterial &material, const EventNumbers &numbers, Instructions instructions) {
    onInstructions(instructions, [&](auto loops) {
        using Loops = decltype(loops);
        Loops::geometry(lanes);
        Loops::numbers(lanes, numbers);
        const BsdfInfo &info = bsdfInfo(material.bsdf.type);
        if (!info.microsurface) return;
        Loops::micro(lanes, material);
        for (int i = 0; i < lanes.padded(); ++i) {
            if (lanes.inRange[i] != 0) continue;
            const BasicBlock<double> block = blockOf(lanes, static_cast<std::size_t>(i), material);
            setMicro(lanes, static_cast<std::size_t>(i), microTransform(block.a, block.b, block.c, block.d));
        }
        Loops::view(lanes, material.bsdf.bearableWaste, info.refracts);
        lanes.cones.clear();
        for (int i = 0; i < lanes.count; ++i) {
            if (lanes.cone[i] == 0) continue;
            const auto at = static_cast<std::size_t>(i);
            lanes.cones.emplace_back(lanes.micro(at), lanes.woLocal.at(at), material.bsdf.bearableWaste);
            lanes.cone[i] = static_cast<int>(lanes.cones.size());
            lanes.pdfScale[i] = lanes.cones.back().pdfScale();
        }
    });
}

void aim(HitLanes &l, const LightTable &lights) {
    std::size_t lanesOfSky[HitLanes::kSize];
    std::size_t count = 0;
    for (std::size_t i = 0; i < static_cast<std::size_t>(l.padded()); ++i) {
        const LightChoice choice = chooseLight(lights, l.position.at(i), l.lightChoice[i]);
        l.lightEntry[i] = choice.entry;
        if (choice.entry != kNone && choice.entry == lights.environmentEntry) {
            l.sky.u[count] = l.lightU[i];
            l.sky.v[count] = l.lightV[i];
            l.lightPdf[i] = choice.probability;
            l.lightWeighted[i] = 1;
            l.lightDistance[i] = kInfinity;
            lanesOfSky[count++] = i;
            continue;
        }
        const LightSample light = sampleLight(lights, choice, l.position.at(i), l.time[i], {l.lightU[i], l.lightV[i]});
        l.lightDirection.set(i, light.direction);
        l.lightRadiance.set(i, light.radiance);
        l.lightPdf[i] = light.pdf;
        l.lightWeighted[i] = light.delta ? 0.0F : 1.0F;
        l.lightDistance[i] = light.distance;
    }
    if (count == 0) return;
    l.sky.count = static_cast<int>(count);
    sampleEnvironment(*lights.environment, l.sky);
    const Mat3 renderFromWorld = glm::transpose(lights.worldFromRender);
    for (std::size_t k = 0; k < count; ++k) {
        const std::size_t i = lanesOfSky[k];
        l.lightDirection.set(i, renderFromWorld * l.sky.direction.at(k));
        l.lightRadiance.set(i, l.sky.radiance.at(k));
        l.lightPdf[i] *= l.sky.pdf[k];
    }
}

void connect(HitLanes &lanes, const PlainMaterial &material, Instructions instructions) {
    onInstructions(instructions, [&](auto loops) {
        byKind(material, [&](auto kind) { decltype(loops)::template connect<decltype(kind)>(lanes, material); });
    });
}

void scatter(HitLanes &lanes, const PlainMaterial &material, Instructions instructions) {
    onInstructions(instructions, [&](auto loops) {
        using Loops = decltype(loops);
        byKind(material, [&](auto kind) { Loops::template direction<decltype(kind)>(lanes, material); });
        if (bsdfInfo(material.bsdf.type).microsurface)
            for (int i = 0; i < lanes.count; ++i) {
                if (lanes.cone[i] == 0) continue;
                const ReflectionSampler &sampler = lanes.cones[static_cast<std::size_t>(lanes.cone[i] - 1)];
                const auto wi = sampler.sample({lanes.scatterU[i], lanes.scatterV[i]}, lanes.coin[i]);
                lanes.scatterLocal.set(static_cast<std::size_t>(i), wi.value_or(Vec3(0, 0, -1)));
            }
        byKind(material, [&](auto kind) { Loops::template scatter<decltype(kind)>(lanes, material); });
    });
}

} // namespace lanes
} // namespace taut
