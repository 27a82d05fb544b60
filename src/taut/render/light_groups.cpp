#include "taut/render/light_groups.h"

#include "taut/render/matte_id.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <cstdio>

namespace taut {

namespace {

constexpr const char *kEmission = "emission";
constexpr const char *kEnvironment = "environment";

std::string groupName(const Scene &scene, const Light &light) {
    if (light.group != kNone) return scene.lightGroups[light.group];
    return std::visit([](const auto &shape) { return std::string(shape.kName); }, light.shape);
}

std::string groupName(const Scene &scene, const Object &object, Index slot) {
    Index group = emissionOf(object, slot).group;
    if (group == kNone) group = object.emissionGroup;
    return group == kNone ? kEmission : scene.lightGroups[group];
}

std::size_t slotsOf(const Object &object) {
    return std::max<std::size_t>(object.slotEmission.size(), 1);
}

std::string hexOf(std::uint32_t id) {
    std::array<char, 9> text{};
    std::snprintf(text.data(), text.size(), "%08x", id);
    return text.data();
}

Metadata metadataOf(const std::string &layer, const nlohmann::json &manifest) {
    const std::string key = "cryptomatte/" + hexOf(murmurHash3(layer)).substr(0, 7) + "/";
    return {{key + "name", layer},
            {key + "hash", "MurmurHash3_32"},
            {key + "conversion", "uint32_to_float32"},
            {key + "manifest", manifest.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace)}};
}

} // namespace

std::vector<std::string> lightGroupNames(const Scene &scene) {
    std::vector<std::string> names{kEmission, kEnvironment};
    const auto add = [&](const std::string &name) {
        if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
    };
    for (const Light &light : scene.lights) add(groupName(scene, light));
    for (const Object &object : scene.objects)
        for (Index slot = 0; slot < slotsOf(object); ++slot) add(groupName(scene, object, slot));
    return names;
}

FilmLayers layersOf(FilmLayers asked, const Scene &scene) {
    if (asked.lights) asked.lightGroups = lightGroupNames(scene);
    return asked;
}

LayerTables layerTables(const RenderScene &ready, const FilmLayers &layers) {
    const Scene &scene = ready.scene();
    LayerTables tables;
    tables.hasIds = layers.objects || layers.materials;
    if (tables.hasIds) {
        for (Index i = 0; i < scene.objects.size(); ++i) tables.objectIds.push_back(matteId(matteName(scene, i)));
        for (Index i = 0; i <= scene.materials.size(); ++i) tables.materialIds.push_back(matteId(materialMatteName(scene, i)));
    }
    if (!layers.lights) return tables;
    const std::vector<std::string> &names = layers.lightGroups;
    const auto groupOf = [&](const std::string &name) { return static_cast<Index>(std::find(names.begin(), names.end(), name) - names.begin()); };
    tables.groups = names.size();
    tables.environment = groupOf(kEnvironment);
    for (const Object &object : scene.objects) {
        tables.objects.emplace_back();
        for (Index slot = 0; slot < slotsOf(object); ++slot) tables.objects.back().push_back(groupOf(groupName(scene, object, slot)));
    }
    // The order of placeLights(): the sky, where it is aimed at, the lights, what emits.
    const LightTable &lights = ready.lights();
    if (lights.environmentEntry != kNone) tables.entries.push_back(tables.environment);
    for (const Light &light : scene.lights) tables.entries.push_back(groupOf(groupName(scene, light)));
    tables.entries.resize(lights.entries.size());
    for (Index i = 0; i < lights.emitters.size(); ++i)
        for (const EmitterRun &run : lights.emitters[i]) {
            const std::vector<Index> &slots = tables.objects[i];
            const Index slot = slotOfTriangle(ready.objects()[i], run.first);
            tables.entries[run.entry] = slots[std::min<std::size_t>(slot, slots.size() - 1)];
        }
    return tables;
}

std::string matteName(const Scene &scene, Index object) {
    const std::string &name = scene.objects[object].name;
    return name.empty() ? "object " + std::to_string(object) : name;
}

std::string materialMatteName(const Scene &scene, Index material) {
    const std::string &name = scene.materialAt(material).name;
    return name.empty() ? "material " + std::to_string(material) : name;
}

Metadata matteMetadata(const Scene &scene, const FilmLayers &layers) {
    Metadata metadata;
    const auto add = [&](const std::string &layer, std::size_t count, const auto &nameOf) {
        nlohmann::json manifest = nlohmann::json::object();
        for (Index i = 0; i < count; ++i) {
            const std::string name = nameOf(scene, i);
            manifest[name] = hexOf(matteId(name));
        }
        const Metadata added = metadataOf(layer, manifest);
        metadata.insert(metadata.end(), added.begin(), added.end());
    };
    if (layers.objects) add("CryptoObject", scene.objects.size(), matteName);
    if (layers.materials) add("CryptoMaterial", scene.materials.size(), materialMatteName);
    return metadata;
}

} // namespace taut
