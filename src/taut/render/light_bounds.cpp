#include "taut/render/light_bounds.h"

#include <algorithm>

namespace taut {

namespace {

void include(LightBounds &bounds, const Vec3 &point) {
    bounds.lower = glm::min(bounds.lower, point);
    bounds.upper = glm::max(bounds.upper, point);
}

void boundQuad(const LightEntry &entry, LightBounds &bounds) {
    for (const Vec3 &corner : {entry.origin, entry.origin + entry.u, entry.origin + entry.v, entry.origin + entry.u + entry.v})
        include(bounds, corner);
    bounds.axis = entry.direction;
    bounds.power *= entry.area;
}

void boundSpot(const LightEntry &entry, LightBounds &bounds) {
    include(bounds, entry.origin);
    const float inner = std::acos(glm::clamp(entry.cosInner, -1.0F, 1.0F));
    const float outer = std::max(inner, std::acos(glm::clamp(entry.cosOuter, -1.0F, 1.0F)));
    // Light fades out between the cones; where that is over more than a right angle, the inner one is taken for wider.
    const float spread = std::max(inner, outer - 0.5F * kPi);
    bounds.axis = entry.direction;
    bounds.cosSpread = std::cos(spread);
    bounds.cosReach = std::cos(outer - spread);
}

/// Twice the area of a triangle in the direction of its normal, its edges moving linearly between two times, is a quadratic Bezier
/// curve: a cone about its three control points holds it.
void boundTriangle(const LightEntry &entry, Index triangle, LightBounds &bounds) {
    const Index3 &t = entry.triangles[triangle];
    const std::size_t steps = std::max(entry.steps.size(), entry.placements.size());
    const float brightness = bounds.power;
    bounds.power = 0;
    LightBounds cone;
    std::size_t controls = 0;
    float sum = 0;
    const auto turn = [&](const Vec3 &cross) {
        ++controls;
        const float length = glm::length(cross);
        if (!(length > 0)) return;
        sum += 0.5F * length;
        LightBounds one = bounds;
        one.axis = cross * ((entry.mirrored ? -1.0F : 1.0F) / length);
        one.power = 1;
        cone = united(cone, one);
    };
    Vec3 before1(0);
    Vec3 before2(0);
    for (std::size_t step = 0; step < steps; ++step) {
        const float time = steps == 1 ? 0.0F : static_cast<float>(step) / static_cast<float>(steps - 1);
        const Vec3 a = emitterPosition(entry, t.x, time);
        const Vec3 b = emitterPosition(entry, t.y, time);
        const Vec3 c = emitterPosition(entry, t.z, time);
        for (const Vec3 &corner : {a, b, c}) include(bounds, corner);
        const Vec3 e1 = b - a;
        const Vec3 e2 = c - a;
        if (step > 0) turn(0.5F * (glm::cross(before1, e2) + glm::cross(e1, before2)));
        turn(glm::cross(e1, e2));
        before1 = e1;
        before2 = e2;
    }
    if (!(sum > 0)) return;
    bounds.axis = cone.axis;
    bounds.cosSpread = cone.cosSpread < 0 ? -1.0F : cone.cosSpread; // wider than a half space, sums may point anywhere
    bounds.power = brightness * sum / static_cast<float>(controls);
}

} // namespace

LightBounds boundsOf(const LightEntry &entry, Index triangle) {
    LightBounds bounds;
    bounds.power = luminance(entry.radiance);
    bounds.twoSided = entry.twoSided;
    bounds.met = entry.kind == LightKind::Quad || entry.kind == LightKind::Sphere;
    switch (entry.kind) {
    case LightKind::Quad: boundQuad(entry, bounds); break;
    case LightKind::Spot: boundSpot(entry, bounds); break;
    case LightKind::Mesh: boundTriangle(entry, triangle, bounds); break;
    default: // sphere, point
        include(bounds, entry.origin - entry.radius);
        include(bounds, entry.origin + entry.radius);
        if (entry.kind == LightKind::Sphere) bounds.power *= kPi * sqr(entry.radius);
        bounds.cosSpread = -1;
    }
    if (entry.kind != LightKind::Sphere && entry.kind != LightKind::Quad) return bounds;
    bounds.power = std::max(bounds.power, 1e-30F); // a black one may still be seen
    return bounds;
}

} // namespace taut
