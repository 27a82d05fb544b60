#include "live_scene.h"

#include <algorithm>

namespace taut::app {

namespace {

bool isSame(const Emission &a, const Emission &b) {
    return a.radiance.value == b.radiance.value && a.radiance.texture == b.radiance.texture && a.twoSided == b.twoSided;
}

template <class T> bool isSame(const Keyed<T> &a, const Keyed<T> &b) {
    return a.keys == b.keys;
}

bool isSame(const DeformerKeys &a, const DeformerKeys &b) {
    return a.type == b.type && a.centre == b.centre && a.axis == b.axis && a.axis2 == b.axis2 && a.lower == b.lower && a.upper == b.upper &&
           isSame(a.factor, b.factor) && isSame(a.amount, b.amount) && isSame(a.amplitude, b.amplitude) &&
           isSame(a.wavelength, b.wavelength) && isSame(a.phase, b.phase) && a.latticeLower == b.latticeLower &&
           a.latticeUpper == b.latticeUpper && a.latticePoints == b.latticePoints &&
           std::equal(a.latticeOffsets.begin(), a.latticeOffsets.end(), b.latticeOffsets.begin(), b.latticeOffsets.end(),
                      [](const auto &x, const auto &y) { return isSame(x, y); });
}

bool isSameMotion(const Object &a, const Object &b) {
    const Placement &p = a.placement;
    const Placement &q = b.placement;
    return isSame(p.translation, q.translation) && isSame(p.rotation, q.rotation) && isSame(p.scale, q.scale) &&
           std::equal(a.deformers.begin(), a.deformers.end(), b.deformers.begin(), b.deformers.end(),
                      [](const auto &x, const auto &y) { return isSame(x, y); });
}

/// One surface and its looks, wherever it is.
bool isSameSurface(const Object &a, const Object &b) {
    bool same = a.name == b.name && a.mesh == b.mesh && a.materials == b.materials && a.mapTangents == b.mapTangents;
    for (Index slot = 0; same && slot < a.materials.size(); ++slot) same = isSame(emissionOf(a, slot), emissionOf(b, slot));
    return same;
}

bool isSame(const MeshPlan &a, const MeshPlan &b) {
    return a.stretch == b.stretch && a.estimator == b.estimator && a.interpolation == b.interpolation &&
           a.subdivisionLevel == b.subdivisionLevel;
}

bool isSame(const MultiscatterPlan &a, const MultiscatterPlan &b) {
    return a.model == b.model && a.negligibleLoss == b.negligibleLoss;
}

template <class T> bool areSame(const std::vector<T> &a, const std::vector<T> &b) {
    return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](const T &x, const T &y) { return isSame(x, y); });
}

bool isSameDetail(const std::vector<DetailPlan> &a, const std::vector<DetailPlan> &b) {
    return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                      [](const DetailPlan &x, const DetailPlan &y) { return x.detail == y.detail; });
}

} // namespace

void Touched::add(const std::string &key) {
    std::vector<std::string> parts;
    for (std::size_t at = 0; at <= key.size();) {
        const std::size_t dot = std::min(key.find('.', at), key.size());
        parts.push_back(key.substr(at, dot - at));
        at = dot + 1;
    }
    const std::string &section = parts.front();
    if (section == "camera") {
        camera = true;
    } else if (section == "environment") {
        environment = true;
    } else if (section == "light") {
        lights = true;
    } else if (section == "material" && parts.size() > 2) {
        materials.insert(parts[1]);
    } else if (section == "mesh" && parts.size() > 2 &&
               (parts[2] == "deform" || parts[2] == "translate" || parts[2] == "rotate_deg" || parts[2] == "scale")) {
        motion = true;
    } else if (section != "image") { // how the picture is seen is not what it is
        everything = true;
    }
}

Touched &Touched::operator+=(const Touched &other) {
    camera |= other.camera;
    lights |= other.lights;
    environment |= other.environment;
    motion |= other.motion;
    everything |= other.everything;
    materials.insert(other.materials.begin(), other.materials.end());
    return *this;
}

bool LiveScene::fits(const Scene &next, const Touched &touched) const {
    const Scene &now = ready_->scene();
    if (touched.everything || next.objects.size() != now.objects.size() || next.lights.size() != now.lights.size() ||
        next.materials.size() != now.materials.size() || next.textures.size() != now.textures.size())
        return false;
    for (std::size_t t = 0; t < now.textures.size(); ++t)
        if (next.textures[t].texels.begin() != now.textures[t].texels.begin() || !(next.textures[t].sampler == now.textures[t].sampler))
            return false;
    for (Index i = 0; i < now.objects.size(); ++i) {
        const Object &a = now.objects[i];
        const Object &b = next.objects[i];
        if (!isSameSurface(a, b)) return false;
        if ((touched.motion || touched.camera) && !isSameMotion(a, b) && !ready_->canMove(i, b.deformers, b.placement)) return false;
    }
    return true;
}

void LiveScene::take(Scene next, const Touched &touched) {
    if (!ready_ || !fits(next, touched)) {
        if (ready_ && !touched.everything && !touched.environment && !touched.lights) next.environment = ready_->scene().environment;
        return build(std::move(next));
    }
    settled_ = settled_ && touched.materials.empty() && !touched.motion && !touched.lights && !touched.environment;
    if (touched.environment || touched.lights) ready_->setEnvironment(std::move(next.environment));
    if (touched.lights)
        for (Index i = 0; i < next.lights.size(); ++i) ready_->setLight(i, std::move(next.lights[i]));
    for (Index m = 0; m < next.materials.size(); ++m)
        if (touched.materials.count(next.materials[m].name) > 0) ready_->setMaterial(m, std::move(next.materials[m]));
    if (touched.motion || touched.camera) // a ground reaches beyond the camera
        for (Index i = 0; i < next.objects.size(); ++i)
            if (!isSameMotion(ready_->scene().objects[i], next.objects[i]))
                ready_->setMotion(i, std::move(next.objects[i].deformers), std::move(next.objects[i].placement));
    if (touched.camera || touched.motion) ready_->setCamera(std::move(next.camera)); // a framed one goes with what it frames
}

void LiveScene::build(Scene scene) {
    const bool animated = scene.render.frames.size() > 1;
    PlannedScene planned = planFor(scene, model_);
    ready_ = std::make_unique<RenderScene>(std::move(scene), std::move(planned.plan), animated, std::move(planned.surfaces));
    settled_ = true;
    ++built_;
}

bool LiveScene::settle() {
    if (settled_) return false;
    settled_ = true;
    PlannedScene planned = planFor(ready_->scene(), model_);
    const ScenePlan &now = ready_->plan();
    ScenePlan &then = planned.plan;
    if (!areSame(now.meshes, then.meshes) || now.maxEvents != then.maxEvents || now.motionSteps != then.motionSteps) {
        const bool animated = ready_->scene().render.frames.size() > 1;
        auto anew = std::make_unique<RenderScene>(ready_->scene(), std::move(then), animated, std::move(planned.surfaces));
        ready_ = std::move(anew); // the old scene's objects are what the surfaces referred to until now
        ++built_;
        return true;
    }
    const bool same =
        areSame(now.materials, then.materials) && isSameDetail(now.details, then.details) && now.bearableWaste == then.bearableWaste;
    ready_->setMaterialPlans(std::move(then.materials), std::move(then.details), then.bearableWaste);
    return !same;
}

} // namespace taut::app
