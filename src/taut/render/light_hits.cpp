#include "taut/render/lights.h"

namespace taut {

LightHit intersectLight(const LightTable &table, Index index, const Vec3 &origin, const Vec3 &direction, float farthest) {
    return std::visit(
        [&](const auto &light) -> LightHit {
            if constexpr (requires { light.meet(origin, direction, farthest); }) {
                const ShapeHit hit = light.meet(origin, direction, farthest);
                return {hit, hit.t < kInfinity ? index : kNone};
            } else {
                return {};
            }
        },
        table.entries[index].shape);
}

float lightHitPdf(const LightTable &table, const LightHit &hit, const Receiver &at) {
    const float choice = choiceProbability(table, {hit.entry, 0}, at);
    return std::visit(
        [&](const auto &light) {
            if constexpr (requires { light.hitPdf(choice, at.position, hit); })
                return light.hitPdf(choice, at.position, hit);
            else
                return 0.0F;
        },
        table.entries[hit.entry].shape);
}

float emitterHitPdf(const LightTable &table, const LightPart &part, const Receiver &at, float time, float t, float absCosine) {
    const float area = emitterArea(std::get<MeshEmitter>(table.entries[part.entry].shape), part.triangle, time);
    return absCosine * area > 0 ? choiceProbability(table, part, at) * t * t / (absCosine * area) : 0;
}

} // namespace taut
