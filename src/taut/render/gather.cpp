#include "taut/render/aov.h"
#include "taut/render/facet.h"
#include "taut/render/path_state.h"

namespace taut {

namespace {

/// Asks memory for the texels of a lookup to come: a texture is larger than the caches.
void prefetchTexels(const Texture &texture, const UvPoint &point) {
    const BilinearPlace at = bilinearPlace(texture.sampler, point.set(texture.sampler.uvSet), texture.width, texture.height);
    for (const int row : at.row) {
        const auto texel = static_cast<std::size_t>(row) * static_cast<std::size_t>(texture.width) + static_cast<std::size_t>(at.column[0]);
        __builtin_prefetch(&texture.texels[texel * static_cast<std::size_t>(texture.channels)]);
    }
}

} // namespace

/// Puts a hit aside to be shaded with others, where its mesh and material let it.
bool PathTracer::State::waits(int event, std::size_t i) {
    const Hit &hit = hits[i];
    const Index owner = scene.objectOfGeometry(hit.geometry);
    if (laneObjects[owner] == LaneObject::Alone) return false;
    const RenderObject &object = scene.objects()[owner];
    const Index material = materialOfTriangle(object, hit.primitive);
    const LaneMaterial &lane = laneMaterials[material];
    if (!lane.inLanes || (laneObjects[owner] == LaneObject::Stored && (lane.mapped || lane.coatMapped))) return false;
    if (event >= settings.maxEvents && (event == 0 || mayEmit(object, hit.primitive))) return false;
    if (event == 0) paths[active[i]].alpha = 1;
    if (event >= settings.maxEvents) return true; // nothing is left to do
    waiting[material].push_back(static_cast<Index>(i));
    __builtin_prefetch(&object.surface.triangles[hit.primitive]);
    return true;
}

/// Asks memory for the corners of hit i: they lie anywhere.
void PathTracer::State::prefetch(std::size_t i) const {
    const RenderObject &object = scene.objects()[scene.objectOfGeometry(hits[i].geometry)];
    const SurfaceStep &step = object.steps.front();
    const Index3 t = object.surface.triangles[hits[i].primitive];
    for (int k = 0; k < 3; ++k) {
        __builtin_prefetch(&step.positions[t[k]]);
        __builtin_prefetch(&step.normals[t[k]]);
        __builtin_prefetch(&step.tangents[t[k]]);
        if (step.stretch.size() > 1 && !object.stretchOnFaces()) __builtin_prefetch(&step.stretch[t[k]]);
    }
}

/// The surface at hit i, from its corners.
template <bool kStill> void PathTracer::State::gatherSurface(std::size_t lane, std::size_t i, bool isPlain) {
    HitLanes &l = *lanes;
    const RenderObject &object = scene.objects()[scene.objectOfGeometry(hits[i].geometry)];
    const HitCorners<kStill> corners(object, hits[i], paths[active[i]].time);
    const InterpolatedSurface p = corners.surface();
    l.position.set(lane, p.position);
    l.e1.set(lane, p.e1);
    l.e2.set(lane, p.e2);
    l.normal.set(lane, p.normal);
    l.tangent.set(lane, Vec3(p.tangent));
    l.tangentSense[lane] = p.tangent.w;
    l.corners[lane] = p.corners;
    const bool deforms = isPlain && !corners.step().stretch.empty();
    const SymmetricTensor v = deforms ? corners.stretch() : SymmetricTensor{};
    l.diagonal.set(lane, v.diagonal);
    l.offDiagonal.set(lane, v.offDiagonal);
    l.deforms[lane] = deforms ? 1 : 0;
    l.other[lane] = isPlain ? 0 : 1;
    if constexpr (!kStill) {
        if (isPlain) return;
        const HitDeformation d = deformationAt(object, corners, surfaceGeometry(p, -rays[i].direction));
        l.hasOthers = true;
        l.leans |= object.object->lean;
        l.otherStretch[lane] = d.stretch;
        l.otherTangent[lane] = d.tangent;
        const bool stored = !object.storedPoisson.empty();
        l.otherLean[lane] = stored ? Vec2(0) : d.lean;
        l.followsPoisson[lane] = object.object->lean || stored ? 0 : 1;
        l.strain[lane] = d.strain;
        l.stored[lane] = stored ? 1 : 0;
    }
}

/// What lane `lane` needs of hit i.
void PathTracer::State::gather(std::size_t lane, std::size_t i) {
    HitLanes &l = *lanes;
    const Index owner = scene.objectOfGeometry(hits[i].geometry);
    if (laneObjects[owner] == LaneObject::Still)
        gatherSurface<true>(lane, i, true);
    else
        gatherSurface<false>(lane, i, laneObjects[owner] == LaneObject::Moving);
    l.wo.set(lane, -rays[i].direction);
    const Path &path = paths[active[i]];
    l.throughput.set(lane, path.throughput);
    l.etaScale[lane] = path.etaScale;
    l.time[lane] = path.time;
    l.sample[lane] = path.sample;
    l.seed[lane] = path.seed;
    l.path[lane] = active[i];
}

/// Of hit i, the corners of its triangle gathered in `lane`.
MeshValues PathTracer::State::meshValuesOf(std::size_t lane, std::size_t i, const PreparedMaterial &prepared) const {
    const HitLanes &l = *lanes;
    InterpolatedSurface at;
    at.e1 = l.e1.at(lane);
    at.e2 = l.e2.at(lane);
    const float coneWidth = hasCones && prepared.filters ? paths[active[i]].cone.widthAt(hits[i].t) : 0.0F;
    return meshValuesAt(scene.objects()[scene.objectOfGeometry(hits[i].geometry)], hits[i], at, l.wo.at(lane), coneWidth);
}

/// The material's values in all lanes, textures looked up; memory is asked for their texels before the first is read.
void PathTracer::State::lookUp(const LaneMaterial &material, std::span<const Index> chunk) {
    HitLanes &l = *lanes;
    const PreparedMaterial &prepared = *material.prepared;
    const Material &m = *prepared.material;
    const Scene &from = scene.scene();
    const bool glossy = bsdfInfo(m.type).microsurface;
    const auto padded = static_cast<std::size_t>(l.padded());
    for (std::size_t k = 0; k < padded; ++k) {
        meshValues[k] = meshValuesOf(k, chunk[k < chunk.size() ? k : 0], prepared);
        if (m.color.texture != kNone) prefetchTexels(from.textures[m.color.texture], meshValues[k].uv);
        if (material.mapped) prefetchTexels(from.textures[m.slopes.texture], meshValues[k].uv);
    }
    for (std::size_t k = 0; k < padded; ++k) {
        const UvPoint &uv = meshValues[k].uv;
        const float metallic = m.metallic.texture == kNone ? material.values.metallic : evaluateShare(m.metallic, from, uv);
        lanes::setValues(l, k, baseColorAt(m, from, meshValues[k]), metallic, glossy ? restRoughness(m, from, uv) : material.rest);
    }
    if (material.layered) {
        if (!l.coat) l.coat = std::make_unique<HitLanes>();
        for (std::size_t k = 0; k < padded; ++k) {
            const UvPoint &uv = meshValues[k].uv;
            l.specular[k] = evaluateShare(m.specular, from, uv);
            l.specularColor.set(k, evaluate(m.specularColor, from, uv));
            l.clearcoat[k] = evaluateShare(m.clearcoat, from, uv);
            const float alpha = coatAlpha(m, from, uv);
            lanes::setValues(*l.coat, k, Vec3(0), 0, {alpha, alpha, 0});
        }
        lookUpSlopes(m.coatSlopes, chunk, *l.coat);
    }
    lookUpSlopes(m.slopes, chunk, l);
}

/// A map's slopes in all lanes of `into`.
void PathTracer::State::lookUpSlopes(const SlopeMap &map, std::span<const Index> chunk, HitLanes &into) {
    if (!map.isGiven()) return;
    const HitLanes &l = *lanes;
    for (std::size_t k = 0; k < static_cast<std::size_t>(l.padded()); ++k) {
        const Hit &hit = hits[chunk[k < chunk.size() ? k : 0]];
        const RenderObject &object = scene.objects()[scene.objectOfGeometry(hit.geometry)];
        InterpolatedSurface at;
        at.normal = l.normal.at(k);
        at.tangent = Vec4(l.tangent.at(k), l.tangentSense[k]);
        const Index3 &corners = object.surface.triangles[hit.primitive];
        lanes::setSlopes(into, k, slopesAt(map, {scene.scene(), object, corners, meshValues[k].uv, at}));
    }
}

/// What the hits' triangles emit towards their paths.
void PathTracer::State::seeEmissions(const LaneMaterial &material, std::span<const Index> chunk) {
    const HitLanes &l = *lanes;
    for (std::size_t k = 0; k < chunk.size(); ++k) {
        const Hit &hit = hits[chunk[k]];
        const RenderObject &object = scene.objects()[scene.objectOfGeometry(hit.geometry)];
        if (!mayEmit(object, hit.primitive)) continue;
        const UvPoint uv = material.varies ? meshValues[k].uv : meshValuesOf(k, chunk[k], *material.prepared).uv;
        const Vec3 emission = emissionAt(object, hit.primitive, scene.scene(), l.facing[k], uv);
        if (emission != Vec3(0)) seeEmission(paths[l.path[k]], rays[chunk[k]], hit, l.geometricNormal.at(k), emission);
    }
}

/// A lane that scatters by itself: what that asks for.
SurfacePoint PathTracer::State::pointOf(std::size_t lane, const LaneMaterial &material) const {
    const HitLanes &l = *lanes;
    const PreparedMaterial &prepared = *material.prepared;
    const UvPoint uv = material.varies ? meshValues[lane].uv : UvPoint();
    SurfacePoint point;
    point.position = l.position.at(lane);
    point.geometricNormal = l.geometricNormal.at(lane);
    point.clearance = l.clearance[lane];
    point.facet = Frame(l.s.at(lane), l.t.at(lane), l.n.at(lane));
    point.tilted = l.leans && l.tilted[lane] != 0;
    point.bsdf = bsdfOf(prepared, valuesAt(prepared, scene.scene(), l.color.at(lane), uv), l.facing[lane]);
    if (point.bsdf.refracts && l.facing[lane] > 0) point.extinction = prepared.extinction;
    if (!bsdfInfo(prepared.material->type).microsurface) return point;
    point.bsdf.micro = l.micro(lane);
    point.bsdf.multiscatter = treatmentAt(prepared, point.bsdf.metallic, point.bsdf.micro, point.tilted);
    if (!(point.bsdf.coat > 0)) return point;
    const HitLanes &coat = *l.coat;
    point.bsdf.coatMicro = coat.micro(lane);
    point.bsdf.coatTilted = coat.tilted[lane] != 0;
    point.bsdf.coatFrame = Frame(coat.s.at(lane), coat.t.at(lane), coat.n.at(lane));
    return point;
}

/// AOVs of first hits, from what the lanes hold of them: what surfacePointAt() would say.
void PathTracer::State::writeAovsAtOnce(const LaneMaterial &material, std::span<const Index> chunk, const FirstHitOutputs &outputs) {
    const HitLanes &l = *lanes;
    const bool glossy = bsdfInfo(material.bsdf.type).microsurface;
    SurfacePoint point;
    for (std::size_t k = 0; k < chunk.size(); ++k) {
        const Hit &hit = hits[chunk[k]];
        const RenderObject &object = scene.objects()[scene.objectOfGeometry(hit.geometry)];
        Path &path = paths[l.path[k]];
        const HitCorners<false> corners(object, hit, path.time);
        InterpolatedSurface at;
        at.position = l.position.at(k);
        at.e1 = l.e1.at(k);
        at.e2 = l.e2.at(k);
        at.normal = l.normal.at(k);
        at.tangent = Vec4(l.tangent.at(k), l.tangentSense[k]);
        at.corners = l.corners[k];
        const SurfaceGeometry geometry = surfaceGeometry(at, l.wo.at(k));
        point.position = at.position;
        point.geometricNormal = l.geometricNormal.at(k);
        point.frame = Frame(geometry.s, geometry.t, geometry.n);
        point.facet = Frame(l.s.at(k), l.t.at(k), l.n.at(k));
        point.tilted = l.leans && l.tilted[k] != 0;
        point.stretch = l.stretch.at(k);
        point.tangent = {l.tangentX[k], l.tangentY[k]};
        point.uv = material.varies ? meshValues[k].uv : meshValuesOf(k, chunk[k], *material.prepared).uv;
        point.baseColor = l.color.at(k);
        point.object = &object;
        point.corners = corners.corners();
        point.barycentrics = corners.barycentrics();
        if (glossy) point.bsdf.micro = l.micro(k);
        path.hasAovs = true;
        writeAovs(scene, point, outputs.aovs, &aovs[l.path[k] * outputs.channels]);
    }
}

/// Samples lights from all lanes.
void PathTracer::State::connectAtOnce(int event, const LaneMaterial &material) {
    HitLanes &l = *lanes;
    const int candidates = candidateCount(scene.lights());
    if (candidates == 1) {
        lanes::aim(l, material, scene.lights());
        lanes::connect(l, material);
        return;
    }
    for (std::size_t k = 0; k < static_cast<std::size_t>(l.count); ++k)
        l.candidates[k] = {random1(paths[l.path[k]], dimensionOf(event, kCandidate))};
    for (int candidate = 0; candidate < candidates; ++candidate) {
        lanes::aim(l, material, scene.lights(), candidate);
        lanes::connect(l, material);
        lanes::keep(l);
    }
    lanes::useKept(l, candidates);
}

void PathTracer::State::shadeAtOnce(int event, const LaneMaterial &material, std::span<const Index> chunk, const FirstHitOutputs &outputs) {
    HitLanes &l = *lanes;
    l.count = static_cast<int>(chunk.size());
    l.leans = material.mapped || material.layered;
    l.hasOthers = false;
    const auto padded = static_cast<std::size_t>(l.padded());
    for (const Index i : chunk) prefetch(i);
    for (std::size_t k = 0; k < padded; ++k) gather(k, chunk[k < chunk.size() ? k : 0]);
    if (material.varies)
        lookUp(material, chunk);
    else
        lanes::setValues(l, material);
    const EventNumbers numbers{dimensionOf(event, kScatterNumbers), dimensionOf(event, kLightNumbers), dimensionOf(event, kRoulette),
                               scene.lights().choices};
    const bool lit = numbers.lights > 0;
    lanes::view(l, material, numbers);
    if (event == 0 && outputs.channels > 0) writeAovsAtOnce(material, chunk, outputs);
    if (hasEmitters) seeEmissions(material, chunk);
    if (!l.allAlone()) {
        if (lit) connectAtOnce(event, material);
        lanes::scatter(l, material);
    }
    const bool glossy = bsdfInfo(material.bsdf.type).microsurface;
    for (std::size_t k = 0; k < chunk.size(); ++k) {
        if (l.scattersAlone[k] != 0) {
            scatter(event, l.path[k], pointOf(k, material), l.wo.at(k), hits[chunk[k]].t);
            continue;
        }
        Path &path = paths[l.path[k]];
        if (lit && l.connects[k] > 0) {
            shadowRays.push_back(shadowRay(l.shadowOrigin.at(k), l.position.at(k), l.lightDirection.at(k), l.lightDistance[k], path.time));
            Vec3 contribution = l.contribution.at(k);
            if (hasMedia) attenuate(path, glm::dot(l.lightDirection.at(k), l.geometricNormal.at(k)), l.lightDistance[k], contribution);
            shadowTests.push_back({l.path[k], contribution});
            if (hasGroups()) shadowGroups.push_back(groupOfEntry(l.lightEntry[k]));
        }
        if (!(l.goesOn[k] > 0)) continue;
        path.throughput = l.nextThroughput.at(k);
        path.etaScale = l.nextEtaScale[k];
        path.scatterPdf = l.scatterPdf[k];
        path.normal = receiverAt(l.position.at(k), l.geometricNormal.at(k), material.bsdf).normal;
        if (hasCones) path.cone.scatter(hits[chunk[k]].t, glossy ? 1 / std::sqrt(l.det[k]) : 1.0F);
        Ray next;
        next.origin = l.nextOrigin.at(k);
        next.direction = l.nextDirection.at(k);
        next.time = path.time;
        nextRays.push_back(next);
        stillActive.push_back(l.path[k]);
    }
}

} // namespace taut
