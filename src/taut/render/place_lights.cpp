#include "taut/render/place_lights.h"

namespace taut {

namespace {

LightEntry placed(const Light &light, const DMat4 &renderFromWorld) {
    LightEntry entry;
    entry.radiance = light.radiance;
    entry.cameraVisible = light.cameraVisible;
    std::visit([&](const auto &shape) { entry.shape = place(shape, renderFromWorld); }, light.shape);
    return entry;
}

/// A textured emitter is met by scattered rays alone: its texture is not part of the light table. Nor is where an emitter is absent.
bool isSampled(const RenderObject &object) {
    const ColorParam &emission = object.object->emission;
    return emission.value != Vec3(0) && emission.texture == kNone && !object.mayBeAbsent;
}

LightEntry emitter(const RenderObject &object) {
    LightEntry entry;
    entry.radiance = object.object->emission.value;
    entry.shape = MeshEmitter{object.steps,    object.placements, object.surface.triangles, object.object->emissionTwoSided,
                              object.mirrored, object.turned};
    return entry;
}

/// Whether two lights are chosen alike.
bool isSame(const LightEntry &a, const LightEntry &b) {
    return a.radiance == b.radiance && a.shape == b.shape;
}

} // namespace

bool placeLights(const Scene &scene, std::span<const RenderObject> objects, const DMat4 &worldFromRender, const DMat4 &renderFromWorld,
                 LightTable &table) {
    std::vector<LightEntry> entries;
    table.worldFromRender = Mat3(DMat3(worldFromRender));
    table.environment = scene.environment && scene.environment->mean != Vec3(0) ? &*scene.environment : nullptr;
    table.environmentEntry = kNone;
    // Scattered rays sample what they weigh a constant sky with; aiming at it would only add shadow rays.
    if (table.environment != nullptr && !table.environment->constant) {
        table.environmentEntry = 0;
        entries.push_back({});
        entries.back().shape = EnvironmentLight{table.environment, table.worldFromRender};
    }
    for (const Light &light : scene.lights) entries.push_back(placed(light, renderFromWorld));
    bool moved = false;
    table.entryOfObject.assign(objects.size(), kNone);
    for (std::size_t i = 0; i < objects.size(); ++i) {
        if (!isSampled(objects[i])) continue;
        table.entryOfObject[i] = static_cast<Index>(entries.size());
        entries.push_back(emitter(objects[i]));
        moved |= objects[i].moved;
    }
    const bool kept = !moved && std::equal(entries.begin(), entries.end(), table.entries.begin(), table.entries.end(), isSame);
    for (std::size_t i = 0; kept && i < entries.size(); ++i) entries[i].firstPart = table.entries[i].firstPart;
    table.entries = std::move(entries);
    if (!kept) prepareChoice(table);
    return kept;
}

} // namespace taut
