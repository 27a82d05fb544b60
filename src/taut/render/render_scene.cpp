#include "taut/render/render_scene.h"

#include "taut/base/error.h"
#include "taut/base/stopwatch.h"
#include "taut/deform/stored_gloss.h"
#include "taut/render/place_lights.h"
#include "taut/scene/check_scene.h"
#include "taut/scene/texture_pyramid.h"

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

/// Objects of one shape have the same positions about their centres.
InstanceShape shapeOf(const RenderObject &object) {
    const Object &from = *object.object;
    InstanceShape shape{from.mesh.get(),
                        {},
                        object.plan.subdivisionLevel,
                        from.subdivision.scheme,
                        from.subdivision.boundary,
                        from.subdivision.creaseAngle};
    for (int c = 0; c < 3; ++c)
        for (int r = 0; r < 3; ++r) shape.restFromObject[static_cast<std::size_t>(3 * c + r)] = object.surface.restFromObject[c][r];
    return shape;
}

/// Render vertices of one position are at one place, whatever hard edges and seams make of them.
std::vector<Index> placesOf(const Surface &surface) {
    std::vector<Index> places;
    places.reserve(surface.vertexCount());
    for (const Index vertex : surface.vertexSurface) places.push_back(surface.surfacePosition[vertex]);
    return places;
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

RenderScene::RenderScene(Scene scene, bool animated) : scene_(std::move(scene)), plan_(defaultPlan(scene_)) {
    prepare(animated, {});
}

RenderScene::RenderScene(Scene scene, ScenePlan plan, bool animated, std::vector<ObjectSurface> surfaces)
    : scene_(std::move(scene)), plan_(std::move(plan)) {
    prepare(animated, std::move(surfaces));
}

void RenderScene::prepare(bool animated, std::vector<ObjectSurface> surfaces) {
    sharePoses(scene_);
    const Scene &scene = scene_;
    check(scene);
    for (Index m = 0; m < scene.materials.size(); ++m) addPyramids(m);
    objects_ = std::vector<RenderObject>(scene.objects.size());
    changed_.assign(objects_.size(), 1);
    for (std::size_t i = 0; i < objects_.size(); ++i) {
        const Object &object = scene.objects[i];
        const bool blurred = scene.render.shutter > 0 && moves(object);
        const std::size_t times = blurred ? motionSteps() : 1;
        if (i < surfaces.size() && surfaces[i].object != nullptr) {
            static_cast<ObjectSurface &>(objects_[i]) = std::move(surfaces[i]);
            objects_[i].object = &object; // of this scene, no longer of the one that was planned
        }
        prepareRenderObject(object, scene.render, plan_.meshes[i], times, animated, objects_[i]);
        if (hasStoredGloss(objects_[i].mesh(), objects_[i].surface)) objects_[i].storedPoisson = poissonOfVertices(scene, objects_[i]);
    }
    refits_ = animated && plan_.bvh == BvhKind::Refit;
    embree_ = std::make_unique<EmbreeScene>(refits_);
}

std::size_t RenderScene::motionSteps() const {
    return static_cast<std::size_t>(plan_.motionSteps > 0 ? plan_.motionSteps : scene_.render.motionSteps);
}

void RenderScene::moveCamera(double frame, const DMat4 &renderFromWorld) {
    cameraSteps_.assign(1, Affine(1));
    if (!(scene_.render.shutter > 0)) return;
    const std::size_t count = motionSteps();
    cameraSteps_.clear();
    for (std::size_t step = 0; step < count; ++step) {
        const CameraState there = cameraAtFrame(scene_.camera, frameOfStep(scene_.render, frame, step, count), scene_.render.fps);
        cameraSteps_.emplace_back(renderFromWorld * there.worldFromCamera);
    }
    const bool still = std::all_of(cameraSteps_.begin(), cameraSteps_.end(), [&](const Affine &m) { return m == cameraSteps_.front(); });
    if (still) cameraSteps_.assign(1, Affine(1));
}

Index RenderScene::addInstance(const RenderObject &object) {
    Index &shared = instances_.try_emplace(shapeOf(object), kNone).first->second;
    if (shared != kNone) return embree_->addInstanceOf(shared, object.placements);
    const std::vector<Index> places = placesOf(object.surface);
    return shared = embree_->addInstance(object.steps.front().positions, {object.surface.triangles, places}, object.placements);
}

/// What a material's textures need to be looked up over footprints.
void RenderScene::addPyramids(Index index) {
    if (index >= plan_.details.size() || plan_.details[index].detail != TextureDetail::Moments) return;
    const Material &material = scene_.materials[index];
    const auto charge = [&](const Texture &texture, int channels) { // a pyramid is a third more than its widest level
        if (scene_.budget)
            scene_.budget->take(4.0 / 3 * sizeof(float) * channels * texture.width * texture.height, texture.name,
                                "the pyramid of its moments");
    };
    forEachTexture(material, [&](Index t) {
        Texture &texture = scene_.textures[t];
        if (texture.pyramid || texture.sampler.nearest) return;
        charge(texture, texture.channels);
        texture.pyramid = colourPyramid(texture);
    });
    for (const SlopeMap *map : {&material.slopes, &material.coatSlopes}) {
        if (!map->isGiven() || scene_.textures[map->texture].slopes) continue;
        charge(scene_.textures[map->texture], 5);
        scene_.textures[map->texture].slopes = slopePyramid(scene_.textures[map->texture], map->kind);
    }
}

/// Materials may have changed since the last frame.
void RenderScene::askForSurfaces() {
    surfacesMayBeAbsent_ = false;
    for (RenderObject &object : objects_) {
        const std::vector<Index> &materials = object.object->materials;
        const bool asks = std::any_of(materials.begin(), materials.end(), [&](Index m) { return mayBeAbsent(scene_.materialAt(m)); });
        if (asks != object.mayBeAbsent) embree_->ask(object.geometry, asks);
        object.mayBeAbsent = asks;
        surfacesMayBeAbsent_ |= asks;
    }
}

/// Likewise.
void RenderScene::askForStrains() {
    for (std::size_t i = 0; i < objects_.size(); ++i) {
        RenderObject &object = objects_[i];
        const std::vector<Index> &materials = object.object->materials;
        const bool known = object.object->follow && object.storedPoisson.empty();
        const bool roughens =
            known && std::any_of(materials.begin(), materials.end(), [&](Index m) { return scene_.materialAt(m).roughening > 0; });
        if (roughens && !object.roughens) changed_[i] = 1;
        object.roughens = roughens;
    }
}

void RenderScene::setFrame(double frame, StageTimes &times) {
    const RenderSettings &render = scene_.render;
    const DMat4 before = worldFromRender_;
    camera_ = cameraAtFrame(scene_.camera, frame, render.fps);
    worldFromRender_ = camera_.worldFromCamera;
    const bool stands = committed_ && frame == frame_ && worldFromRender_ == before;
    const DMat4 renderFromWorld = inverseOfRigid(worldFromRender_);
    moveCamera(frame, renderFromWorld);
    askForStrains();
    for (Index i = 0; i < objects_.size(); ++i) {
        RenderObject &object = objects_[i];
        if (stands && changed_[i] == 0 && !object.object->points) {
            object.moved = false;
            continue;
        }
        changed_[i] = 0;
        bool moved = false;
        const std::size_t shutterTimes = std::max(object.steps.size(), object.placements.size());
        for (std::size_t step = 0; step < shutterTimes; ++step)
            moved |= moveObject(object, step, frameOfStep(render, frame, step, shutterTimes), render.fps, renderFromWorld,
                                times.deformation, times.gradient);
        object.moved = moved;
        Stopwatch watch;
        const std::vector<Vec3> &positions = object.steps.front().positions;
        if (!committed_) {
            std::vector<std::span<const Vec3>> steps;
            for (const SurfaceStep &step : object.steps) steps.emplace_back(step.positions);
            object.geometry = object.instanced
                                  ? addInstance(object)
                                  : embree_->addTriangles(steps, {object.surface.triangles, placesOf(object.surface), !object.rigid});
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
    askForSurfaces();
    placeLights(scene_, objects_, worldFromRender_, renderFromWorld, lights_);
    embree_->commit();
    committed_ = true;
    frame_ = frame;
    times.bvh += watch.lap();
}

namespace {

template <class T> T &entryOf(std::vector<T> &values, Index index, const char *what) {
    if (index >= values.size())
        throw InputError(std::string("scene: found ") + what + ' ' + std::to_string(index) + ", expected one of " +
                         std::to_string(values.size()));
    return values[index];
}

/// Gives a part of the scene its new value, if the scene still is one then.
template <class T> void replace(const Scene &scene, T &part, T value) {
    std::swap(part, value);
    try {
        check(scene);
    } catch (...) {
        std::swap(part, value);
        throw;
    }
}

} // namespace

void RenderScene::setCamera(Camera camera) {
    replace(scene_, scene_.camera, std::move(camera));
}

void RenderScene::setMaterial(Index material, Material value) {
    replace(scene_, entryOf(scene_.materials, material, "material"), std::move(value));
    plan_.materials[material] = {};
    plan_.details[material] = {
        scene_.materials[material].detail == TextureDetail::Moments ? TextureDetail::Moments : TextureDetail::Map, 0, {}};
    addPyramids(material);
    for (RenderObject &object : objects_)
        if (!object.storedPoisson.empty()) object.storedPoisson = poissonOfVertices(scene_, object);
}

void RenderScene::setLight(Index light, Light value) {
    replace(scene_, entryOf(scene_.lights, light, "light"), std::move(value));
}

void RenderScene::setEnvironment(std::optional<Environment> value) {
    replace(scene_, scene_.environment, std::move(value));
}

bool RenderScene::canMove(Index object, const std::vector<DeformerKeys> &deformers, const Placement &placement) const {
    const Object &now = scene_.objects.at(object);
    Object then = now;
    then.deformers = deformers;
    then.placement = placement;
    return now.rest.bind && deforms(then) == deforms(now) && moves(then) == moves(now) &&
           placementRest(placement) == placementRest(now.placement) && placement.worldFromUp == now.placement.worldFromUp;
}

void RenderScene::setMotion(Index object, std::vector<DeformerKeys> deformers, Placement placement) {
    Object &entry = entryOf(scene_.objects, object, "object");
    if (!canMove(object, deformers, placement))
        throw InputError("object " + quoted(entry.name) + ": found a motion that changes its surface, expected a scene made anew");
    replace(scene_, entry.deformers, std::move(deformers));
    replace(scene_, entry.placement, std::move(placement));
    changed_[object] = 1;
}

void RenderScene::setSize(int width, int height) {
    scene_.render.width = std::max(1, width);
    scene_.render.height = std::max(1, height);
}

void RenderScene::setMaterialPlans(std::vector<MultiscatterPlan> materials, std::vector<DetailPlan> details, float bearableWaste) {
    if (materials.size() != scene_.materials.size() || details.size() != scene_.materials.size())
        throw InputError("scene: found plans of " + std::to_string(materials.size()) + " materials, expected " +
                         std::to_string(scene_.materials.size()));
    plan_.materials = std::move(materials);
    plan_.details = std::move(details);
    plan_.bearableWaste = bearableWaste;
    for (Index m = 0; m < scene_.materials.size(); ++m) addPyramids(m);
}

void RenderScene::setPoints(Index object, std::shared_ptr<const PointSource> points) {
    Object &entry = entryOf(scene_.objects, object, "object");
    if (objects_[object].rigid)
        throw InputError("object " + quoted(entry.name) + ": found new points, expected none for an object that was made rigid");
    replace(scene_, entry.points, std::move(points));
    changed_[object] = 1;
}

} // namespace taut
