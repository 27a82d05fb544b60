#pragma once
/// A point that shines within a cone.

#include "taut/scene/lights/light.h"

namespace taut {

/// Light::radiance is its intensity within the inner cone.
struct SpotLight {
    static constexpr std::string_view kName = "spot";
    DVec3 position{0};
    DVec3 direction{0, 0, -1}; ///< the way the light travels, unit
    double innerAngle = 0;     ///< half angles, radians
    double outerAngle = 0.785398;

    template <class Keys> void read(Keys &keys) {
        keys.vector("position", position);
        keys.brightness("intensity");
        keys.direction("direction", direction);
        keys.coneAngle("inner_deg", innerAngle);
        keys.coneAngle("outer_deg", outerAngle);
    }
    [[nodiscard]] std::optional<LightFault> fault() const {
        if (innerAngle < outerAngle) return std::nullopt;
        return LightFault{"inner_deg not below outer_deg", "0 <= inner_deg < outer_deg <= 90"};
    }
    [[nodiscard]] LightOutline outline() const { return {Vec3(position), 0, Vec3(direction), static_cast<float>(std::cos(outerAngle))}; }
};

struct PlacedSpot {
    Vec3 position, direction;
    float cosInner, cosOuter;
    bool operator==(const PlacedSpot &) const = default;

    [[nodiscard]] float importance(float strength, const Receiver &at) const { return strength * inverseDistance2(position, at.position); }

    [[nodiscard]] LightSample sample(const Vec3 &intensity, const Vec3 &point, const Vec2 & /*number*/) const {
        return sampleOfPlace(intensity, position, point, [&](const Vec3 &towards) {
            const float cosine = -glm::dot(towards, direction);
            // KHR_lights_punctual: linear in the cosine between the cones, squared.
            return sqr(glm::clamp((cosine - cosOuter) / std::fmax(1e-4F, cosInner - cosOuter), 0.0F, 1.0F));
        });
    }

    [[nodiscard]] LightBounds bounds(float strength) const {
        const float inner = std::acos(glm::clamp(cosInner, -1.0F, 1.0F));
        const float outer = std::max(inner, std::acos(glm::clamp(cosOuter, -1.0F, 1.0F)));
        // Light fades out between the cones; where that is over more than a right angle, the inner one is taken for wider.
        const float spread = std::max(inner, outer - 0.5F * kPi);
        LightBounds b;
        include(b, position);
        b.axis = direction;
        b.cosSpread = std::cos(spread);
        b.cosReach = std::cos(outer - spread);
        b.power = strength;
        return b;
    }
};

inline PlacedSpot place(const SpotLight &light, const DMat4 &renderFromWorld) {
    return {placedPoint(renderFromWorld, light.position), glm::normalize(placedVector(renderFromWorld, light.direction)),
            static_cast<float>(std::cos(light.innerAngle)), static_cast<float>(std::cos(light.outerAngle))};
}

} // namespace taut
