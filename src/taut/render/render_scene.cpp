#include "taut/render/render_scene.h"

#include "taut/base/stopwatch.h"
#include "taut/deform/stored_gloss.h"

#include <algorithm>

namespace taut {

namespace {

/// Poisson ratio of the material at each render vertex; where faces of several meet, one of theirs.
std::vector<float> poissonOfVertices(const Scene &scene, const ObjectSurface &object) {
    const Surface &surface = object.surface;
    std::vector<float> out(surface.vertexCount(), 0.0F);
    for (std::size_t t = 0; t < surface.triangles.size(); ++t) {
        const float poisson = scene.materialAt(materialOfTriangle(object, static_cast<Index>(t))).poisson;
        for (int k = 0; k < 3; ++k) out[surface.triangles[t][k]] = poisson;
    }
    return out;
}

bool emits(const Object &object) {
    return object.emission.value != Vec3(0);
}

Vec3 toRender(const DMat4 &renderFromWorld, const DVec3 &p) {
    return Vec3(DVec3(renderFromWorld * glm::dvec4(p, 1)));
}
Vec3 vectorToRender(const DMat4 &renderFromWorld, const DVec3 &v) {
    return Vec3(DMat3(renderFromWorld) * v);
}

/// Whether an object may be somewhere else at another time.
bool moves(const Object &object) {
    const Placement &p = object.placement;
    return object.rig || object.points || !object.deformers.empty() || !p.translation.isConstant() || !p.rotation.isConstant() ||
           !p.scale.isConstant();
}

/// The inverse of a rigid motion, written out: exact to rounding.
DMat4 inverseOfRigid(const DMat4 &m) {
    const DMat3 rotation = glm::transpose(DMat3(m));
    DMat4 inverse(rotation);
    inverse[3] = glm::dvec4(-(rotation * DVec3(m[3])), 1);
    return inverse;
}

/// Frame number of one of `count` equally spaced times within the shutter.
double frameOfStep(const RenderSettings &render, double frame, std::size_t step, std::size_t count) {
    return count == 1 ? frame : frame + render.shutter * (static_cast<double>(step) / static_cast<double>(count - 1) - 0.5);
}

} // namespace

StageTimes &StageTimes::operator+=(const StageTimes &other) {
    deformation += other.deformation;
    gradient += other.gradient;
    bvh += other.bvh;
    cameraRays += other.cameraRays;
    scatteredRays += other.scatteredRays;
    shadowRays += other.shadowRays;
    shading += other.shading;
    film += other.film;
    return *this;
}

RenderScene::RenderScene(const Scene &scene, ScenePlan plan, bool animated)
    : scene_(&scene), plan_(std::move(plan)), objects_(scene.objects.size()) {
    std::vector<DeformingMesh> deforming;
    for (std::size_t i = 0; i < objects_.size(); ++i) {
        const Object &object = scene.objects[i];
        const bool blurred = scene.render.shutter > 0 && moves(object);
        const std::size_t times = blurred ? static_cast<std::size_t>(scene.render.motionSteps) : 1;
        prepareRenderObject(object, scene.render, plan_.meshes[i], times, animated, objects_[i]);
        if (hasStoredGloss(objects_[i].mesh(), objects_[i].surface)) objects_[i].storedPoisson = poissonOfVertices(scene, objects_[i]);
        if (!objects_[i].rigid) deforming.push_back({objects_[i].surface.triangles.size(), times > 1});
    }
    refits_ = animated && plan_.mayRefit && refitsPay(deforming, raysPerFrame(scene.render));
    embree_ = std::make_unique<EmbreeScene>(refits_);
}

void RenderScene::moveCamera(double frame, const DMat4 &renderFromWorld) {
    cameraSteps_.assign(1, Affine(1));
    if (!(scene_->render.shutter > 0)) return;
    const auto count = static_cast<std::size_t>(scene_->render.motionSteps);
    cameraSteps_.clear();
    for (std::size_t step = 0; step < count; ++step) {
        const CameraState there = cameraAtFrame(scene_->camera, frameOfStep(scene_->render, frame, step, count), scene_->render.fps);
        cameraSteps_.emplace_back(renderFromWorld * there.worldFromCamera);
    }
    const bool still = std::all_of(cameraSteps_.begin(), cameraSteps_.end(), [&](const Affine &m) { return m == cameraSteps_.front(); });
    if (still) cameraSteps_.assign(1, Affine(1));
}

void RenderScene::setFrame(double frame, StageTimes &times) {
    const RenderSettings &render = scene_->render;
    camera_ = cameraAtFrame(scene_->camera, frame, render.fps);
    worldFromRender_ = camera_.worldFromCamera;
    const DMat4 renderFromWorld = inverseOfRigid(worldFromRender_);
    moveCamera(frame, renderFromWorld);
    for (Index i = 0; i < objects_.size(); ++i) {
        RenderObject &object = objects_[i];
        bool moved = false;
        const std::size_t shutterTimes = std::max(object.steps.size(), object.placements.size());
        for (std::size_t step = 0; step < shutterTimes; ++step)
            moved |= moveObject(object, step, frameOfStep(render, frame, step, shutterTimes), render.fps, renderFromWorld,
                                times.deformation, times.gradient);
        Stopwatch watch;
        const std::vector<Vec3> &positions = object.steps.front().positions;
        if (!committed_) {
            std::vector<std::span<const Vec3>> steps;
            for (const SurfaceStep &step : object.steps) steps.emplace_back(step.positions);
            object.geometry = object.instanced ? embree_->addInstance(positions, object.surface.triangles, object.placements)
                                               : embree_->addTriangles(steps, object.surface.triangles);
            owners_.resize(std::max<std::size_t>(owners_.size(), object.geometry + 1), kNone);
            owners_[object.geometry] = i;
            if (!object.rigid && refits_) object.bvh.built(object.surface.triangles, positions);
        } else if (moved && object.instanced) {
            embree_->place(object.geometry, object.placements);
        } else if (moved) {
            const bool rebuild = refits_ && object.bvh.shouldRebuild(object.surface.triangles, positions, raysPerFrame(render));
            embree_->update(object.geometry, rebuild);
            if (rebuild) object.bvh.built(object.surface.triangles, positions);
        }
        times.bvh += watch.lap();
    }
    Stopwatch watch;
    placeLights(renderFromWorld);
    embree_->commit();
    committed_ = true;
    times.bvh += watch.lap();
}

void RenderScene::placeLights(const DMat4 &renderFromWorld) {
    lights_.entries.clear();
    lights_.worldFromRender = Mat3(DMat3(worldFromRender_));
    lights_.environment = nullptr;
    lights_.environmentEntry = kNone;
    if (scene_->environment && scene_->environment->mean != Vec3(0)) lights_.environment = &*scene_->environment;
    // Scattered rays sample what they weigh a constant sky with; aiming at it would only add shadow rays.
    if (lights_.environment != nullptr && !lights_.environment->constant) {
        lights_.environmentEntry = static_cast<Index>(lights_.entries.size());
        lights_.entries.push_back({});
        lights_.entries.back().kind = LightKind::Environment;
    }
    for (const Light &light : scene_->lights) {
        LightEntry entry;
        entry.radiance = light.radiance;
        entry.origin = toRender(renderFromWorld, light.corner);
        entry.u = vectorToRender(renderFromWorld, light.u);
        entry.v = vectorToRender(renderFromWorld, light.v);
        entry.radius = static_cast<float>(light.radius);
        entry.direction = glm::normalize(vectorToRender(renderFromWorld, light.direction));
        entry.cosInner = static_cast<float>(std::cos(light.innerAngle));
        entry.cosOuter = static_cast<float>(std::cos(light.outerAngle));
        entry.twoSided = light.twoSided;
        entry.cameraVisible = light.cameraVisible;
        switch (light.type) {
        case LightType::Quad: entry.kind = LightKind::Quad; break;
        case LightType::Sphere: entry.kind = LightKind::Sphere; break;
        case LightType::Directional: entry.kind = LightKind::Directional; break;
        case LightType::Point: entry.kind = LightKind::Point; break;
        case LightType::Spot: entry.kind = LightKind::Spot; break;
        }
        if (entry.kind == LightKind::Quad) {
            const Vec3 cross = glm::cross(entry.u, entry.v);
            entry.area = glm::length(cross);
            entry.direction = cross / entry.area;
            entry.alongU = glm::cross(entry.v, entry.direction) / entry.area;
            entry.alongV = glm::cross(entry.direction, entry.u) / entry.area;
            entry.centre = entry.origin + 0.5F * (entry.u + entry.v);
        }
        lights_.entries.push_back(std::move(entry));
    }
    lightEntries_.assign(objects_.size(), kNone);
    for (Index i = 0; i < objects_.size(); ++i) {
        const RenderObject &object = objects_[i];
        // A textured emitter is met by scattered rays alone: its texture is not part of the light table.
        if (!emits(*object.object) || object.object->emission.texture != kNone) continue;
        LightEntry entry;
        entry.kind = LightKind::Mesh;
        entry.radiance = object.object->emission.value;
        for (const SurfaceStep &step : object.steps) entry.steps.emplace_back(step.positions);
        entry.placements = object.placements;
        entry.triangles = object.surface.triangles;
        entry.twoSided = object.object->emissionTwoSided;
        entry.mirrored = object.mirrored;
        lightEntries_[i] = static_cast<Index>(lights_.entries.size());
        lights_.entries.push_back(std::move(entry));
    }
    prepareChoice(lights_);
}

} // namespace taut
