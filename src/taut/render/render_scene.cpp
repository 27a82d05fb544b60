#include "taut/render/render_scene.h"

#include "taut/base/parallel.h"
#include "taut/base/stopwatch.h"

#include <algorithm>

namespace taut {

namespace {

constexpr std::size_t kGrain = 2048;

bool emits(const Object &object) {
    return object.emission.value != Vec3(0);
}

Vec3 toRender(const DMat4 &renderFromWorld, const DVec3 &p) {
    return Vec3(DVec3(renderFromWorld * glm::dvec4(p, 1)));
}
Vec3 vectorToRender(const DMat4 &renderFromWorld, const DVec3 &v) {
    return Vec3(DMat3(renderFromWorld) * v);
}

/// V and the rotated tangent at every render vertex.
void makeShadingGradient(RenderObject &object) {
    const SurfaceFrame &frame = object.frame;
    const std::size_t count = object.surface.vertexCount();
    const bool keepStretch = !object.rigid && object.object->follow;
    if (object.tangents.size() != count) object.tangents.resize(count);
    if (keepStretch && object.stretch.size() != count) object.stretch.resize(count);
    parallelFor(count, kGrain, [&](std::size_t v) {
        const PolarGradient polar = polarGradient(frame.ds[v], frame.dt[v], frame.normals[v]);
        object.tangents[v] = polar.tangent;
        if (keepStretch) object.stretch[v] = polar.stretch;
        // As other renderers do: the tangent is the normalised image of t0, whatever the shear.
        if (!object.object->follow) {
            const float length = glm::length(frame.ds[v]);
            if (length > 0) object.tangents[v] = Vec4(frame.ds[v] / length, polar.tangent.w);
        }
    });
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

RenderScene::RenderScene(const Scene &scene, bool animated) : scene_(&scene), embree_(animated), objects_(scene.objects.size()) {
    for (std::size_t i = 0; i < objects_.size(); ++i) {
        RenderObject &object = objects_[i];
        object.rigid = isRigid(scene.objects[i]);
        prepareObjectSurface(scene.objects[i], scene.render.fps, object);
    }
}

void RenderScene::setFrame(double frame, StageTimes &times) {
    camera_ = cameraAtFrame(scene_->camera, frame, scene_->render.fps);
    worldFromRender_ = camera_.worldFromCamera;
    // The inverse of a rigid motion, written out: exact to rounding.
    const DMat3 rotation = glm::transpose(DMat3(worldFromRender_));
    DMat4 renderFromWorld(rotation);
    renderFromWorld[3] = glm::dvec4(-(rotation * DVec3(worldFromRender_[3])), 1);

    for (RenderObject &object : objects_) {
        surfaceAtFrame(object, frame, scene_->render.fps, renderFromWorld, times.deformation, times.gradient);
        Stopwatch watch;
        makeShadingGradient(object);
        times.gradient += watch.lap();
    }
    Stopwatch watch;
    if (!committed_) {
        for (Index i = 0; i < objects_.size(); ++i) {
            RenderObject &object = objects_[i];
            object.geometry = embree_.addTriangles(object.frame.positions, object.surface.triangles, true);
            owners_.resize(std::max<std::size_t>(owners_.size(), object.geometry + 1), kNone);
            owners_[object.geometry] = i;
        }
    } else {
        for (const RenderObject &object : objects_) embree_.update(object.geometry);
    }
    placeLights(renderFromWorld);
    embree_.commit();
    committed_ = true;
    times.bvh += watch.lap();
}

void RenderScene::placeLights(const DMat4 &renderFromWorld) {
    lights_.entries.clear();
    lights_.worldFromRender = Mat3(DMat3(worldFromRender_));
    lights_.environment = nullptr;
    lights_.environmentEntry = kNone;
    if (scene_->environment && scene_->environment->mean != Vec3(0)) {
        lights_.environment = &*scene_->environment;
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
        entry.positions = object.frame.positions;
        entry.triangles = object.surface.triangles;
        entry.twoSided = object.object->emissionTwoSided;
        entry.mirrored = object.mirrored;
        double sum = 0;
        DVec3 centroid(0);
        for (const Index3 &t : entry.triangles) {
            const Vec3 &a = entry.positions[t.x];
            const Vec3 &b = entry.positions[t.y];
            const Vec3 &c = entry.positions[t.z];
            const double area = 0.5 * static_cast<double>(glm::length(glm::cross(b - a, c - a)));
            sum += area;
            centroid += DVec3(a + b + c) * (area / 3);
            entry.cumulativeArea.push_back(static_cast<float>(sum));
        }
        entry.area = static_cast<float>(sum);
        entry.centre = Vec3(centroid / std::max(sum, 1e-300));
        if (!(entry.area > 0)) continue;
        lightEntries_[i] = static_cast<Index>(lights_.entries.size());
        lights_.entries.push_back(std::move(entry));
    }
}

} // namespace taut
