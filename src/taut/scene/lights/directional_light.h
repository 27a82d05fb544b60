#pragma once
/// Light from one direction, the same everywhere.

#include "taut/scene/lights/light.h"

namespace taut {

/// Light::radiance is the irradiance on a plane that faces it.
struct DirectionalLight {
    static constexpr std::string_view kName = "directional";
    DVec3 direction{0, 0, -1}; ///< the way the light travels, unit

    template <class Keys> void read(Keys &keys) {
        keys.direction("direction", direction);
        keys.brightness("irradiance");
    }
};

struct PlacedDirectional {
    Vec3 direction;
    bool operator==(const PlacedDirectional &) const = default;

    [[nodiscard]] float importance(float strength, const Receiver &at) const {
        return strength * received(at, -direction, 1, Vec3(0), 0, 1);
    }
    [[nodiscard]] LightSample sample(const Vec3 &radiance, const Vec3 & /*point*/, const Vec2 & /*number*/) const {
        return {-direction, kInfinity, radiance, 1, true};
    }
};

inline PlacedDirectional place(const DirectionalLight &light, const DMat4 &renderFromWorld) {
    return {glm::normalize(placedVector(renderFromWorld, light.direction))};
}

} // namespace taut
