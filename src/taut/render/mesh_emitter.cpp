#include "taut/render/mesh_emitter.h"

#include "taut/base/warp.h"
#include "taut/render/light_tree.h"

#include <algorithm>

namespace taut {

namespace {

template <class T> bool sameMemory(std::span<T> a, std::span<T> b) {
    return a.data() == b.data() && a.size() == b.size();
}

/// A triangle at a time in the shutter.
struct EmittingTriangle {
    Vec3 corner, e1, e2;
    Vec3 cross; ///< twice the area long, on the side that shines
};

/// Of a triangle's cross product, whose square may leave float.
float lengthOf(const Vec3 &cross) {
    const float length = glm::length(cross);
    return std::isfinite(length) ? length : static_cast<float>(glm::length(DVec3(cross)));
}

EmittingTriangle emittingTriangle(const MeshEmitter &emitter, Index triangle, float time) {
    const Index3 &t = emitter.triangles[triangle];
    EmittingTriangle e;
    e.corner = emitterPosition(emitter, t.x, time);
    e.e1 = emitterPosition(emitter, t.y, time) - e.corner;
    e.e2 = emitterPosition(emitter, t.z, time) - e.corner;
    e.cross = glm::cross(e.e1, e.e2) * emitter.side(triangle);
    return e;
}

} // namespace

bool operator==(const MeshEmitter &a, const MeshEmitter &b) {
    return sameMemory(a.steps, b.steps) && sameMemory(a.placements, b.placements) && sameMemory(a.triangles, b.triangles) &&
           a.twoSided == b.twoSided && a.mirrored == b.mirrored && sameMemory(a.turned, b.turned);
}

Vec3 emitterPosition(const MeshEmitter &emitter, Index vertex, float time) {
    const auto &steps = emitter.steps;
    if (!emitter.placements.empty()) return transformPoint(affineAt(emitter.placements, time), steps.front().positions[vertex]);
    if (steps.size() == 1) return steps.front().positions[vertex];
    const float at = time * static_cast<float>(steps.size() - 1);
    const std::size_t before = std::min(static_cast<std::size_t>(at), steps.size() - 2);
    return glm::mix(steps[before].positions[vertex], steps[before + 1].positions[vertex], at - static_cast<float>(before));
}

float emitterArea(const MeshEmitter &emitter, Index triangle, float time) {
    return 0.5F * lengthOf(emittingTriangle(emitter, triangle, time).cross);
}

LightSample sampleEmitter(const MeshEmitter &emitter, Index triangle, const Vec3 &radiance, const Vec3 &point, float time,
                          const Vec2 &number) {
    const EmittingTriangle e = emittingTriangle(emitter, triangle, time);
    const Vec2 b = squareToTriangle(number);
    const float length = lengthOf(e.cross);
    if (!(length > 0)) return {};
    return sampleOfArea(radiance, emitter.twoSided, 0.5F * length, point, e.corner + e.e1 * b.x + e.e2 * b.y, e.cross / length);
}

/// Twice the area of a triangle in the direction of its normal, its edges moving linearly between two times, is a quadratic Bezier
/// curve: a cone about its three control points holds it.
LightBounds emitterBounds(const MeshEmitter &emitter, Index triangle, float strength) {
    LightBounds bounds;
    bounds.twoSided = emitter.twoSided;
    const Index3 &t = emitter.triangles[triangle];
    const std::size_t steps = std::max(emitter.steps.size(), emitter.placements.size());
    LightBounds cone;
    std::size_t controls = 0;
    float sum = 0;
    const auto turn = [&](const Vec3 &cross) {
        ++controls;
        const float length = lengthOf(cross);
        if (!(length > 0)) return;
        sum += 0.5F * length;
        LightBounds one = bounds;
        one.axis = cross * (emitter.side(triangle) / length);
        one.power = 1;
        cone = united(cone, one);
    };
    Vec3 before1(0);
    Vec3 before2(0);
    for (std::size_t step = 0; step < steps; ++step) {
        const float time = steps == 1 ? 0.0F : static_cast<float>(step) / static_cast<float>(steps - 1);
        const Vec3 a = emitterPosition(emitter, t.x, time);
        const Vec3 b = emitterPosition(emitter, t.y, time);
        const Vec3 c = emitterPosition(emitter, t.z, time);
        for (const Vec3 &corner : {a, b, c}) include(bounds, corner);
        const Vec3 e1 = b - a;
        const Vec3 e2 = c - a;
        if (step > 0) turn(0.5F * (glm::cross(before1, e2) + glm::cross(e1, before2)));
        turn(glm::cross(e1, e2));
        before1 = e1;
        before2 = e2;
    }
    if (!(sum > 0)) return bounds;
    bounds.axis = cone.axis;
    bounds.cosSpread = cone.cosSpread < 0 ? -1.0F : cone.cosSpread; // wider than a half space, sums may point anywhere
    bounds.power = strength * sum / static_cast<float>(controls);
    return bounds;
}

} // namespace taut
