#include "taut/plan/bvh_question.h"

#include <algorithm>

namespace taut {

namespace {

/// Frames that a forecast looks at, about.
constexpr std::size_t kForecastFrames = 16;

} // namespace

bool refitsPay(std::span<const DeformingMesh> meshes, double rays, const BvhCosts &costs) {
    double refits = costs.refittable * rays * costs.ray;
    double builds = 0;
    for (const DeformingMesh &mesh : meshes) {
        const auto triangles = static_cast<double>(mesh.triangles);
        builds += (costs.refit + costs.build) * triangles;
        refits += (costs.refit + (mesh.blurred ? costs.build : 0)) * triangles;
    }
    return refits < builds;
}

std::size_t triangleCount(const Object &object, int subdivisionLevel) {
    const Mesh &mesh = *object.mesh;
    if (subdivisionLevel == 0) return mesh.cornerCount() - 2 * mesh.faceCount();
    const std::size_t finer = std::size_t{1} << (2 * static_cast<std::size_t>(subdivisionLevel - 1));
    return object.subdivision.scheme == SubdivisionScheme::Loop ? 4 * finer * mesh.faceCount() : 2 * finer * mesh.cornerCount();
}

BvhKind chooseBvh(const Scene &scene, std::span<const int> levels, const BvhCosts &costs) {
    std::vector<DeformingMesh> meshes;
    for (std::size_t i = 0; i < scene.objects.size(); ++i) {
        const Object &object = scene.objects[i];
        const bool blurred = scene.render.shutter > 0 && scene.render.motionSteps > 1 && moves(object);
        if (deforms(object)) meshes.push_back({triangleCount(object, levels[i]), blurred});
    }
    return refitsPay(meshes, raysPerFrame(scene.render), costs) ? BvhKind::Refit : BvhKind::Rebuild;
}

std::size_t BvhForecast::stride(std::size_t frames) {
    return std::max<std::size_t>(1, frames / kForecastFrames);
}

void BvhForecast::add(const ObjectSurface &object) {
    const Surface &surface = object.surface;
    const std::vector<Index3> &triangles = surface.triangles;
    positions_.resize(surface.vertexCount() + 1);
    for (std::size_t v = 0; v < surface.vertexCount(); ++v) positions_[v] = object.gradient.position[surface.vertexSurface[v]];
    bool build = frames_ < 0;
    if (!build) {
        const double refit = policy_.refitSeconds(triangles, positions_, rays_, costs_);
        const double rebuild = BvhPolicy::rebuildSeconds(triangles.size(), costs_);
        build = refit > rebuild;
        refitSeconds_ += std::min(refit, rebuild);
        if (build) ++rebuilds_;
    }
    ++frames_;
    triangles_ = triangles.size();
    if (build) policy_.built(triangles, positions_);
}

Question BvhForecast::question(BvhKind kind) const {
    const auto milliseconds = [](double seconds) { return static_cast<float>(1e3 * seconds); };
    const double slower = costs_.refittable * rays_ * costs_.ray;
    Choice refit{BvhKind::Refit, 0, milliseconds(refitSeconds_ / std::max(1, frames_) + slower), 0, {}};
    Choice rebuild{BvhKind::Rebuild, 0, milliseconds(BvhPolicy::rebuildSeconds(triangles_, costs_)), 0, {}};
    const bool refits = kind == BvhKind::Refit;
    const bool rebuilds = !refits || 2 * rebuilds_ > frames_;
    if (rebuilds_ > 0 && refits)
        (rebuilds ? rebuild : refit).note = ", " + std::to_string(rebuilds_) + " of " + std::to_string(frames_) + " frames rebuilt";
    return {{refit, rebuild}, rebuilds ? 1U : 0U};
}

} // namespace taut
