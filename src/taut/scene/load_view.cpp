/// The sections of a scene file that say how it is seen: [render], [camera], [environment] and [[light]].

#include "taut/base/frame_set.h"
#include "taut/scene/load_context.h"

namespace taut {

namespace {

std::vector<int> toFrames(const TomlValue &value) {
    if (value.kind == TomlValue::Kind::Integer) return {static_cast<int>(toInteger(value, kFrameNumber))};
    return parseFrameSet(toText(value), value.where);
}

/// The camera node that [camera] names, else the first.
Index cameraNode(const GltfFile &file, const TomlValue *name, const Location &where) {
    if (name == nullptr) {
        const Index first = firstCameraNode(file);
        if (first == kNone) failInput(where, "no perspective camera in " + file.path, "a glTF file with one");
        return first;
    }
    std::vector<std::string_view> names;
    for (const Index index : file.sceneNodes) {
        const Index camera = file.attached[index].camera;
        if (camera == kNone || !file.cameras[camera].perspective) continue;
        const std::string &nodeName = file.rig.nodes[index].name;
        if (nodeName == toText(*name)) return index;
        names.push_back(nodeName);
    }
    if (names.empty()) failInput(name->where, quoted(name->text), "a perspective camera's node, but " + file.path + " has none");
    failUnknownName(name->where, name->text, names);
}

void setGltfCamera(Camera &camera, const GltfFile &file, RigMotion motion, Index node) {
    motion.node = node;
    camera.fovY = Keyed<double>(static_cast<double>(file.cameras[file.attached[node].camera].yFov));
    camera.rig = std::move(motion);
}

DVec3 toRadiance(const TomlValue &value) {
    return toTriple(value, kNotNegative);
}

enum class LightKey { Quad, Sphere, Directional, Point, Spot, Mesh };

void addMeshLight(LoadContext &context, TableReader &table) {
    const TomlValue &target = table.required("mesh", "mesh = \"name of a [[mesh]]\"");
    ColorParam radiance{Vec3(1)};
    bool twoSided = false;
    table.read("radiance", radiance, [&](const TomlValue &v) { return toColorParam(context, v, kNotNegative); });
    table.read("two_sided", twoSided);
    const std::string prefix = toText(target) + "/";
    bool found = false;
    for (Object &object : context.scene.objects) {
        if (object.name != target.text && object.name.compare(0, prefix.size(), prefix) != 0) continue;
        object.emission = radiance;
        object.emissionTwoSided = twoSided;
        found = true;
    }
    if (found) return;
    if (context.scene.objects.empty()) failInput(target.where, quoted(target.text), "the name of a mesh, but there is no [[mesh]]");
    const std::vector<std::string_view> names(context.objectNames.begin(), context.objectNames.end());
    failUnknownName(target.where, target.text, names);
}

Light toLight(TableReader &table, LightKey kind) {
    Light light;
    const bool isQuad = kind == LightKey::Quad;
    if (isQuad || kind == LightKey::Sphere) {
        table.read("radiance", light.radiance, toRadiance);
        table.read("camera_visible", light.cameraVisible);
    }
    switch (kind) {
    case LightKey::Mesh: // not a Light: addMeshLight
    case LightKey::Quad:
        light.type = LightType::Quad;
        table.read("corner", light.corner, vec3In());
        table.read("u", light.u, vec3In());
        table.read("v", light.v, vec3In());
        table.read("two_sided", light.twoSided);
        failOn(table.where(), mistakeInQuad(light));
        return light;
    case LightKey::Sphere:
        light.type = LightType::Sphere;
        table.read("centre", light.corner, vec3In());
        table.read("radius", light.radius, numberIn(kPositive));
        return light;
    case LightKey::Directional:
        light.type = LightType::Directional;
        table.read("direction", light.direction, toDirection);
        table.read("irradiance", light.radiance, toRadiance);
        return light;
    case LightKey::Point:
    case LightKey::Spot:
        light.type = kind == LightKey::Spot ? LightType::Spot : LightType::Point;
        table.read("position", light.corner, vec3In());
        table.read("intensity", light.radiance, toRadiance);
        if (kind == LightKey::Point) return light;
        table.read("direction", light.direction, toDirection);
        table.read("inner_deg", light.innerAngle, numberIn(kConeAngle, radians(1)));
        table.read("outer_deg", light.outerAngle, numberIn(kConeAngle, radians(1)));
        if (!(light.innerAngle < light.outerAngle))
            failInput(table.where(), "inner_deg not below outer_deg", "0 <= inner_deg < outer_deg <= 90");
        return light;
    }
    return light;
}

} // namespace

void loadRender(const TomlValue &section, RenderSettings &render) {
    TableReader table(section, "[render]",
                      {"width", "height", "spp", "max_events", "frames", "fps", "seed", "fixed_seed", "filter", "shutter", "motion_steps"});
    table.read("width", render.width, integerIn(kImageSide));
    table.read("height", render.height, integerIn(kImageSide));
    table.read("spp", render.spp, integerIn(kSpp));
    table.read("max_events", render.maxEvents, integerIn(kMaxEvents));
    table.read("frames", render.frames, toFrames);
    table.read("fps", render.fps, numberIn(kFps));
    table.read("seed", render.seed, integerIn(kSeed));
    table.read("fixed_seed", render.fixedSeed);
    table.read("shutter", render.shutter, numberIn(kShutter));
    table.read("motion_steps", render.motionSteps, integerIn(kMotionSteps));
    table.read("filter", render.boxFilter, oneOf<bool>({{"blackman-harris", false}, {"box", true}}));
}

void loadLights(LoadContext &context, const TomlValue &section) {
    if (section.kind != TomlValue::Kind::Array) failInput(section.where, describe(section), "tables [[light]]");
    for (const TomlValue &entry : section.items) {
        TableReader table(entry, "[[light]]",
                          {"type", "corner", "u", "v", "radiance", "centre", "radius", "direction", "irradiance", "position", "intensity",
                           "inner_deg", "outer_deg", "mesh", "camera_visible", "two_sided"});
        LightKey kind = LightKey::Quad;
        table.read("type", kind,
                   oneOf<LightKey>({{"quad", LightKey::Quad},
                                    {"sphere", LightKey::Sphere},
                                    {"directional", LightKey::Directional},
                                    {"point", LightKey::Point},
                                    {"spot", LightKey::Spot},
                                    {"mesh", LightKey::Mesh}}));
        if (kind == LightKey::Mesh)
            addMeshLight(context, table);
        else
            context.scene.lights.push_back(toLight(table, kind));
        table.finish();
    }
}

void loadEnvironment(LoadContext &context, const TomlValue &section) {
    TableReader table(section, "[environment]", {"file", "radiance", "preset", "rotation_deg", "scale", "camera_visible"});
    table.exclusive("file", "radiance");
    table.exclusive("file", "preset");
    table.exclusive("radiance", "preset");
    double rotation = 0;
    DVec3 scale(1);
    bool cameraVisible = true;
    table.read("rotation_deg", rotation, numberIn(kDegrees, radians(1)));
    table.read("scale", scale, tripleIn(kNotNegative));
    table.read("camera_visible", cameraVisible);
    Environment environment;
    if (const TomlValue *file = table.find("file")) {
        environment = readEnvironment(filePath(context, *file), rotation, Vec3(scale));
    } else if (const TomlValue *radiance = table.find("radiance")) {
        environment = constantEnvironment(Vec3(toRadiance(*radiance) * scale));
    } else {
        int preset = 0;
        table.read("preset", preset, oneOf<int>({{"studio", 0}}));
        environment = studioEnvironment();
        for (Vec3 &texel : environment.texels) texel *= Vec3(scale);
        if (scale != DVec3(1)) buildSampling(environment);
    }
    table.finish();
    environment.rotation = rotation;
    environment.cameraVisible = cameraVisible;
    context.scene.environment = std::move(environment);
}

void loadCamera(LoadContext &context, const TomlValue *section, const std::string &fallbackGltf) {
    const TomlValue none;
    TableReader table(section != nullptr ? *section : none, "[camera]",
                      {"position", "look_at", "up", "fov_deg", "aperture_radius", "focus_distance", "gltf", "node", "clip", "loop",
                       "translate", "rotate_deg", "scale"});
    Camera &camera = context.scene.camera;
    table.exclusive("gltf", "position");
    table.exclusive("gltf", "look_at");
    table.exclusive("gltf", "up");
    const bool aimed = table.find("position") != nullptr || table.find("look_at") != nullptr;
    if (const TomlValue *path = table.find("gltf")) {
        const std::shared_ptr<const GltfFile> file = gltfFile(context, filePath(context, *path));
        const Index node = cameraNode(*file, table.find("node"), path->where);
        setGltfCamera(camera, *file, loadGltfMotion(table, file), node);
        camera.placement = loadPlacement(table, true);
    } else if (!aimed && !fallbackGltf.empty()) {
        TableReader nothing(none, "", {});
        const std::shared_ptr<const GltfFile> file = gltfFile(context, fallbackGltf);
        const Index node = firstCameraNode(*file);
        if (node != kNone)
            setGltfCamera(camera, *file, loadGltfMotion(nothing, file), node);
        else if (!file->cameras.empty())
            context.warnings.add(fallbackGltf + ": has no perspective camera in its scene; the view is framed instead");
        camera.placement = loadPlacement(nothing, true);
    }
    table.read("fov_deg", camera.fovY, keyedNumberIn(kFieldOfView, radians(1)));
    table.read("aperture_radius", camera.apertureRadius, keyedNumberIn(kNotNegative));
    table.read("focus_distance", camera.focusDistance, keyedNumberIn(kNotNegative));
    if (!camera.rig) {
        table.read("up", camera.up, keyedVec3In());
        table.read("position", camera.position, keyedVec3In());
        table.read("look_at", camera.lookAt, keyedVec3In());
        if (!aimed) frameCamera(context.scene, camera);
        failOn(table.where(), mistakeInView(camera, context.scene.render.frames));
    }
    table.finish();
}

} // namespace taut
