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
bool isSampled(const RenderObject &object, const Emission &emission) {
    return emission.radiance.value != Vec3(0) && emission.radiance.texture == kNone && !object.mayBeAbsent;
}

LightEntry emitter(const RenderObject &object, const Emission &emission, const EmitterRun &run) {
    LightEntry entry;
    entry.radiance = emission.radiance.value;
    const auto triangles = std::span<const Index3>(object.surface.triangles).subspan(run.first, run.count);
    const std::span<const unsigned char> turned =
        object.turned.empty() ? std::span<const unsigned char>() : std::span(object.turned).subspan(run.first, run.count);
    entry.shape = MeshEmitter{object.steps, object.placements, triangles, emission.twoSided, object.mirrored, turned};
    return entry;
}

/// The entries of one object: a run of triangles of one slot each, of all triangles where the object shines as a whole.
std::vector<EmitterRun> addEmitters(const RenderObject &object, std::vector<LightEntry> &entries) {
    std::vector<EmitterRun> runs;
    const auto count = static_cast<Index>(object.surface.triangles.size());
    const bool whole = object.object->slotEmission.empty() || object.surface.triangleSlots.empty();
    for (Index first = 0; first < count;) {
        const Index slot = slotOfTriangle(object, first);
        Index end = whole ? count : first + 1;
        while (!whole && end < count && slotOfTriangle(object, end) == slot) ++end;
        if (const Emission emission = emissionOf(*object.object, slot); isSampled(object, emission)) {
            runs.push_back({first, end - first, static_cast<Index>(entries.size())});
            entries.push_back(emitter(object, emission, runs.back()));
        }
        first = end;
    }
    return runs;
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
    table.emitters.assign(objects.size(), {});
    for (std::size_t i = 0; i < objects.size(); ++i) {
        if (!emits(*objects[i].object)) continue;
        table.emitters[i] = addEmitters(objects[i], entries);
        moved |= objects[i].moved && !table.emitters[i].empty();
    }
    const bool kept = !moved && std::equal(entries.begin(), entries.end(), table.entries.begin(), table.entries.end(), isSame);
    for (std::size_t i = 0; kept && i < entries.size(); ++i) entries[i].firstPart = table.entries[i].firstPart;
    table.entries = std::move(entries);
    if (!kept) prepareChoice(table);
    return kept;
}

} // namespace taut
