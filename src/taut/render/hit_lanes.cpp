#include "taut/render/hit_lanes.h"

#include "taut/base/sobol.h"
#include "taut/deform/stored_gloss.h"
#include "taut/render/lane_kinds.h"
#include "taut/scene/material_gloss.h"

namespace taut {

namespace {

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
TAUT_INLINE BasicBlock<double> blockOf(const HitLanes &l, std::size_t i) {
    const bool isotropic = l.alphaX[i] == l.alphaY[i];
    const Vec2 turned = restAxis({l.tangentX[i], l.tangentY[i]}, l.cosine[i], l.sine[i], l.sense[i]);
    const BasicBlock<double> rest = restBlock(l.alphaX[i], l.alphaY[i], Vec2(isotropic ? 1.0F : turned.x, isotropic ? 0.0F : turned.y));
    const Vec3 v = l.stretch.at(i);
    const double x = v.x * l.inverseLambda[i];
    const double y = v.y * l.inverseLambda[i];
    const double z = v.z * l.inverseLambda[i];
    return {x * rest.a + y * rest.c, x * rest.b + y * rest.d, y * rest.a + z * rest.c, y * rest.b + z * rest.d};
}

TAUT_INLINE void microLoop(HitLanes &l) {
    const int count = l.padded();
#pragma GCC ivdep
    for (int i = 0; i < count; ++i) {
        const BasicBlock<double> block = blockOf(l, i);
        const TriangularForm<double> form = triangularForm(block.a, block.b, block.c, block.d);
        setMicro(l, i, canonicalTransform<float>(form.across, form.along, form.length));
        l.inRange[i] = form.inRange ? 1 : 0;
    }
}

/// Refraction needs all visible normals, and what leans knows no bound.
template <bool kLean> TAUT_INLINE bool needsAll(const MicroTransform &m, bool refracts) {
    if constexpr (kLean)
        return refracts | !m.upright();
    else
        return refracts;
}
template <bool kLean> TAUT_INLINE void viewLoop(HitLanes &l, float bearableWaste, bool refracts) {
    const int count = l.padded();
#pragma GCC ivdep
    for (int i = 0; i < count; ++i) {
        const MicroTransform m = microOf<kLean>(l, i);
        const Vec3 wo = l.woLocal.at(i);
        const float length = ggx::stretchedLength(m, wo);
        const float area = ggx::visibleArea(m, wo, length);
        const float bound = ggx::reflectionBound(microOf<false>(l, i), wo);
        const float k = needsAll<kLean>(m, refracts) ? 1.0F : bound;
        l.length[i] = length;
        l.area[i] = area;
        l.capBound[i] = k;
        l.pdfScale[i] = 0.5F / ggx::capArea(k, wo.z, length, area);
        const bool cone = ReflectionSampler::prefersCone(m, wo, bearableWaste);
        l.cone[i] = cone && !refracts ? 1 : 0;
    }
}

/// M is upright where there is a cone.
TAUT_INLINE void conesLoop(HitLanes &l) {
    const int count = l.padded();
    HitLanes::Cones &to = l.cones;
#pragma GCC ivdep
    for (int i = 0; i < count; ++i) {
        const ReflectionCone cone = ReflectionCone::of(microOf<false>(l, i), l.woLocal.at(i));
        const bool taken = (l.cone[i] != 0) & cone.usable;
        l.cone[i] = taken ? 1 : 0;
        l.pdfScale[i] = taken ? cone.pdfScale : l.pdfScale[i];
        to.axisNormal.set(i, cone.axisNormal);
        to.disk.set(i, cone.disk);
        to.alongX[i] = cone.along.x;
        to.alongY[i] = cone.along.y;
        to.tiltX[i] = cone.tilt.x;
        to.tiltY[i] = cone.tilt.y;
        to.inverseAxis[i] = cone.inverseAxis;
    }
}

TAUT_INLINE void lightNumbersLoop(HitLanes &l, const EventNumbers &numbers) {
    const int count = l.padded();
#pragma GCC ivdep
    for (int i = 0; i < count; ++i) {
        const Vec2 light = sobol2(l.sample[i], hash(l.seed[i], numbers.light));
        l.lightU[i] = light.x;
        l.lightV[i] = light.y;
    }
}
TAUT_INLINE void choiceNumbersLoop(HitLanes &l, const EventNumbers &numbers) {
    const int count = l.padded();
#pragma GCC ivdep
    for (int i = 0; i < count; ++i) l.lightChoice[i] = sobolThird(l.sample[i], hash(l.seed[i], numbers.light));
}
TAUT_INLINE void numbersLoop(HitLanes &l, const EventNumbers &numbers) {
    const int count = l.padded();
#pragma GCC ivdep
    for (int i = 0; i < count; ++i) {
        const Vec3 scattered = sobol3(l.sample[i], hash(l.seed[i], numbers.scatter));
        l.scatterU[i] = scattered.x;
        l.scatterV[i] = scattered.y;
        l.coin[i] = scattered.z;
    }
#pragma GCC ivdep
    for (int i = 0; i < count; ++i) l.roulette[i] = sobol1(l.sample[i], hash(l.seed[i], numbers.roulette));
}

#define TAUT_LOOPS(NAME, ...)                                                                                                              \
    struct NAME {                                                                                                                          \
        [[gnu::flatten __VA_ARGS__]] static void geometry(HitLanes &l) { geometryLoop(l); }                                                \
        [[gnu::flatten __VA_ARGS__]] static void micro(HitLanes &l) { microLoop(l); }                                                      \
        template <bool kLean>[[gnu::flatten __VA_ARGS__]] static void view(HitLanes &l, float waste, bool r) {                             \
            viewLoop<kLean>(l, waste, r);                                                                                                  \
        }                                                                                                                                  \
        [[gnu::flatten __VA_ARGS__]] static void cones(HitLanes &l) { conesLoop(l); }                                                      \
        [[gnu::flatten __VA_ARGS__]] static void numbers(HitLanes &l, const EventNumbers &e) { numbersLoop(l, e); }                        \
        [[gnu::flatten __VA_ARGS__]] static void lightNumbers(HitLanes &l, const EventNumbers &e) { lightNumbersLoop(l, e); }              \
        [[gnu::flatten __VA_ARGS__]] static void choiceNumbers(HitLanes &l, const EventNumbers &e) { choiceNumbersLoop(l, e); }            \
    };
TAUT_FOR_INSTRUCTION_SETS(TAUT_LOOPS)

/// Fibres, films and what passes scatter one by one.
bool goesAlone(const Material &m) {
    return m.transmission.value > 0 || m.sheenColor.value != Vec3(0) || m.iridescence.value > 0;
}

} // namespace

LaneMaterial laneMaterial(const PreparedMaterial &prepared) {
    LaneMaterial lane;
    const Material &m = *prepared.material;
    const BsdfInfo &info = bsdfInfo(m.type);
    if (m.unlit) return lane;
    if (info.refracts && fresnel::isMatched(m.ior)) return lane; // passes light straight on (bsdf.h)
    static const Scene kNoTextures;
    lane.inLanes = true;
    lane.prepared = &prepared;
    lane.scattersAlone = !info.lanes || (info.reads(kMetallicKey) && goesAlone(m));
    lane.layered = info.reads(kMetallicKey) && (m.clearcoat.value > 0 || m.specular.texture != kNone || m.specularColor.texture != kNone);
    lane.mapped = m.slopes.isGiven();
    lane.coatMapped = m.coatSlopes.isGiven();
    lane.varies = lane.scattersAlone || lane.mapped || lane.layered || m.vertexColors || m.color.texture != kNone ||
                  m.metallic.texture != kNone || m.alphaX.texture != kNone || m.alphaY.texture != kNone || m.rotation.texture != kNone ||
                  m.anisotropyTexture != kNone;
    Material alike = m; // textures are looked up at hits
    alike.color.texture = alike.metallic.texture = alike.alphaX.texture = alike.alphaY.texture = alike.rotation.texture = kNone;
    alike.anisotropyTexture = alike.specular.texture = alike.specularColor.texture = kNone;
    alike.clearcoat = alike.transmission = alike.iridescence = {}; // looked up as well
    alike.sheenColor = {Vec3(0), kNone};
    PreparedMaterial plain = prepared;
    plain.material = &alike;
    lane.values = valuesAt(plain, kNoTextures, baseColorAt(alike, kNoTextures, {}), Vec2(0));
    lane.bsdf = bsdfOf(plain, lane.values, 1);
    if (info.microsurface) lane.rest = restRoughness(alike, kNoTextures, Vec2(0));
    return lane;
}

bool isPlain(const RenderObject &object) {
    const bool stretchAsItIs = object.stretchOnFaces() || object.plan.interpolation == GradientInterpolation::Stretch;
    return !object.object->lean && !object.roughens && object.storedPoisson.empty() && stretchAsItIs;
}

namespace lanes {

void setValues(HitLanes &l, std::size_t lane, const Vec3 &color, float metallic, const RestRoughness &rest) {
    l.color.set(lane, color);
    l.metallic[lane] = metallic;
    l.alphaX[lane] = rest.alphaX;
    l.alphaY[lane] = rest.alphaY;
    l.cosine[lane] = rest.rotation != 0 ? std::cos(rest.rotation) : 1.0F;
    l.sine[lane] = rest.rotation != 0 ? std::sin(rest.rotation) : 0.0F;
}

void setValues(HitLanes &l, const LaneMaterial &material) {
    const auto count = static_cast<std::size_t>(l.padded());
    setValues(l, 0, material.values.color, material.values.metallic, material.rest);
    for (std::size_t i = 1; i < count; ++i) {
        l.color.set(i, l.color.at(0));
        l.metallic[i] = l.metallic[0];
        l.alphaX[i] = l.alphaX[0];
        l.alphaY[i] = l.alphaY[0];
        l.cosine[i] = l.cosine[0];
        l.sine[i] = l.sine[0];
    }
}

void setSlopes(HitLanes &l, std::size_t lane, const SlopeStatistics &slopes) {
    l.slopeX[lane] = slopes.mean.x;
    l.slopeY[lane] = slopes.mean.y;
    l.slopeSpread.set(lane, slopes.covariance);
}

namespace {

/// Poisson's ratio: what V is divided by.
void setLambda(HitLanes &l, float poisson) {
    for (std::size_t i = 0; i < static_cast<std::size_t>(l.padded()); ++i)
        l.inverseLambda[i] = poisson == 0 || (l.hasOthers && l.other[i] != 0 && l.followsPoisson[i] == 0)
                                 ? 1.0
                                 : 1 / static_cast<double>(lambdaOf(l.stretch.at(i), poisson));
}

/// What was gathered of meshes that deform in another way takes the place of the loop's.
void setDeformations(HitLanes &l) {
    for (std::size_t i = 0; i < static_cast<std::size_t>(l.padded()); ++i) {
        if (l.other[i] == 0) continue;
        l.stretch.set(i, l.otherStretch[i]);
        l.tangentX[i] = l.otherTangent[i].x;
        l.tangentY[i] = l.otherTangent[i].y;
    }
}

} // namespace

void setMicrosurface(HitLanes &lanes, Instructions instructions) {
    onInstructions(instructions, [&](auto loops) { decltype(loops)::micro(lanes); });
    for (std::size_t i = 0; i < static_cast<std::size_t>(lanes.padded()); ++i) {
        if (lanes.hasOthers && lanes.other[i] != 0 && lanes.stored[i] != 0) {
            setMicro(lanes, i, storedTransform(lanes.stretch.at(i)));
        } else if (lanes.inRange[i] == 0) {
            const BasicBlock<double> block = blockOf(lanes, i);
            setMicro(lanes, i, microTransform(block.a, block.b, block.c, block.d));
        }
    }
}

void setLeans(HitLanes &l) {
    if (!l.leans) return;
    for (std::size_t i = 0; i < static_cast<std::size_t>(l.padded()); ++i) {
        const Vec2 lean = leanOf(l, i);
        l.p[i] = lean.x;
        l.q[i] = lean.y;
        l.tilted[i] = 0;
    }
}

void roughen(HitLanes &l, const Material &material) {
    if (!l.hasOthers) return;
    for (std::size_t i = 0; i < static_cast<std::size_t>(l.padded()); ++i)
        if (l.other[i] != 0 && l.strain[i] > 0) setMicro(l, i, roughenedBy(material, l.strain[i], l.micro(i)));
}

void setView(HitLanes &lanes, float bearableWaste, bool refracts, Instructions instructions) {
    onInstructions(instructions, [&](auto loops) {
        using Loops = decltype(loops);
        lanes.leans ? Loops::template view<true>(lanes, bearableWaste, refracts)
                    : Loops::template view<false>(lanes, bearableWaste, refracts);
    });
    if (hasCones(lanes)) onInstructions(instructions, [&](auto loops) { decltype(loops)::cones(lanes); });
}

void view(HitLanes &lanes, const LaneMaterial &material, const EventNumbers &numbers, Instructions instructions) {
    onInstructions(instructions, [&](auto loops) {
        using Loops = decltype(loops);
        lanes.compensates = false;
        Loops::geometry(lanes);
        if (lanes.hasOthers) setDeformations(lanes);
        Loops::numbers(lanes, numbers);
        if (numbers.lights > 0) Loops::lightNumbers(lanes, numbers);
        if (numbers.lights > 1) Loops::choiceNumbers(lanes, numbers);
        const BsdfInfo &info = bsdfInfo(material.bsdf.type);
        std::fill_n(lanes.scattersAlone, lanes.padded(), material.scattersAlone ? 1 : 0);
        std::fill_n(lanes.correlated, lanes.padded(), material.bsdf.correlated ? 1 : 0);
        if (info.microsurface || lanes.leans) setLambda(lanes, material.prepared->material->poisson);
        setLeans(lanes);
        if (material.layered) startCoat(lanes);
        if (info.microsurface) setMicrosurface(lanes, instructions);
        if (material.mapped) setFacets(lanes, material.prepared->material->facets, info.microsurface, instructions);
        if (!info.microsurface) return;
        roughen(lanes, *material.prepared->material);
        if (!material.scattersAlone) setView(lanes, material.bsdf.bearableWaste, info.refracts, instructions);
        if (material.layered) setCoat(lanes, material, instructions);
        if (!material.scattersAlone) setShares(lanes, material, instructions);
    });
}

void aim(HitLanes &l, const LaneMaterial &material, const LightTable &lights, int candidate) {
    const int candidates = candidateCount(lights);
    std::size_t lanesOfSky[HitLanes::kSize];
    std::size_t count = 0;
    const auto numbersOf = [&](std::size_t i) {
        return candidateNumbers({l.lightU[i], l.lightV[i], lights.choices > 1 ? l.lightChoice[i] : 0.0F}, candidate, candidates);
    };
    const auto receiver = [&](std::size_t i) { return receiverAt(l.position.at(i), l.geometricNormal.at(i), material.bsdf); };
    if (!lights.few) {
        l.lights.count = 0;
        for (std::size_t i = 0; i < static_cast<std::size_t>(l.padded()); ++i) l.lights.add(receiver(i), numbersOf(i).z);
        chooseByTree(lights, l.lights);
    }
    for (std::size_t i = 0; i < static_cast<std::size_t>(l.padded()); ++i) {
        const Vec3 u = numbersOf(i);
        const LightChoice choice = lights.few ? chooseLight(lights, receiver(i), u.z) : l.lights.chosen[i];
        l.lightEntry[i] = choice.entry;
        if (choice.entry != kNone && choice.entry == lights.environmentEntry) {
            l.sky.u[count] = u.x;
            l.sky.v[count] = u.y;
            l.lightPdf[i] = choice.probability;
            l.lightWeighted[i] = 1;
            l.lightDistance[i] = kInfinity;
            lanesOfSky[count++] = i;
            continue;
        }
        const LightSample light = sampleLight(lights, choice, l.position.at(i), l.time[i], Vec2(u));
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

void keep(HitLanes &l) {
    for (std::size_t i = 0; i < static_cast<std::size_t>(l.count); ++i) {
        if (!(l.connects[i] > 0) || !l.candidates[i].takes(luminance(l.contribution.at(i)))) continue;
        l.keptDirection.set(i, l.lightDirection.at(i));
        l.keptContribution.set(i, l.contribution.at(i));
        l.keptOrigin.set(i, l.shadowOrigin.at(i));
        l.keptDistance[i] = l.lightDistance[i];
        l.keptEntry[i] = l.lightEntry[i];
    }
}

void useKept(HitLanes &l, int candidates) {
    for (std::size_t i = 0; i < static_cast<std::size_t>(l.count); ++i) {
        const CandidateChoice &choice = l.candidates[i];
        l.connects[i] = choice.kept;
        if (!(choice.kept > 0)) continue;
        l.lightDirection.set(i, l.keptDirection.at(i));
        l.contribution.set(i, l.keptContribution.at(i) * choice.scale(candidates));
        l.shadowOrigin.set(i, l.keptOrigin.at(i));
        l.lightDistance[i] = l.keptDistance[i];
        l.lightEntry[i] = l.keptEntry[i];
    }
}

} // namespace lanes
} // namespace taut
