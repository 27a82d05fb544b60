#include "taut/render/aov.h"
#include "taut/render/path_state.h"
#include "taut/render/roulette.h"

namespace taut {

namespace {

/// A light sample and what it brings unoccluded.
struct Connection {
    LightSample light;
    Vec3 contribution{0};
    float side = 0; ///< of the surface
    Index entry = kNone;
};

} // namespace

/// Samples a light from the point: of several, one.
void PathTracer::State::connectLight(int event, Index index, const SurfacePoint &point, const FacetScattering &scattering) {
    Path &path = paths[index];
    const Vec3 u = random3(path, dimensionOf(event, kLightNumbers));
    const Receiver receiver = receiverAt(point.position, point.geometricNormal, point.bsdf);
    const int candidates = candidateCount(scene.lights());
    CandidateChoice choice{candidates > 1 ? random1(path, dimensionOf(event, kCandidate)) : 0.0F};
    Connection kept;
    for (int candidate = 0; candidate < candidates; ++candidate) {
        const Vec3 numbers = candidateNumbers(u, candidate, candidates);
        const LightChoice chosen = chooseLight(scene.lights(), receiver, numbers.z);
        const LightSample light = sampleLight(scene.lights(), chosen, point.position, path.time, Vec2(numbers));
        if (!(light.pdf > 0)) continue;
        const float side = glm::dot(light.direction, point.geometricNormal);
        if (!scattering.mayLeave(light.direction, side > 0)) continue;
        Vec3 contribution(0);
        scattering.forEachPart(light.direction, walkNumbers(path, point, event), [&](const BsdfEval &part) {
            if (!(part.pdf > 0)) return;
            const float weight = light.delta ? 1.0F : powerHeuristic(light.pdf, part.pdf);
            contribution += path.throughput * part.fCos * light.radiance * (weight / light.pdf);
        });
        if (!(maxComponent(contribution) > 0) || (candidates > 1 && !choice.takes(luminance(contribution)))) continue;
        kept = {light, contribution, side, chosen.entry};
    }
    if (candidates > 1 && choice.kept > 0) kept.contribution *= choice.scale(candidates);
    attenuate(path, kept.side, kept.light.distance, kept.contribution);
    if (!(maxComponent(kept.contribution) > 0)) return;
    shadowRays.push_back(
        shadowRay(offsetOrigin(point, kept.side > 0), point.position, kept.light.direction, kept.light.distance, path.time));
    shadowTests.push_back({index, kept.contribution});
    if (hasGroups()) shadowGroups.push_back(groupOfEntry(kept.entry));
}

/// What a hit's triangle emits towards the path, weighed against light samples.
void PathTracer::State::seeEmission(Path &path, const Ray &ray, const Hit &hit, const Vec3 &geometricNormal, const Vec3 &emission) {
    const Index owner = scene.objectOfGeometry(hit.geometry);
    const LightPart part = scene.lightPartOf(owner, hit.primitive);
    float weight = 1;
    if (path.scatterPdf > 0 && part.entry != kNone) {
        const float cosine = std::fabs(glm::dot(geometricNormal, ray.direction));
        weight = powerHeuristic(path.scatterPdf, emitterHitPdf(scene.lights(), part, path.receiver(ray.origin), path.time, hit.t, cosine));
    }
    addLight(path, path.throughput * emission * weight, [&] { return groupOf(owner, hit.primitive); });
}

void PathTracer::State::shade(int event, Index index, const Ray &ray, const Hit &hit, const FirstHitOutputs &outputs) {
    Path &path = paths[index];
    const float coneWidth = hasCones ? path.cone.widthAt(hit.t) : 0.0F;
    const SurfacePoint point = surfacePointAt(scene, materials, hit, -ray.direction, path.time, coneWidth);
    if (path.scatterPdf == 0) {
        path.alpha = 1;
        path.hasAovs = true;
        if (outputs.channels > 0) writeAovs(scene, point, outputs.aovs, &aovs[index * outputs.channels]);
    }
    if (point.emission != Vec3(0)) seeEmission(path, ray, hit, point.geometricNormal, point.emission);
    if (!point.scatters)
        addLight(path, path.throughput * point.baseColor, [&] { return groupOf(scene.objectOfGeometry(hit.geometry), hit.primitive); });
    if (event < settings.maxEvents && point.scatters) scatter(event, index, point, -ray.direction, hit.t);
}

/// Samples a light from the point and the path's next ray, `distance` from where it comes from.
void PathTracer::State::scatter(int event, Index index, const SurfacePoint &point, const Vec3 &wo, float distance) {
    Path &path = paths[index];
    const FacetScattering scattering(point.bsdf, point.facet, point.tilted ? &point.geometricNormal : nullptr, wo);
    connectLight(event, index, point, scattering);

    const Vec3 u = random3(path, dimensionOf(event, kScatterNumbers));
    const auto sampled = scattering.sample(Vec2(u), u.z, walkSeed(path, point, dimensionOf(event, kScatterNumbers)));
    if (!sampled) return;
    const Vec3 direction = glm::normalize(sampled->wi);
    const float side = glm::dot(direction, point.geometricNormal);
    if ((side > 0) == sampled->transmitted) return;
    path.throughput *= sampled->weight;
    path.etaScale *= sampled->etaScale;
    path.scatterPdf = sampled->pdf;
    path.normal = receiverAt(point.position, point.geometricNormal, point.bsdf).normal;
    if (hasCones) path.cone.scatter(distance, bsdfInfo(point.bsdf.type).microsurface ? 1 / std::sqrt(point.bsdf.micro.det) : 1.0F);
    if (sampled->transmitted && point.bsdf.refracts) path.extinction = point.extinction; // none beyond a back face
    const float chance = chanceToGoOn(path.throughput, path.etaScale);
    if (!(random1(path, dimensionOf(event, kRoulette)) < chance)) return;
    path.throughput *= 1 / chance;
    Ray next;
    next.origin = offsetOrigin(point, side > 0);
    next.direction = direction;
    next.time = path.time;
    nextRays.push_back(next);
    stillActive.push_back(index);
}

} // namespace taut
