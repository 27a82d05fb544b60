#include "taut/plan/light_coverage.h"

#include "taut/bsdf/bsdf_types.h"
#include "taut/mesh/topology.h"
#include "taut/scene/object_motion.h"

#include <algorithm>
#include <cmath>
#include <optional>

namespace taut {

namespace {

constexpr float kHemisphere = 2 * kPi;
/// Rejected samples that never pay for the cone: other noise, of edges and textures, is more.
constexpr float kLeastWaste = 0.005F;

SeenLight seenFrom(const Vec3 &point, const PlacedLight &light) {
    const LightOutline &outline = light.outline;
    const Vec3 d = point - outline.centre;
    const float distance2 = glm::dot(d, d);
    const float cosine = distance2 > 0 && outline.normal != Vec3(0) ? glm::dot(d, outline.normal) / std::sqrt(distance2) : 1.0F;
    if (cosine < outline.cosOuter) return {};
    if (outline.radius == 0) return {light.radiance / std::fmax(distance2, 1e-12F), 0};
    // 2 pi (1 - cos of the half angle), without cancellation.
    const float share = sqr(outline.radius) / (distance2 + sqr(outline.radius));
    const float angle = kHemisphere * share / (1 + std::sqrt(1 - share)) * cosine; // a disk from the side is narrower
    return {light.radiance * angle, angle};
}

/// The radiance of the sky over the hemisphere, and how unevenly it is spread.
SeenLight skyLight(const Environment &sky) {
    const float mean = luminance(sky.mean);
    return mean > 0 ? SeenLight{kHemisphere * mean, kHemisphere * sky.coverage} : SeenLight{};
}

/// The greatest luminance that a material slot of an object emits.
float strongest(const Object &object) {
    float greatest = 0;
    for (Index slot = 0; slot < std::max<std::size_t>(object.slotEmission.size(), 1); ++slot)
        greatest = std::max(greatest, luminance(emissionOf(object, slot).radiance.value));
    return greatest;
}

} // namespace

float coverageOf(std::span<const SeenLight> lights, float blur) {
    double sum = 0;
    double squares = 0;
    for (const SeenLight &light : lights) {
        if (!(light.irradiance > 0)) continue;
        const auto e = static_cast<double>(light.irradiance);
        const float angle = std::fmin(std::fmax(std::fmax(light.solidAngle, blur), 1e-6F), kHemisphere);
        sum += e;
        squares += e * e / static_cast<double>(angle);
    }
    return squares > 0 ? static_cast<float>(std::min(1.0, sum * sum / (static_cast<double>(kHemisphere) * squares))) : 1.0F;
}

SceneLights lightsOf(const Scene &scene, double frame) {
    SceneLights lights;
    if (scene.environment) lights.distant.push_back(skyLight(*scene.environment));
    for (const Light &light : scene.lights) {
        const float strength = luminance(light.radiance);
        std::visit(
            [&](const auto &shape) {
                if constexpr (requires { shape.outline(); }) {
                    if (const std::optional<LightOutline> outline = shape.outline()) lights.placed.push_back({*outline, strength});
                } else {
                    lights.distant.push_back({strength, 0});
                }
            },
            light.shape);
    }
    for (const Object &object : scene.objects) {
        if (!emits(object)) continue;
        const Bounds box = worldBounds(object, frame, scene.render.fps);
        if (!box.empty()) lights.placed.push_back({{box.centre(), 0.5F * box.diagonal(), Vec3(0), 0}, strongest(object)});
    }
    return lights;
}

float bearableWasteUnder(const Scene &scene) {
    const bool isSkyAlone = scene.environment && scene.lights.empty() && std::none_of(scene.objects.begin(), scene.objects.end(), emits);
    return isSkyAlone ? std::max(kLeastWaste, kBearableWaste * (1 - scene.environment->coverage)) : kBearableWaste;
}

float lightCoverage(const SceneLights &lights, const Bounds &box, float blur) {
    std::vector<Vec3> points{box.centre()};
    constexpr std::size_t kMost = 64; // more of them light a box evenly, and would take long
    for (const PlacedLight &light : std::span(lights.placed).first(std::min(kMost, lights.placed.size())))
        points.push_back(glm::clamp(light.outline.centre, box.lower, box.upper));
    float greatest = 0;
    for (const Vec3 &point : points) {
        std::vector<SeenLight> seen = lights.distant;
        for (const PlacedLight &light : lights.placed) seen.push_back(seenFrom(point, light));
        greatest = std::fmax(greatest, coverageOf(seen, blur));
    }
    return greatest;
}

Bounds worldBounds(const Object &object, double frame, double fps) {
    ObjectMotion motion;
    motionAtFrame(object, frame, fps, DMat4(1), motion);
    std::vector<Vec3> points;
    evaluatePositions(motion.state, object.mesh->skin, points);
    return boundsOf(pointsOfFaces(*object.mesh, points));
}

} // namespace taut
