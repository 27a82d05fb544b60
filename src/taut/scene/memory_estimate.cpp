#include "taut/scene/memory_estimate.h"

#include "taut/scene/object_motion.h"
#include "taut/scene/rest_placement.h"

#include <algorithm>
#include <cmath>

namespace taut {

namespace {

constexpr double kObject = 4096;      ///< of an object without its mesh
constexpr double kTriangle = 260;     ///< indices, BVH while it is built, adjacency
constexpr double kVertex = 200;       ///< of the surface, and of a frame
constexpr double kStep = 80;          ///< of a vertex at each time within the shutter
constexpr double kMovedVertex = 160;  ///< that a vertex takes more where the mesh deforms: gradients, stencils
constexpr double kSkinInfluence = 24; ///< gradients of skin weights

/// Seconds on one core.
constexpr double kDeformPoint = 6e-8; ///< one deformer and its Jacobian
constexpr double kLightSeen = 2e-8;   ///< one light from one point, for the plan
constexpr double kNodePlaced = 2e-7;  ///< one node at one time

struct Counts {
    double triangles = 0;
    double vertices = 0;
};

Counts countsOf(const Object &object, int level) {
    const Mesh &mesh = *object.mesh;
    const auto corners = static_cast<double>(mesh.cornerCount());
    const auto faces = static_cast<double>(mesh.faceCount());
    if (level > 0) { // quads: a corner each at level 1
        const double quads = corners * std::pow(4.0, level - 1);
        return {2 * quads, 1.25 * quads + static_cast<double>(mesh.positions.size())};
    }
    const std::size_t most = std::max({mesh.positions.size(), mesh.normals.size(), mesh.uvs.size(), mesh.tangents.size()});
    const bool faceted = !object.smooth && mesh.normals.empty();
    return {corners - 2 * faces, faceted ? corners : std::min(1.5 * static_cast<double>(most), corners)};
}

double timesOf(const Object &object, const RenderSettings &render) {
    return render.shutter > 0 && moves(object) ? render.motionSteps : 1;
}

std::string placeOf(const Object &object) {
    return "mesh " + quoted(object.name);
}

std::string countOf(const Object &object, int level) {
    const Counts counts = countsOf(object, level);
    return formatNumber(std::ceil(counts.triangles)) + " triangles" + (level > 0 ? " at level " + std::to_string(level) : "");
}

int askedLevel(const Object &object) {
    return object.planLevel ? 0 : object.subdivision.level;
}

} // namespace

double objectBytes(const Object &object, const RenderSettings &render, int level) {
    const Counts counts = countsOf(object, level);
    const bool moved = deforms(object);
    const double times = deforms(object) ? timesOf(object, render) : 1;
    const double skin = kSkinInfluence * static_cast<double>(object.mesh->skin.joints.size());
    const double joints =
        object.rig && object.rig->rig->nodes[object.rig->node].skin != kNone
            ? sizeof(DMat4) * static_cast<double>(object.rig->rig->skins[object.rig->rig->nodes[object.rig->node].skin].joints.size())
            : 0;
    return kObject + 4 * static_cast<double>(object.name.size()) + joints + skin +
           sizeof(Emission) * static_cast<double>(object.materials.size()) + kTriangle * counts.triangles +
           counts.vertices * (kVertex + kStep * times + (moved ? kMovedVertex : 0)) + subdivisionBytes(*object.mesh, level);
}

void chargeObject(Budget &budget, const Object &object, const RenderSettings &render) {
    const double placements = placementsToCompare(object);
    budget.work(kNodePlaced * placements, placeOf(object), formatNumber(placements) + " placements of nodes that may change its shape");
    const int level = askedLevel(object);
    budget.take(objectBytes(object, render, level), placeOf(object), countOf(object, level));
    const double deformers = static_cast<double>(object.deformers.size() + object.mesh->morphs.size());
    budget.work(kDeformPoint * deformers * static_cast<double>(object.mesh->positions.size()) * timesOf(object, render), placeOf(object),
                formatNumber(deformers) + " deformers of " + std::to_string(object.mesh->positions.size()) + " points");
}

void chargeScene(const Scene &scene) {
    if (!scene.budget) return;
    constexpr std::size_t kPoints = 65; // of a box (plan/light_coverage.cpp)
    std::size_t uses = 0;
    for (const Object &object : scene.objects) uses += object.materials.size();
    const std::size_t lights = scene.lights.size();
    scene.budget->work(kLightSeen * static_cast<double>(uses) * static_cast<double>(lights) *
                           static_cast<double>(std::min(lights + 1, kPoints)),
                       scene.path, std::to_string(lights) + " lights over " + std::to_string(uses) + " materials of meshes");
}

int levelWithin(const Budget *budget, const Object &object, const RenderSettings &render, int most) {
    if (budget == nullptr) return most;
    int level = most;
    while (level > 1 && objectBytes(object, render, level) > budget->left()) --level;
    return level;
}

} // namespace taut
