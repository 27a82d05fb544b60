#include "taut/scene/check_scene.h"

#include "taut/scene/check_parts.h"

#include <set>

namespace taut {

namespace {

/// glTF's index of refraction has no upper end, and 0 stands for what reflects everything.
constexpr Range kAnyIor{kIor.lower, 1e30};
/// Of a camera of a glTF file, degrees.
constexpr Range kAnyFieldOfView{0, 180, true};

void checkRender(const Part &part, const RenderSettings &render) {
    checkInteger(part, "width", render.width, kImageSide);
    checkInteger(part, "height", render.height, kImageSide);
    checkInteger(part, "spp", render.spp, kSpp);
    checkInteger(part, "maxEvents", render.maxEvents, kMaxEvents);
    if (render.frames.empty()) part.fail("frames", "none", "at least one");
    for (const int frame : render.frames) checkInteger(part, "frames", frame, kFrameNumber);
    checkNumber(part, "fps", render.fps, kFps);
    checkNumber(part, "shutter", render.shutter, kShutter);
    checkInteger(part, "motionSteps", render.motionSteps, kMotionSteps);
}

class SceneCheck {
  public:
    explicit SceneCheck(const Scene &scene) : scene_(scene) {}

    void run() {
        checkRender(part("render"), scene_.render);
        for (Index i = 0; i < scene_.textures.size(); ++i) checkTexture(part("textures", i, scene_.textures[i].name), scene_.textures[i]);
        for (Index i = 0; i < scene_.materials.size(); ++i)
            checkMaterial(part("materials", i, scene_.materials[i].name), scene_.materials[i]);
        for (Index i = 0; i < scene_.objects.size(); ++i) checkObject(part("objects", i, scene_.objects[i].name), scene_.objects[i]);
        for (Index i = 0; i < scene_.lights.size(); ++i) checkLight(part("lights", i), scene_.lights[i]);
        if (scene_.environment) checkEnvironment(part("environment"), *scene_.environment);
        checkCamera(part("camera"), scene_.camera);
    }

  private:
    [[nodiscard]] Part part(std::string_view list, Index index = kNone, std::string_view name = {}) const {
        return {scene_.path, list, index, name};
    }

    /// A texture multiplies the value by what it holds, so the range is that of a value alone.
    void checkParam(const Part &at, std::string_view member, const FloatParam &param, const Range &range) const {
        checkOptionalIndex(at, member, param.texture, scene_.textures.size(), "textures");
        checkInteger(at, member, param.channel, {0, 3});
        checkNumber(at, member, param.value, param.texture == kNone ? range : kAnyNumber);
    }
    void checkParam(const Part &at, std::string_view member, const ColorParam &param, const Range &range) const {
        checkOptionalIndex(at, member, param.texture, scene_.textures.size(), "textures");
        checkVector(at, member, DVec3(param.value), param.texture == kNone ? range : kAnyNumber);
    }

    void checkSlopes(const Part &at, std::string_view member, const SlopeMap &map) const {
        checkOptionalIndex(at, member, map.texture, scene_.textures.size(), "textures");
        checkNumber(at, member, map.scale, kAnyNumber);
    }

    void checkTexture(const Part &at, const Texture &texture) const {
        checkInteger(at, "width", texture.width, kImageSide);
        checkInteger(at, "height", texture.height, kImageSide);
        if (texture.channels != 1 && texture.channels != 3 && texture.channels != 4)
            at.fail("channels", std::to_string(texture.channels), "1, 3 or 4");
        checkCount(at, "texels", texture.texels.size(),
                   static_cast<std::size_t>(texture.width) * static_cast<std::size_t>(texture.height) *
                       static_cast<std::size_t>(texture.channels));
        checkEach(at, "texels", texture.texels.size(), "a value that is not finite", "finite values",
                  [&](std::size_t i) { return !std::isfinite(texture.texels[i]); });
    }

    void checkMaterial(const Part &at, const Material &material) const {
        checkParam(at, "color", material.color, kUnitInterval);
        checkVector(at, "conductorEta", DVec3(material.conductorEta), kNotNegative);
        checkVector(at, "conductorK", DVec3(material.conductorK), kNotNegative);
        const Range &alpha = material.alphaIsRoughness ? kUnitInterval : kAlpha;
        checkParam(at, "alphaX", material.alphaX, alpha);
        checkParam(at, "alphaY", material.alphaY, alpha);
        checkParam(at, "rotation", material.rotation, kAnyNumber);
        if (material.ior != 0) checkNumber(at, "ior", material.ior, kAnyIor);
        checkParam(at, "metallic", material.metallic, kUnitInterval);
        checkOptionalIndex(at, "anisotropyTexture", material.anisotropyTexture, scene_.textures.size(), "textures");
        checkNumber(at, "anisotropyStrength", material.anisotropyStrength,
                    material.anisotropyTexture == kNone ? kUnitInterval : kAnyNumber);
        checkNumber(at, "poisson", material.poisson, kPoisson);
        at.failOn("multiscatter", mistakeInMultiscatter(material));
        checkSlopes(at, "slopes", material.slopes);
        checkSlopes(at, "coatSlopes", material.coatSlopes);
        checkNumber(at, "roughening", material.roughening, kNotNegative);
        checkNumber(at, "yield", material.yield, kNotNegative);
        checkPresence(at, material);
        checkLayers(at, material);
    }

    void checkPresence(const Part &at, const Material &material) const {
        checkParam(at, "opacity", material.opacity, kUnitInterval);
        checkNumber(at, "alphaCutoff", material.alphaCutoff, kNotNegative);
    }

    void checkLayers(const Part &at, const Material &material) const {
        checkParam(at, "specular", material.specular, kUnitInterval);
        checkParam(at, "specularColor", material.specularColor, kNotNegative);
        checkParam(at, "transmission", material.transmission, kUnitInterval);
        checkVector(at, "attenuationColor", DVec3(material.attenuationColor), kUnitInterval);
        if (material.attenuationDistance < kInfinity) checkNumber(at, "attenuationDistance", material.attenuationDistance, kPositive);
        checkParam(at, "clearcoat", material.clearcoat, kUnitInterval);
        checkParam(at, "clearcoatRoughness", material.clearcoatRoughness, kUnitInterval);
        checkParam(at, "sheenColor", material.sheenColor, kUnitInterval);
        checkParam(at, "sheenRoughness", material.sheenRoughness, kUnitInterval);
        checkParam(at, "iridescence", material.iridescence, kUnitInterval);
        checkNumber(at, "iridescenceIor", material.iridescenceIor, kFilmIor);
        checkNumber(at, "iridescenceMin", material.iridescenceMin, kNotNegative);
        checkNumber(at, "iridescenceMax", material.iridescenceMax, kNotNegative);
        checkParam(at, "thickness", material.thickness, kUnitInterval);
    }

    void checkPlacement(const Part &at, const Placement &placement) const {
        checkKeys(at, "placement.translation", placement.translation);
        checkKeys(at, "placement.rotation", placement.rotation);
        checkKeys(at, "placement.scale", placement.scale);
        for (int c = 0; c < 4; ++c) checkVector(at, "placement.worldFromUp", DVec3(placement.worldFromUp[c]));
    }

    void checkRigMotion(const Part &at, const RigMotion &motion) {
        if (!motion.rig) at.fail("rig.rig", "none", "a rig");
        if (checked_.insert(motion.rig.get()).second) checkRig(at, *motion.rig);
        checkMotion(at, motion);
    }

    /// The joints that a mesh names must be those of the skin that moves it.
    void checkJoints(const Part &at, const Object &object) const {
        const Rig &rig = *object.rig->rig;
        const Index skin = rig.nodes[object.rig->node].skin;
        if (skin == kNone || object.mesh->skin.empty()) return;
        const std::vector<Index> &joints = object.mesh->skin.joints;
        const std::size_t count = rig.skins[skin].joints.size();
        checkEach(at, "mesh.skin.joints", joints.size(), "an index beyond the " + std::to_string(count) + " joints of the skin",
                  "an index of one", [&](std::size_t i) { return joints[i] >= count; });
    }

    void checkSurface(const Part &at, const Object &object) const {
        checkInteger(at, "subdivision.level", object.subdivision.level, {0, kReferenceLevel});
        checkNumber(at, "subdivision.creaseAngle", object.subdivision.creaseAngle, kCreaseAngle, radians(1));
        at.failOn("subdivision.scheme", mistakeInScheme(object));
        at.failOn("gradient", mistakeInGradient(object));
        at.failOn("lean", mistakeInLean(object));
        checkNumber(at, "rest.frame", object.rest.frame, kAnyNumber);
    }

    void checkObject(const Part &at, const Object &object) {
        if (!object.mesh) at.fail("mesh", "none", "a mesh");
        if (checked_.insert(object.mesh.get()).second) checkMesh(at, *object.mesh);
        if (object.materials.empty()) at.fail("materials", "none", "at least one");
        for (const Index material : object.materials) checkIndex(at, "materials", material, scene_.materials.size(), "materials");
        if (object.rig) {
            checkRigMotion(at, *object.rig);
            checkJoints(at, object);
        }
        if (object.points && object.points->points() != object.mesh->positions.size())
            at.fail("points", std::to_string(object.points->points()) + " points",
                    "as many as the mesh has positions, " + std::to_string(object.mesh->positions.size()));
        for (const DeformerKeys &deformer : object.deformers) checkDeformer(at, deformer);
        checkPlacement(at, object.placement);
        checkSurface(at, object);
        checkParam(at, "emission", object.emission, kNotNegative);
        checkOptionalIndex(at, "emissionGroup", object.emissionGroup, scene_.lightGroups.size(), "lightGroups");
        for (const Emission &emission : object.slotEmission)
            checkOptionalIndex(at, "slotEmission", emission.group, scene_.lightGroups.size(), "lightGroups");
        if (!object.slotEmission.empty()) checkCount(at, "slotEmission", object.slotEmission.size(), object.materials.size());
        for (const Emission &emission : object.slotEmission) checkParam(at, "slotEmission", emission.radiance, kNotNegative);
    }

    /// The words for a light's keys (scene/lights/): here they are held to their ranges.
    struct LightKeys {
        const Part &at;
        const Light &light;

        void brightness(std::string_view /*key*/) const { checkVector(at, "radiance", DVec3(light.radiance), kNotNegative); }
        void cameraVisible() const {}
        void vector(std::string_view key, const DVec3 &value) const { checkVector(at, key, value); }
        void direction(std::string_view key, const DVec3 &value) const {
            checkVector(at, key, value);
            if (!isWithin({1, 1}, glm::length(value))) at.fail(key, "another length", "a vector of length 1");
        }
        void length(std::string_view key, const double &value) const { checkNumber(at, key, value, kPositive); }
        void coneAngle(std::string_view key, const double &value) const { checkNumber(at, key, value, kConeAngle, radians(1)); }
        void flag(std::string_view /*key*/, bool /*value*/) const {}
    };

    void checkLight(const Part &at, const Light &light) const {
        checkOptionalIndex(at, "group", light.group, scene_.lightGroups.size(), "lightGroups");
        std::visit(
            [&](auto shape) {
                LightKeys keys{at, light};
                shape.read(keys);
                if constexpr (requires { shape.innerAngle; })
                    if (shape.innerAngle == shape.outerAngle) return; // a glTF file may say so: an edge without a fade
                if constexpr (requires { shape.fault(); })
                    if (const auto fault = shape.fault()) at.fail("", std::string(fault->found), std::string(fault->expected));
            },
            light.shape);
    }

    static void checkEnvironment(const Part &at, const Environment &environment) {
        checkInteger(at, "width", environment.width, kImageSide);
        checkInteger(at, "height", environment.height, kImageSide);
        const auto width = static_cast<std::size_t>(environment.width);
        const auto height = static_cast<std::size_t>(environment.height);
        if (environment.texels.empty()) at.fail("texels", "none", "at least one");
        checkEach(at, "texels", environment.texels.size(), "a radiance that is negative or not finite", "radiances of at least 0",
                  [&](std::size_t i) {
                      const Vec3 &texel = environment.texels[i];
                      return !isFinite(texel) || texel.x < 0 || texel.y < 0 || texel.z < 0;
                  });
        checkNumber(at, "rotation", environment.rotation, kAnyNumber);
        checkVector(at, "mean", DVec3(environment.mean), kNotNegative);
        if (environment.constant) return;
        checkCount(at, "texels", environment.texels.size(), width * height);
        const bool ready = environment.table.size() == height * (1 + width) && environment.guide.size() == environment.table.size() &&
                           environment.rowHeight.size() == height + 1;
        if (!ready) at.fail("table", "no tables for sampling", "those that buildSampling() makes");
    }

    void checkCamera(const Part &at, const Camera &camera) {
        checkKeys(at, "fovY", camera.fovY, camera.rig ? kAnyFieldOfView : kFieldOfView, radians(1));
        checkKeys(at, "orthoHeight", camera.orthoHeight, kNotNegative);
        checkKeys(at, "apertureRadius", camera.apertureRadius, kNotNegative);
        checkKeys(at, "focusDistance", camera.focusDistance, kNotNegative);
        checkPlacement(at, camera.placement);
        if (camera.rig) return checkRigMotion(at, *camera.rig);
        for (const Keyed<DVec3> *keyed : {&camera.position, &camera.lookAt, &camera.up}) checkKeys(at, "position, lookAt or up", *keyed);
        at.failOn("", mistakeInView(camera, scene_.render.frames));
    }

    const Scene &scene_;
    std::set<const void *> checked_; // meshes and rigs that objects share
};

} // namespace

void check(const Scene &scene) {
    SceneCheck(scene).run();
}

} // namespace taut
