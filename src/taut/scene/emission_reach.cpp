#include "taut/scene/emission_reach.h"

#include "taut/mesh/triangulate.h"
#include "taut/scene/material_gloss.h"
#include "taut/scene/object_motion.h"

#include <algorithm>

namespace taut {

namespace {

/// A white surface of this radiance is seen beside the display's white.
constexpr double kSeen = 0.05;
constexpr double kShareLit = 0.25;
constexpr std::size_t kEmitterSamples = 128;
constexpr std::size_t kReceiverSamples = 256;

struct Patch {
    DVec3 centre{0};
    DVec3 normal{0}; ///< unit
    double area = 0;
    double radiance = 0; ///< luminance, W / (m^2 sr)
    bool twoSided = false;
};

/// Mean luminance that a face emits: at its corners and its middle, where a texture says.
double radianceOf(const Scene &scene, const Emission &emission, const Mesh &mesh, std::size_t face) {
    if (emission.radiance.value == Vec3(0)) return 0;
    if (emission.radiance.texture == kNone || mesh.cornerUvs.empty()) return luminance(evaluate(emission.radiance, scene, Vec2(0)));
    const Index begin = mesh.faceOffsets[face];
    const Index end = mesh.faceOffsets[face + 1];
    UvPoint middle;
    float sum = 0;
    for (Index c = begin; c < end; ++c) {
        const Index uv = mesh.cornerUvs[c];
        if (uv == kNone) continue;
        UvPoint corner(mesh.uvs[uv]);
        if (!mesh.uvs1.empty()) corner.second = mesh.uvs1[uv];
        sum += luminance(evaluate(emission.radiance, scene, corner));
        middle.first += corner.first / static_cast<float>(end - begin);
        middle.second += corner.second / static_cast<float>(end - begin);
    }
    return (sum + luminance(evaluate(emission.radiance, scene, middle))) / static_cast<float>(end - begin + 1);
}

void addPatches(const Scene &scene, const Object &object, std::vector<Patch> &patches) {
    const Mesh &mesh = *object.mesh;
    ObjectMotion motion;
    motionAtFrame(object, scene.render.frames.front(), scene.render.fps, DMat4(1), motion);
    std::vector<Vec3> points;
    evaluatePositions(motion.state, mesh.skin, points);
    std::vector<Vec3> polygon;
    for (std::size_t face = 0; face < mesh.faceCount(); ++face) {
        polygon.clear();
        Patch patch;
        for (Index c = mesh.faceOffsets[face]; c < mesh.faceOffsets[face + 1]; ++c) {
            polygon.push_back(points[mesh.cornerPositions[c]]);
            patch.centre += DVec3(polygon.back());
        }
        patch.centre /= static_cast<double>(polygon.size());
        const DVec3 doubleArea = DVec3(polygonNormal(polygon)) * (motion.state.mirrored ? -1.0 : 1.0);
        patch.area = 0.5 * glm::length(doubleArea);
        if (!(patch.area > 0) || !std::isfinite(patch.area)) continue;
        patch.normal = doubleArea / (2 * patch.area);
        const Emission emission = emissionOf(object, mesh.faceMaterials.empty() ? 0 : mesh.faceMaterials[face]);
        patch.radiance = radianceOf(scene, emission, mesh, face);
        patch.twoSided = emission.twoSided;
        patches.push_back(patch);
    }
}

/// `count` of the patches, each as often as its share of the whole weight says, evenly spaced along the running sum.
template <class Weight> std::vector<const Patch *> spread(const std::vector<Patch> &patches, std::size_t count, const Weight &weight) {
    double total = 0;
    for (const Patch &patch : patches) total += weight(patch);
    std::vector<const Patch *> chosen;
    double sum = 0;
    for (const Patch &patch : patches) {
        sum += weight(patch);
        while (chosen.size() < count && sum > (static_cast<double>(chosen.size()) + 0.5) / static_cast<double>(count) * total)
            chosen.push_back(&patch);
    }
    return chosen;
}

} // namespace

bool emissionLights(const Scene &scene) {
    if (std::none_of(scene.objects.begin(), scene.objects.end(), emits)) return false;
    std::vector<Patch> patches;
    for (const Object &object : scene.objects) addPatches(scene, object, patches);
    const auto power = [](const Patch &p) { return p.radiance * p.area; };
    const std::vector<const Patch *> emitters = spread(patches, kEmitterSamples, power);
    const std::vector<const Patch *> receivers =
        spread(patches, kReceiverSamples, [](const Patch &p) { return p.radiance > 0 ? 0 : p.area; });
    if (emitters.empty() || receivers.empty()) return false;
    double total = 0;
    for (const Patch &patch : patches) total += power(patch);
    std::size_t lit = 0;
    for (const Patch *to : receivers) {
        double irradiance = 0;
        for (const Patch *from : emitters) {
            const DVec3 d = to->centre - from->centre;
            const double distance2 = glm::dot(d, d);
            if (!(distance2 > 0)) continue;
            const double leaving = glm::dot(d, from->normal);
            const double arriving = std::fabs(glm::dot(d, to->normal));
            const double cosines = (from->twoSided ? std::fabs(leaving) : std::max(leaving, 0.0)) * arriving / distance2;
            irradiance += cosines / (distance2 + from->area / glm::pi<double>()); // a disk, not a point
        }
        irradiance *= total / static_cast<double>(emitters.size());
        lit += irradiance / glm::pi<double>() > kSeen ? 1 : 0;
    }
    return static_cast<double>(lit) >= kShareLit * static_cast<double>(receivers.size());
}

} // namespace taut
