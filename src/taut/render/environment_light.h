#pragma once
/// The sky as a light to aim at.

#include "taut/scene/environment.h"
#include "taut/scene/lights/light.h"

namespace taut {

struct EnvironmentLight {
    const Environment *environment;
    Mat3 worldFromRender; ///< rotation
    bool operator==(const EnvironmentLight &) const = default;

    [[nodiscard]] float importance(float /*strength*/, const Receiver & /*at*/) const { return luminance(environment->mean) * kPi; }

    [[nodiscard]] LightSample sample(const Vec3 & /*radiance*/, const Vec3 & /*point*/, const Vec2 &number) const {
        const EnvironmentSample e = sampleEnvironment(*environment, number);
        // Transposed: render from world. A constant sky is the same any way round and stays in render space, where a rigid motion
        // of camera and scene leaves no trace.
        return {environment->constant ? e.direction : e.direction * worldFromRender, kInfinity, e.radiance, e.pdf, false};
    }
};

} // namespace taut
