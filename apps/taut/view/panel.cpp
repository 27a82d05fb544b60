#include "panel.h"

#include "taut/bsdf/metals.h"
#include "taut/scene/ranges.h"
#include "taut/scene/table_reader.h"

#include <algorithm>
#include <filesystem>

namespace taut::app {

namespace {

using Json = nlohmann::json;

/// How far a slider goes.
struct Slider {
    double lower, upper, step;
};
constexpr Slider kAlphaSlider{0.001, 1, 0.001};
constexpr Slider kAngleSlider{-180, 180, 1};
constexpr Slider kUnitSlider{0, 1, 0.01};
constexpr Slider kPoissonSlider{kPoisson.lower, kPoisson.upper, 0.01};
constexpr Slider kAmountSlider{-2, 2, 0.01};
constexpr Slider kFactorSlider{0.25, 4, 0.01};
constexpr Slider kBendSlider{-360, 360, 1};
constexpr Slider kLengthSlider{0.01, 4, 0.01};
constexpr Slider kLightSlider{0, 200, 0.1};

/// What a value in a scene file is as JSON: a number, or numbers; null where it is something else.
Json numbersOf(const TomlValue &value) {
    if (value.kind == TomlValue::Kind::Integer || value.kind == TomlValue::Kind::Number) return value.number;
    if (value.kind != TomlValue::Kind::Array || value.items.empty() || value.items.size() > 4) return nullptr;
    Json out = Json::array();
    for (const TomlValue &item : value.items) {
        if (item.kind != TomlValue::Kind::Integer && item.kind != TomlValue::Kind::Number) return nullptr;
        out.push_back(item.number);
    }
    return out;
}

/// A keyed value between its keys.
Json valueAt(const TomlValue &keys, double frame) {
    const auto number = [](const TomlValue &key) { return key.items[0].number; };
    const auto after = std::find_if(keys.items.begin(), keys.items.end(), [&](const TomlValue &key) { return number(key) >= frame; });
    if (after == keys.items.begin()) return numbersOf(after->items[1]);
    if (after == keys.items.end()) return numbersOf(keys.items.back().items[1]);
    const TomlValue &before = *(after - 1);
    const double u = (frame - number(before)) / (number(*after) - number(before));
    const Json a = numbersOf(before.items[1]);
    const Json b = numbersOf(after->items[1]);
    if (a.is_number() && b.is_number()) return a.get<double>() * (1 - u) + b.get<double>() * u;
    if (!a.is_array() || !b.is_array() || a.size() != b.size()) return a;
    Json out = Json::array();
    for (std::size_t i = 0; i < a.size(); ++i) out.push_back(a[i].get<double>() * (1 - u) + b[i].get<double>() * u);
    return out;
}

class Panel {
  public:
    Panel(const SceneChanges &changes, int frame) : changes_(changes), frame_(frame) {}

    Json entries() {
        if (const TomlValue *meshes = changes_.tree().find("mesh"))
            for (std::size_t i = 0; i < meshes->items.size(); ++i) mesh(meshes->items[i], "mesh." + std::to_string(i));
        if (const TomlValue *materials = changes_.tree().find("material"))
            for (const TomlEntry &entry : materials->entries) material(entry.key);
        if (const TomlValue *lights = changes_.tree().find("light"))
            for (std::size_t i = 0; i < lights->items.size(); ++i) light(lights->items[i], i);
        environment();
        return std::move(entries_);
    }

  private:
    /// A number, or numbers, of the scene file; `otherwise` what they are where it does not say. A texture has no slider.
    void number(const std::string &key, const std::string &group, const std::string &label, const Slider &slider, const Json &otherwise) {
        const TomlValue *given = findKey(changes_.tree(), key);
        Json keyed;
        Json value = otherwise;
        if (given != nullptr && isKeyed(*given)) {
            keyed = Json::array();
            for (const TomlValue &k : given->items) keyed.push_back({k.items[0].number, numbersOf(k.items[1])});
            value = valueAt(*given, frame_);
        } else if (given != nullptr) {
            value = numbersOf(*given);
        }
        if (value.is_null()) return;
        entries_.push_back({{"key", key},
                            {"group", group},
                            {"label", label},
                            {"kind", value.is_array() ? "numbers" : "number"},
                            {"value", value},
                            {"min", slider.lower},
                            {"max", slider.upper},
                            {"step", slider.step},
                            {"keyed", keyed}});
    }

    void mesh(const TomlValue &table, const std::string &key) {
        const TomlValue *name = table.find("name");
        const TomlValue *file = table.find("file");
        const std::string group = name != nullptr ? name->text : file != nullptr ? std::filesystem::path(file->text).stem().string() : key;
        const TomlValue *follow = table.find("follow");
        entries_.push_back({{"key", key + ".follow"},
                            {"group", group},
                            {"label", "gloss follows"},
                            {"kind", "bool"},
                            {"value", follow == nullptr || follow->boolean},
                            {"keyed", nullptr}});
        const TomlValue *deformers = table.find("deform");
        if (deformers == nullptr) return;
        for (std::size_t j = 0; j < deformers->items.size(); ++j) {
            const TomlValue *type = deformers->items[j].find("type");
            const std::string kind = type != nullptr ? type->text : "stretch";
            const std::string deform = key + ".deform." + std::to_string(j) + ".";
            if (kind == "stretch") number(deform + "factor", group, "stretch", kFactorSlider, 1.0);
            if (kind == "shear" || kind == "taper") number(deform + "amount", group, kind, kAmountSlider, 0.0);
            if (kind == "bend" || kind == "twist") number(deform + "angle_deg", group, kind + ", degrees", kBendSlider, 0.0);
            if (kind != "wave") continue;
            number(deform + "amplitude", group, "wave, metres", {0, 1, 0.001}, 0.0);
            number(deform + "wavelength", group, "wavelength, metres", kLengthSlider, 1.0);
            number(deform + "phase_deg", group, "phase, degrees", kAngleSlider, 0.0);
        }
    }

    void material(const std::string &name) {
        const std::vector<Material> &all = changes_.scene().materials;
        const auto found = std::find_if(all.begin(), all.end(), [&](const Material &m) { return m.name == name; });
        if (found == all.end()) return;
        const Material &m = *found;
        const std::string key = "material." + name + ".";
        const BsdfInfo &info = bsdfInfo(m.type);
        const auto plain = [](const FloatParam &p, double unit = 1) { return p.texture == kNone ? Json(static_cast<double>(p.value) / unit) : Json(); };
        if (m.type == BsdfType::Metal) {
            Json names = Json::array();
            for (const Metal &metal : metals()) names.push_back(metal.name);
            const TomlValue *given = findKey(changes_.tree(), key + "metal");
            if (given != nullptr)
                entries_.push_back({{"key", key + "metal"}, {"group", name}, {"label", "metal"}, {"kind", "choice"}, {"value", given->text}, {"names", names}, {"keyed", nullptr}});
        } else {
            const Json color = m.color.texture == kNone ? Json{m.color.value.x, m.color.value.y, m.color.value.z} : Json();
            number(key + (info.reads(kF0Key) ? "f0" : "color"), name, info.reads(kF0Key) ? "reflectance" : "colour", kUnitSlider, color);
        }
        if (!info.microsurface) return;
        if (m.alphaIsRoughness)
            number(key + "roughness", name, "roughness", kUnitSlider, plain(m.alphaX));
        else
            number(key + "alpha", name, "alpha", kAlphaSlider, m.alphaX.value == m.alphaY.value ? plain(m.alphaX) : Json{m.alphaX.value, m.alphaY.value});
        if (info.reads(kMetallicKey)) number(key + "metallic", name, "metallic", kUnitSlider, plain(m.metallic));
        number(key + "rotation_deg", name, "rotation, degrees", kAngleSlider, plain(m.rotation, radians(1)));
        number(key + "poisson", name, "poisson", kPoissonSlider, static_cast<double>(m.poisson));
        number(key + "roughening", name, "roughening", {0, 4, 0.01}, static_cast<double>(m.roughening));
        number(key + "yield", name, "yield", {0, 0.5, 0.001}, static_cast<double>(m.yield));
    }

    void light(const TomlValue &table, std::size_t index) {
        const std::string group = "light " + std::to_string(index);
        const std::string key = "light." + std::to_string(index) + ".";
        for (const char *brightness : {"radiance", "irradiance", "intensity"})
            if (table.find(brightness) != nullptr) number(key + brightness, group, brightness, kLightSlider, nullptr);
        if (table.find("radius") != nullptr) number(key + "radius", group, "radius, metres", kLengthSlider, nullptr);
    }

    void environment() {
        const TomlValue *section = changes_.tree().find("environment");
        const bool lit = changes_.tree().find("light") != nullptr || changes_.scene().lights.size() > 0;
        if (section == nullptr && lit) return;
        number("environment.rotation_deg", "environment", "turn, degrees", kAngleSlider, 0.0);
        number("environment.scale", "environment", "scale", {0, 10, 0.01}, 1.0);
    }

    const SceneChanges &changes_;
    int frame_;
    Json entries_ = Json::array();
};

Json triple(const DVec3 &v) {
    return {v.x, v.y, v.z};
}

} // namespace

nlohmann::json panelOf(const SceneChanges &changes, int frame) {
    return Panel(changes, frame).entries();
}

nlohmann::json cameraOf(const Scene &scene, int frame) {
    const CameraState state = cameraAtFrame(scene.camera, frame, scene.render.fps);
    const Camera &camera = scene.camera;
    const DMat4 &m = state.worldFromCamera;
    const DVec3 there(m[3]);
    Json out{{"position", triple(camera.rig ? there : camera.position.at(frame))},
             {"look_at", triple(camera.rig ? there - std::max(state.focusDistance, 1e-3) * DVec3(m[2]) : camera.lookAt.at(frame))},
             {"up", triple(camera.rig ? DVec3(m[1]) : camera.up.at(frame))},
             {"aperture_radius", state.apertureRadius},
             {"focus_distance", camera.focusDistance.at(frame)}};
    if (state.orthoHeight > 0)
        out["ortho_height"] = state.orthoHeight;
    else
        out["fov_deg"] = glm::degrees(state.fovY);
    return out;
}

} // namespace taut::app
