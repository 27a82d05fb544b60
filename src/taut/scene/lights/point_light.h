#pragma once
/// A point that shines to all sides alike.

#include "taut/scene/lights/light.h"

namespace taut {

/// Light::radiance is its intensity.
struct PointLight {
    static constexpr std::string_view kName = "point";
    DVec3 position{0};

    template <class Keys> void read(Keys &keys) {
        keys.vector("position", position);
        keys.brightness("intensity");
    }
    [[nodiscard]] LightOutline outline() const { return {Vec3(position), 0, Vec3(0), 0}; }
};

struct PlacedPoint {
    Vec3 position;
    bool operator==(const PlacedPoint &) const = default;

    [[nodiscard]] float importance(float strength, const Receiver &at) const { return strength * inverseDistance2(position, at.position); }

    [[nodiscard]] LightSample sample(const Vec3 &intensity, const Vec3 &point, const Vec2 & /*number*/) const {
        return sampleOfPlace(intensity, position, point, [](const Vec3 &) { return 1.0F; });
    }

    [[nodiscard]] LightBounds bounds(float strength) const {
        constexpr float kHalfBox = 0.1F; // nearer than that, the tree counts it as no brighter
        LightBounds b;
        include(b, position - kHalfBox);
        include(b, position + kHalfBox);
        b.cosSpread = -1;
        b.power = strength;
        return b;
    }
};

inline PlacedPoint place(const PointLight &light, const DMat4 &renderFromWorld) {
    return {placedPoint(renderFromWorld, light.position)};
}

} // namespace taut
