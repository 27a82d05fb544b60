/// The sections of a scene file that say how it is seen: [render], [camera] and [environment].

#include "taut/base/frame_set.h"
#include "taut/scene/load_context.h"

namespace taut {

namespace {

/// "clip" is what its objects say, once they are there (setClipFrames).
std::vector<int> toFrames(LoadContext &context, const TomlValue &value) {
    if (value.kind == TomlValue::Kind::String && value.text == "clip") {
        context.wholeClip = &value;
        return {1};
    }
    if (value.kind == TomlValue::Kind::Integer) return {static_cast<int>(toInteger(value, kFrameNumber))};
    return parseFrameSet(toText(value), value.where);
}

/// The camera node that [camera] names, else the first.
Index cameraNode(const GltfFile &file, const TomlValue *name, const Location &where) {
    if (name == nullptr) {
        const Index first = firstCameraNode(file);
        if (first == kNone) failInput(where, "no camera in " + file.path, "a glTF file with one");
        return first;
    }
    std::vector<std::string_view> names;
    for (const Index index : file.sceneNodes) {
        const Index camera = file.attached[index].camera;
        if (camera == kNone) continue;
        const std::string &nodeName = file.rig.nodes[index].name;
        if (nodeName == toText(*name)) return index;
        names.push_back(nodeName);
    }
    if (names.empty()) failInput(name->where, quoted(name->text), "a camera's node, but " + file.path + " has none");
    failUnknownName(name->where, name->text, names);
}

void setGltfCamera(Camera &camera, const GltfFile &file, RigMotion motion, Index node) {
    motion.node = node;
    const GltfCamera &lens = file.cameras[file.attached[node].camera];
    camera.fovY = Keyed<double>(static_cast<double>(lens.yFov));
    if (!lens.perspective) camera.orthoHeight = Keyed<double>(2 * static_cast<double>(lens.yMag));
    camera.rig = std::move(motion);
}

} // namespace

void loadRender(LoadContext &context, const TomlValue &section) {
    RenderSettings &render = context.scene.render;
    TableReader table(
        section, "[render]",
        {"width", "height", "spp", "max_events", "frames", "fps", "seed", "fixed_seed", "filter", "shutter", "motion_steps", "ground"});
    table.read("width", render.width, integerIn(kImageSide));
    table.read("height", render.height, integerIn(kImageSide));
    table.read("spp", render.spp, integerIn(kSpp));
    table.read("max_events", render.maxEvents, integerIn(kMaxEvents));
    table.read("frames", render.frames, [&](const TomlValue &value) { return toFrames(context, value); });
    table.read("fps", render.fps, numberIn(kFps));
    table.read("seed", render.seed, integerIn(kSeed));
    table.read("fixed_seed", render.fixedSeed);
    table.read("shutter", render.shutter, numberIn(kShutter));
    table.read("motion_steps", render.motionSteps, integerIn(kMotionSteps));
    table.read("filter", render.boxFilter, oneOf<bool>({{"blackman-harris", false}, {"box", true}}));
    table.read("ground", render.ground);
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
        environment = readEnvironment(filePath(context, *file), rotation, Vec3(scale), context.warnings, context.budget());
    } else if (const TomlValue *radiance = table.find("radiance")) {
        environment = constantEnvironment(Vec3(toTriple(*radiance, kNotNegative) * scale));
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
                      {"position", "look_at", "up", "fov_deg", "ortho_height", "aperture_radius", "focus_distance", "gltf", "node", "clip",
                       "loop", "translate", "rotate_deg", "scale"});
    Camera &camera = context.scene.camera;
    table.exclusive("gltf", "position");
    table.exclusive("gltf", "look_at");
    table.exclusive("gltf", "up");
    const bool aimed = table.find("position") != nullptr || table.find("look_at") != nullptr;
    if (const TomlValue *path = table.find("gltf")) {
        const std::shared_ptr<const GltfFile> file = gltfFile(context, filePath(context, *path));
        const Index node = cameraNode(*file, table.find("node"), path->where);
        setGltfCamera(camera, *file, loadGltfMotion(context, table, file), node);
        camera.placement = loadPlacement(table, true);
    } else if (!aimed && !fallbackGltf.empty()) {
        TableReader nothing(none, "", {});
        const std::shared_ptr<const GltfFile> file = gltfFile(context, fallbackGltf);
        const Index node = firstCameraNode(*file);
        if (node != kNone)
            setGltfCamera(camera, *file, loadGltfMotion(context, nothing, file), node);
        else if (!file->cameras.empty())
            context.warnings.add(fallbackGltf + ": has no camera in its scene; the view is framed instead");
        camera.placement = loadPlacement(nothing, true);
    }
    table.read("fov_deg", camera.fovY, keyedNumberIn(kFieldOfView, radians(1)));
    table.read("ortho_height", camera.orthoHeight, keyedNumberIn(kNotNegative));
    table.read("aperture_radius", camera.apertureRadius, keyedNumberIn(kNotNegative));
    table.read("focus_distance", camera.focusDistance, keyedNumberIn(kNotNegative));
    if (!camera.rig) {
        table.read("up", camera.up, keyedVec3In());
        table.read("position", camera.position, keyedVec3In());
        table.read("look_at", camera.lookAt, keyedVec3In());
        context.scene.unsaid.camera = !aimed;
        if (!aimed) frameCamera(context.scene, camera);
        failOn(table.where(), mistakeInView(camera, context.scene.render.frames));
    }
    table.finish();
}

} // namespace taut
