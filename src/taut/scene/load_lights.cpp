/// The sections [[light]] of a scene file. What keys a light has is said by its kind (scene/lights/).

#include "taut/scene/load_context.h"

namespace taut {

namespace {

constexpr std::string_view kMesh = "mesh"; ///< the type of [[light]] that is no Light: objects emit
constexpr std::string_view kSlot = "slot"; ///< its key for one of a mesh's materials
constexpr std::string_view kGroup = "group";

/// The words for a light's keys: here they read a table.
struct LightKeys {
    TableReader &table;
    Light &light;

    void brightness(std::string_view key) { table.read(key, light.radiance, tripleIn(kNotNegative)); }
    void cameraVisible() { table.read("camera_visible", light.cameraVisible); }
    void vector(std::string_view key, DVec3 &target) { table.read(key, target, vec3In()); }
    void direction(std::string_view key, DVec3 &target) { table.read(key, target, toDirection); }
    void length(std::string_view key, double &target) { table.read(key, target, numberIn(kPositive)); }
    void coneAngle(std::string_view key, double &target) { table.read(key, target, numberIn(kConeAngle, radians(1))); }
    void flag(std::string_view key, bool &target) { table.read(key, target); }
};

/// The words again, to list all keys: those of each kind, its brightness after its shape, flags last.
struct KeyNames {
    std::vector<std::string_view> names{"type"}, flags;
    std::string_view brightnessKey;

    static void add(std::vector<std::string_view> &list, std::string_view key) {
        if (std::find(list.begin(), list.end(), key) == list.end()) list.push_back(key);
    }
    void brightness(std::string_view key) { brightnessKey = key; }
    void cameraVisible() { flag("camera_visible", false); }
    template <class T> void vector(std::string_view key, const T & /*target*/) { add(names, key); }
    template <class T> void direction(std::string_view key, const T & /*target*/) { add(names, key); }
    template <class T> void length(std::string_view key, const T & /*target*/) { add(names, key); }
    template <class T> void coneAngle(std::string_view key, const T & /*target*/) { add(names, key); }
    void flag(std::string_view key, bool /*target*/) { add(flags, key); }
};

std::vector<std::string_view> allKeys() {
    KeyNames keys;
    forEachLightShape([&](auto shape) {
        shape.read(keys);
        KeyNames::add(keys.names, keys.brightnessKey);
    });
    keys.names.push_back(kMesh);
    keys.names.push_back(kSlot);
    keys.names.push_back(kGroup);
    keys.names.insert(keys.names.end(), keys.flags.begin(), keys.flags.end());
    return keys.names;
}

/// Makes the faces of one material of an object shine; false where it has no such material.
bool setSlotEmission(Object &object, const std::string &slot, const Emission &emission) {
    const std::vector<std::string> &names = object.mesh->materialNames;
    const auto found = std::find(names.begin(), names.end(), slot);
    if (found == names.end()) return false;
    if (object.slotEmission.empty()) object.slotEmission.assign(names.size(), emissionOf(object, 0));
    object.slotEmission[static_cast<std::size_t>(found - names.begin())] = emission;
    return true;
}

void addMeshLight(LoadContext &context, TableReader &table) {
    const TomlValue &target = table.required("mesh", "mesh = \"name of a [[mesh]]\"");
    const TomlValue *slot = table.find(kSlot);
    Emission emission{{Vec3(1)}};
    table.read("radiance", emission.radiance, [&](const TomlValue &v) { return toColorParam(context, v, kNotNegative); });
    table.read("two_sided", emission.twoSided);
    if (const TomlValue *group = table.find(kGroup)) emission.group = lightGroup(context, *group);
    const std::string prefix = toText(target) + "/";
    bool found = false;
    bool slotFound = slot == nullptr;
    std::vector<std::string_view> slots;
    for (Object &object : context.scene.objects) {
        if (object.name != target.text && object.name.compare(0, prefix.size(), prefix) != 0) continue;
        found = true;
        if (slot != nullptr) {
            slotFound |= setSlotEmission(object, toText(*slot), emission);
            slots.insert(slots.end(), object.mesh->materialNames.begin(), object.mesh->materialNames.end());
        } else {
            object.emission = emission.radiance;
            object.emissionTwoSided = emission.twoSided;
            if (emission.group != kNone) object.emissionGroup = emission.group;
            object.slotEmission.clear();
        }
        context.meshLights |= emission.radiance.value != Vec3(0);
    }
    if (found && !slotFound && slots.empty()) failInput(slot->where, quoted(slot->text), "a mesh with several materials");
    if (found && !slotFound) failUnknownName(slot->where, slot->text, slots);
    if (found) return;
    if (context.scene.objects.empty()) failInput(target.where, quoted(target.text), "the name of a mesh, but there is no [[mesh]]");
    const std::vector<std::string_view> names(context.objectNames.begin(), context.objectNames.end());
    failUnknownName(target.where, target.text, names);
}

Light toLight(TableReader &table, const LightShape &kind) {
    Light light;
    light.shape = kind;
    std::visit(
        [&](auto &shape) {
            LightKeys keys{table, light};
            shape.read(keys);
            if constexpr (requires { shape.fault(); })
                if (const auto fault = shape.fault()) failInput(table.where(), fault->found, fault->expected);
        },
        light.shape);
    return light;
}

} // namespace

Index lightGroup(LoadContext &context, const TomlValue &value) {
    constexpr std::size_t kLongest = 40;
    const std::string &name = toText(value);
    const bool isName = !name.empty() && name.size() <= kLongest && std::all_of(name.begin(), name.end(), [](char c) {
        return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_';
    });
    if (!isName)
        failInput(value.where, quoted(name), "a name of 1 to 40 letters of ASCII, digits and underscores, which layers of images may have");
    std::vector<std::string> &groups = context.scene.lightGroups;
    const auto found = std::find(groups.begin(), groups.end(), name);
    if (found != groups.end()) return static_cast<Index>(found - groups.begin());
    groups.push_back(name);
    return static_cast<Index>(groups.size() - 1);
}

void loadLights(LoadContext &context, const TomlValue &section) {
    if (section.kind != TomlValue::Kind::Array) failInput(section.where, describe(section), "tables [[light]]");
    Names<std::optional<LightShape>> kinds;
    forEachLightShape([&](const auto &shape) { kinds.emplace_back(shape.kName, shape); });
    kinds.emplace_back(kMesh, std::nullopt);
    const std::vector<std::string_view> keys = allKeys();
    for (const TomlValue &entry : section.items) {
        TableReader table(entry, "[[light]]", keys);
        std::optional<LightShape> kind = LightShape();
        table.read("type", kind, oneOf(kinds));
        if (kind) {
            context.scene.lights.push_back(toLight(table, *kind));
            if (const TomlValue *group = table.find(kGroup)) context.scene.lights.back().group = lightGroup(context, *group);
        } else {
            addMeshLight(context, table);
        }
        table.finish();
    }
}

} // namespace taut
