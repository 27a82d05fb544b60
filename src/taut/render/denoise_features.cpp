#include "taut/render/denoise_features.h"

#include "taut/render/shading.h"

#include <algorithm>
#include <cmath>

namespace taut {

namespace {

/// Where a point of render space is seen, pixels from the centre, y down; false behind the camera.
bool project(const Vec3 &p, double fovY, double orthoHeight, int height, Vec2 &pixels) {
    if (orthoHeight > 0) {
        const auto scale = static_cast<float>(height / orthoHeight);
        pixels = Vec2(p.x, -p.y) * scale;
        return true;
    }
    if (!(p.z < 0)) return false;
    const auto scale = static_cast<float>(0.5 * height / std::tan(0.5 * fovY));
    pixels = Vec2(p.x, -p.y) * (scale / -p.z);
    return true;
}

void put(float *out, const Vec3 &v) {
    for (int c = 0; c < 3; ++c) out[c] = v[c];
}

float logOf(float x) {
    return std::log(std::clamp(x, 1e-6F, 1e6F));
}

/// The lobe's widths and directions as one tensor.
void putGloss(float *out, const SurfacePoint &point, const Mat3 &worldFromRender) {
    if (!bsdfInfo(point.bsdf.type).microsurface) {
        std::fill_n(out, 6, 0.0F);
        return;
    }
    const EquivalentAlpha alpha = equivalentAlpha(point.bsdf.micro);
    const float c = std::cos(alpha.phi);
    const float s = std::sin(alpha.phi);
    const auto place = [&](const Vec3 &local) {
        return worldFromRender * point.frame.fromLocal(point.tilted ? point.facet.frame.fromLocal(local) : local);
    };
    const Vec3 t1 = place(Vec3(c, s, 0));
    const Vec3 t2 = place(Vec3(-s, c, 0));
    const auto weight = [](float a) {
        const float held = std::max(a, kLeastGloss);
        return std::isfinite(held) ? 1 / (held * held) : 0.0F;
    };
    const float w1 = weight(alpha.max);
    const float w2 = weight(alpha.min);
    for (int i = 0, k = 0; i < 3; ++i)
        for (int j = i; j < 3; ++j, ++k) out[k] = w1 * t1[i] * t1[j] + w2 * t2[i] * t2[j];
}

} // namespace

FrameBefore::FrameBefore(const RenderScene &scene) : fovY_(scene.camera().fovY), orthoHeight_(scene.camera().orthoHeight) {
    for (const RenderObject &object : scene.objects()) {
        Shape shape;
        for (const SurfaceStep &step : object.steps) shape.steps.push_back(step.positions);
        shape.placements = object.placements;
        objects_.push_back(std::move(shape));
    }
}

bool FrameBefore::motionOf(const RenderScene &scene, const SurfacePoint &point, float time, Vec2 &pixels) const {
    const auto index = static_cast<std::size_t>(point.object - scene.objects().data());
    if (index >= objects_.size()) return false;
    const Shape &shape = objects_[index];
    const auto at = [&](const std::vector<Vec3> &p) {
        return p[point.corners.x] * point.barycentrics.x + p[point.corners.y] * point.barycentrics.y +
               p[point.corners.z] * point.barycentrics.z;
    };
    const std::size_t last = shape.steps.size() - 1;
    const float place = time * static_cast<float>(last);
    const std::size_t step = std::min(static_cast<std::size_t>(place), last);
    Vec3 then = at(shape.steps[step]);
    if (step < last) then = glm::mix(then, at(shape.steps[step + 1]), place - static_cast<float>(step));
    if (!shape.placements.empty()) then = transformPoint(affineAt(shape.placements, time), then);
    const int height = scene.scene().render.height;
    Vec2 now;
    Vec2 was;
    if (!project(then, fovY_, orthoHeight_, height, was) ||
        !project(point.position, scene.camera().fovY, scene.camera().orthoHeight, height, now))
        return false;
    pixels = was - now;
    return std::isfinite(pixels.x) && std::isfinite(pixels.y) && glm::length(pixels) < 16384;
}

bool writeDenoiseFeatures(const RenderScene &scene, const SurfacePoint &point, const Vec3 &wo, float time, const FrameBefore *before,
                          float *out) {
    const Mat3 worldFromRender(DMat3(scene.worldFromRender()));
    const Vec3 n = worldFromRender * (point.tilted ? point.frame.fromLocal(point.facet.frame.n) : point.frame.n);
    put(out + kNormal, n);
    put(out + kAlbedo, glm::clamp(point.baseColor, Vec3(0), Vec3(kMostAlbedo)));
    out[kDepth] = logOf(-point.position.z);
    put(out + kHalfway, n - 0.5F * (worldFromRender * wo));
    const Vec2 stretch = singularValues(point.stretch.x, point.stretch.y, point.stretch.y, point.stretch.z);
    out[kLogStretch] = logOf(stretch.x);
    out[kLogStretch + 1] = logOf(stretch.y);
    putGloss(out + kGloss, point, worldFromRender);
    Vec2 motion(0);
    const bool known = before != nullptr && before->motionOf(scene, point, time, motion);
    out[kMotion] = motion.x;
    out[kMotion + 1] = motion.y;
    return known;
}

} // namespace taut
