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
bool PathTracer::State::waits(int event, std::size_t i, int aovChannels) {
    const Hit &hit = hits[i];
    const Index owner = scene.objectOfGeometry(hit.geometry);
    if (plainObjects[owner] == 0 || (event == 0 && aovChannels > 0)) return false;
    const RenderObject &object = scene.objects()[owner];
    const Index material = materialOfTriangle(object, hit.primitive);
    if (!laneMaterials[material].inLanes) return false;
    if (event == 0) paths[active[i]].alpha = 1;
    if (event >= settings.maxEvents) return true;
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

/// What lane `lane` needs of hit i.
void PathTracer::State::gather(std::size_t lane, std::size_t i) {
    HitLanes &l = *lanes;
    const HitCorners<true> corners(scene.objects()[scene.objectOfGeometry(hits[i].geometry)], hits[i], 0);
    const InterpolatedSurface p = corners.surface();
    l.position.set(lane, p.position);
    l.e1.set(lane, p.e1);
    l.e2.set(lane, p.e2);
    l.normal.set(lane, p.normal);
    l.tangent.set(lane, Vec3(p.tangent));
    l.tangentSense[lane] = p.tangent.w;
    l.corners[lane] = p.corners;
    const bool deforms = !corners.step().stretch.empty();
    const SymmetricTensor v = deforms ? corners.stretch() : SymmetricTensor{};
    l.diagonal.set(lane, v.diagonal);
    l.offDiagonal.set(lane, v.offDiagonal);
    l.deforms[lane] = deforms ? 1 : 0;
    l.wo.set(lane, -rays[i].direction);
    const Path &path = paths[active[i]];
    l.throughput.set(lane, path.throughput);
    l.etaScale[lane] = path.etaScale;
    l.time[lane] = path.time;
    l.sample[lane] = path.sample;
    l.seed[lane] = path.seed;
    l.path[lane] = active[i];
}

/// The material's values in all lanes, textures looked up; memory is asked for their texels before the first is read.
void PathTracer::State::lookUp(const LaneMaterial &material, std::span<const Index> chunk) {
    HitLanes &l = *lanes;
    const PreparedMaterial &prepared = *material.prepared;
    const Material &m = *prepared.material;
    const Scene &from = scene.scene();
    const bool glossy = bsdfInfo(m.type).microsurface;
    const auto padded = static_cast<std::size_t>(l.padded());
    MeshValues mesh[HitLanes::kSize];
    for (std::size_t k = 0; k < padded; ++k) {
        const Index i = chunk[k < chunk.size() ? k : 0];
        InterpolatedSurface at;
        at.e1 = l.e1.at(k);
        at.e2 = l.e2.at(k);
        const float coneWidth = hasCones && prepared.filters ? paths[active[i]].cone.widthAt(hits[i].t) : 0.0F;
        mesh[k] = meshValuesAt(scene.objects()[scene.objectOfGeometry(hits[i].geometry)], hits[i], at, l.wo.at(k), coneWidth);
        if (m.color.texture != kNone) prefetchTexels(from.textures[m.color.texture], mesh[k].uv);
    }
    for (std::size_t k = 0; k < padded; ++k) {
        const float metallic = m.metallic.texture == kNone ? material.values.metallic : evaluateShare(m.metallic, from, mesh[k].uv);
        lanes::setValues(l, k, baseColorAt(m, from, mesh[k]), metallic, glossy ? restRoughness(m, from, mesh[k].uv) : material.rest);
    }
}

void PathTracer::State::shadeAtOnce(int event, const LaneMaterial &material, std::span<const Index> chunk) {
    HitLanes &l = *lanes;
    l.count = static_cast<int>(chunk.size());
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
    if (lit) lanes::aim(l, scene.lights());
    if (lit) lanes::connect(l, material);
    lanes::scatter(l, material);
    const bool glossy = bsdfInfo(material.bsdf.type).microsurface;
    for (std::size_t k = 0; k < chunk.size(); ++k) {
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
