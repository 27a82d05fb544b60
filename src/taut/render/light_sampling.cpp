#include "taut/render/lights.h"

namespace taut {

LightSample sampleLight(const LightTable &table, const LightChoice &choice, const Vec3 &point, float time, const Vec2 &number) {
    if (choice.entry == kNone) return {};
    const LightEntry &entry = table.entries[choice.entry];
    LightSample s = std::visit(
        [&](const auto &light) {
            if constexpr (requires { light.sample(entry.radiance, point, number); })
                return light.sample(entry.radiance, point, number);
            else
                return sampleEmitter(light, choice.triangle, entry.radiance, point, time, number);
        },
        entry.shape);
    s.pdf *= choice.probability;
    return s;
}

} // namespace taut
