#pragma once
/// A ball that shines outward.

#include "taut/base/frame.h"
#include "taut/scene/lights/light.h"

namespace taut {

/// Light::radiance is its radiance.
struct SphereLight {
    static constexpr std::string_view kName = "sphere";
    DVec3 centre{0};
    double radius = 0.1;

    template <class Keys> void read(Keys &keys) {
        keys.brightness("radiance");
        keys.cameraVisible();
        keys.vector("centre", centre);
        keys.length("radius", radius);
    }
    [[nodiscard]] LightOutline outline() const { return {Vec3(centre), static_cast<float>(radius), Vec3(0), 0}; }
};

struct PlacedSphere {
    Vec3 centre;
    float radius;
    bool operator==(const PlacedSphere &) const = default;

    [[nodiscard]] float importance(float strength, const Receiver &at) const {
        return strength * kPi * std::min(2.0F, sqr(radius) * inverseDistance2(centre, at.position));
    }

    /// 1 - cos of the half angle under which it is seen, without cancellation; 2 from inside.
    [[nodiscard]] float cap(const Vec3 &point) const {
        const Vec3 d = centre - point;
        const float sin2 = sqr(radius) / glm::dot(d, d);
        if (!(sin2 < 1)) return 2;
        return sin2 / (1 + std::sqrt(1 - sin2));
    }

    /// Uniform in the cone under which it is seen.
    [[nodiscard]] LightSample sample(const Vec3 &radiance, const Vec3 &point, const Vec2 &number) const {
        LightSample s;
        const Vec3 toCentre = centre - point;
        const float seen = cap(point);
        if (seen >= 2) return s; // from inside: left to scattered rays
        const float oneMinusCos = number.x * seen;
        const float sine = std::sqrt(std::max(0.0F, oneMinusCos * (2 - oneMinusCos)));
        const float phi = 2 * kPi * number.y;
        const float centreDistance = glm::length(toCentre);
        const Frame frame = smoothFrameFromNormal(toCentre / centreDistance);
        s.direction = glm::normalize(frame.fromLocal({sine * std::cos(phi), sine * std::sin(phi), 1 - oneMinusCos}));
        const float along = glm::dot(toCentre, s.direction);
        const float discriminant = sqr(radius) - (glm::dot(toCentre, toCentre) - along * along);
        s.distance = along - std::sqrt(std::max(0.0F, discriminant));
        s.radiance = radiance;
        s.pdf = 1 / (2 * kPi * seen);
        return s;
    }

    [[nodiscard]] ShapeHit meet(const Vec3 &origin, const Vec3 &direction, float farthest) const {
        const Vec3 toCentre = centre - origin;
        const float along = glm::dot(toCentre, direction);
        const Vec3 closest = toCentre - direction * along; // perpendicular offset: no cancellation far away
        const float discriminant = sqr(radius) - glm::dot(closest, closest);
        if (discriminant < 0) return {};
        const float t = along - std::sqrt(discriminant);
        return t > 0 && t < farthest ? ShapeHit{t, 1} : ShapeHit{};
    }

    [[nodiscard]] float hitPdf(float choice, const Vec3 &point, const ShapeHit & /*hit*/) const {
        const float seen = cap(point);
        return seen < 2 ? choice / (2 * kPi * seen) : 0;
    }

    [[nodiscard]] LightBounds bounds(float strength) const {
        LightBounds b;
        include(b, centre - radius);
        include(b, centre + radius);
        b.cosSpread = -1;
        b.power = strength * (kPi * sqr(radius));
        return b;
    }
};

inline PlacedSphere place(const SphereLight &light, const DMat4 &renderFromWorld) {
    return {placedPoint(renderFromWorld, light.centre), static_cast<float>(light.radius)};
}

} // namespace taut
